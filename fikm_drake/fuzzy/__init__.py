"""The fuzzy engine: memberships, inference and the generation of rules. It knows no robot.

`fuzzy.mamdani` has rules whose conclusions are memberships. The rest of this text is about rules
whose conclusions are numbers.

An input x is described by triangular memberships A_1 ... A_n, peaks at the knots x_1 < ... < x_n
(`TriangularPartition`). Between two knots only their memberships are not zero,

    A_i(x) = 1 - f,   A_{i+1}(x) = f,   f = (x - x_i) / (x_{i+1} - x_i),

and the grades always sum to one. A `RuleBase` has a rule "IF x is A_i AND y is B_j THEN z is w_ij"
for every pair. With the product as AND its output, equations 16-19 of Xu and Nechyba (1993),

    z(x, y) = sum_ij A_i(x) B_j(y) w_ij,

is the bilinear interpolation of w on the grid of knots, constant beyond the outermost ones.

`generate_rule_base` finds knots and consequents for dθ ≈ dr / J, equation 4, from the table of
equation 12, whose vectors have |dθ| <= dr_max / j_max. Near J = 0 the rules stay bounded where the
quotient does not. Since z is linear in dr at each J, and dθ is odd in dr and in J, all the work is
in placing the knots of J. `generate_araki` is the paper's online method; `generate_least_squares`
needs fewer rules for a smaller true error.
"""

from fikm_drake.fuzzy.araki import generate_araki
from fikm_drake.fuzzy.data_table import data_table, quarter_table, table_error
from fikm_drake.fuzzy.generate import METHODS, generate_rule_base
from fikm_drake.fuzzy.generated_rule_base import GeneratedRuleBase
from fikm_drake.fuzzy.least_squares import generate_least_squares
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.split import Split
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

__all__ = [
    "METHODS",
    "GeneratedRuleBase",
    "RuleBase",
    "Split",
    "TriangularPartition",
    "data_table",
    "generate_araki",
    "generate_least_squares",
    "generate_rule_base",
    "quarter_table",
    "table_error",
]
