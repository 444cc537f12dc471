"""Inference in integers only, for small processors (Tojo & Morishita 2010). It knows no robot.

Two integer inputs are described by triangular memberships with integer peaks (`IntegerPartition`),
grades from 0 to 255. An `IntegerRuleBase` has one rule for every pair of memberships, with a
singleton for each output, and gives the average of the singletons weighted by the rules' grades
ω = A(x) ∧ B(y), equation 5. The max of equation 4 changes nothing there: each rule has a singleton
of its own. ∧ is `min` as in the paper or `product`.

At most two memberships of an input are not zero, so at most four rules count: those at the corners
of the cell that holds (x, y). The cell is found once for all outputs. `write_c` writes the same
integers as C99.
"""

from fikm_drake.fuzzy.integer.cell_weights import cell_weights, interpolate
from fikm_drake.fuzzy.integer.fit_singletons import fit_singletons
from fikm_drake.fuzzy.integer.integer_partition import IntegerPartition
from fikm_drake.fuzzy.integer.integer_rule_base import IntegerRuleBase
from fikm_drake.fuzzy.integer.write_c import SHAPES, write_c

__all__ = [
    "SHAPES",
    "IntegerPartition",
    "IntegerRuleBase",
    "cell_weights",
    "fit_singletons",
    "interpolate",
    "write_c",
]
