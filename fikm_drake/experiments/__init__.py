"""What the commands `fikm-drake benchmark` and `fikm-drake reproduce` run: costs, and papers' results.

`benchmarks/` has one file a benchmark and a registry of them; `reproduce/` one folder a paper. What may
enter: code that prints figures. Nothing of the library imports it but `cli`.
"""
