"""Drake LeafSystems: ports, state and events; their arithmetic is called from `laws` and `kinematics`.

Every block that computes in Python checks its inputs: NaN and infinity give `valid` 0 and a held
command, never a NaN at an output. Blocks keep nothing of a run but in their Context.
"""
