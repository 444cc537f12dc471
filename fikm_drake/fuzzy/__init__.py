"""The fuzzy engine: memberships, partitions and inference. It knows no robot.

`fuzzy.mamdani` has rules whose conclusions are memberships. The rest of this text is about rules
whose conclusions are numbers.

An input x is described by triangular memberships A_1 ... A_n, peaks at the knots x_1 < ... < x_n
(`TriangularPartition`). Between two knots only their memberships are not zero,

    A_i(x) = 1 - f,   A_{i+1}(x) = f,   f = (x - x_i) / (x_{i+1} - x_i),

and the grades always sum to one. A `RuleBase` has a rule "IF x is A_i AND y is B_j THEN z is w_ij"
for every pair. With the product as AND its output, equations 16-19 of Xu and Nechyba (1993),

    z(x, y) = sum_ij A_i(x) B_j(y) w_ij,

is the bilinear interpolation of w on the grid of knots, constant beyond the outermost ones.
"""

from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

__all__ = ["RuleBase", "TriangularPartition"]
