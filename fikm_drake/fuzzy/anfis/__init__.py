"""Fuzzy rules learned from data: memberships on a grid, rules that are linear in the inputs.

The output of an ANFIS (Jang 1993) with inputs x, y scaled to [−1, 1] is

    z = Σ_ij w_ij (p_ij + q_ij x + r_ij y),   w_ij = A_i(x) B_j(y) / Σ_kl A_k(x) B_l(y).

Since the rules are all pairs, w_ij = a_i(x) b_j(y) with a_i = A_i / Σ_k A_k and b_j alike. Given the premises
(parameters of A and B) the coefficients p, q, r are a linear least squares problem. At its solution the
error depends on the premises only, and its gradient is the one with the coefficients held: so the hybrid
rule is gradient descent on the projected error, and variable projection (Golub and Pereyra 1973,
Kaufman 1975) is the same with Levenberg-Marquardt steps. There, derivatives by the logarithms of grades
are short: ∂z/∂log A_i = a_i (z_i − z), where z_i is the output if only membership i were true.
"""

from fikm_drake.fuzzy.anfis.anfis import Anfis

__all__ = ["Anfis"]
