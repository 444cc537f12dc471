"""Many targets at once: damped steps of the scaled mapping from many starts, side by side.

Scaled by the fuzzy mapping's row sums R and column sums C a Jacobian S = R^-½ J C^-½ has norm at most 1,
whatever the units. A step minimises |S x − R^-½ e|² + λ² |x|², dθ = C^-½ x, with λ² between 1e-6 at the
target and what a far error asks for: one set of constants for all arms. A start that makes no progress
is given up, and its target gets another from a pool of postures.

What may enter: code over lanes (…,N) without a loop over targets; nothing of blocks.
"""
