"""Rules for dθ ≈ dr / J, generated from data (Xu & Nechyba 1993, section 2.5).

`generate_rule_base` finds knots and consequents for dθ ≈ dr / J, equation 4, from the table of
equation 12, whose vectors have |dθ| <= dr_max / j_max. Near J = 0 the rules stay bounded where the
quotient does not. Since z is linear in dr at each J, and dθ is odd in dr and in J, all the work is
in placing the knots of J. `generate_araki` is the paper's online method; `generate_least_squares`
needs fewer rules for a smaller true error.
"""

from fikm_drake.laws.rule_generation.araki import generate_araki
from fikm_drake.laws.rule_generation.data_table import data_table, quarter_table, table_error
from fikm_drake.laws.rule_generation.generate import METHODS, generate_rule_base
from fikm_drake.laws.rule_generation.generated_rule_base import GeneratedRuleBase, Split
from fikm_drake.laws.rule_generation.least_squares import generate_least_squares

__all__ = [
    "METHODS",
    "GeneratedRuleBase",
    "Split",
    "data_table",
    "generate_araki",
    "generate_least_squares",
    "generate_rule_base",
    "quarter_table",
    "table_error",
]
