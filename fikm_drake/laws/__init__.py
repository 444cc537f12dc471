"""Differential-IK laws and the small steps around them: pure functions, no blocks.

A law maps a Jacobian J (m×n) and a task error dr (m) to a joint step dθ (n). The fuzzy inverse
kinematic mapping of Xu & Nechyba 1993 is dθ = C⁻¹ Jᵀ R⁻¹ dr with the absolute row sums R and column
sums C of J, one step of the simultaneous algebraic reconstruction technique: with J frozen it is
stable for every gain 0 < K < 2.
"""
