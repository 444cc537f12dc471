"""Redundancy (Hassantabar 2021): one joint in the middle of its feasible interval, the rest follow.

For a target x the redundant joint may be anywhere in [l(x), u(x)] (`self_motion`). It is put at (l +
u)/2, with the bounds exact (a `Region`) or learned by two ANFIS (`LearnedBounds`); the other joints then
solve a square system. Learned bounds err, so each posture is verified by forward kinematics and limits,
and repaired by the exact region.

What may enter: choices among postures, each with a status that says learned, repaired or infeasible.
"""
