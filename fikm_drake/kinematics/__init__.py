"""Arms: Denavit-Hartenberg tables, forward kinematics, Jacobians and their ranges, URDF.

A modified (Craig) row means T_i = Rx(α_{i-1}) Tx(a_{i-1}) Rz(θ_i) Tz(d_i), so a URDF joint is
exact: its origin is Rx(α) Tx(a) Rz(θ offset) Tz(d offset) and its axis z. The Jacobian's column of
a revolute joint is [z_j; z_j × (p_tool − p_j)], of a prismatic one [0; z_j], in the base frame.
"""
