"""What `fikm-drake benchmark` runs: ours beside others on the same job, at the same tolerance and limits.

A benchmark is a file with a function from a count to a table; `registry` names them. Peers that are not
installed are left out and said to be. Times are CPU times, the contenders in turn in one process
(`interleaved`).
"""
