"""A scenario, run in Drake's Simulator, becomes a log; a log becomes metrics, plots, tables and pages.

What may enter: what needs a Simulator or its log. Blocks and their wiring are in `systems` and `diagrams`.
"""
