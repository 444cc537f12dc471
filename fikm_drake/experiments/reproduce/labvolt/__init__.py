"""Paper 4, Elsharif, Drawil & Elbuni: tables and figures (`fikm-drake reproduce labvolt`)."""

from fikm_drake.experiments.reproduce.labvolt.figures import figure_5, figure_6, figure_9
from fikm_drake.experiments.reproduce.labvolt.findings import reach, rounding, rules, starts
from fikm_drake.experiments.reproduce.labvolt.open_choices import readings
from fikm_drake.experiments.reproduce.labvolt.square import square
from fikm_drake.experiments.reproduce.labvolt.tables import table_3, table_4
from fikm_drake.experiments.reproduce.report import Experiment

EXPERIMENTS: dict[str, Experiment] = {
    "rules": rules,
    "figure 5": figure_5,
    "figure 6": figure_6,
    "table 3": table_3,
    "figure 9": figure_9,
    "table 4": table_4,
    "starts": starts,
    "reach": reach,
    "readings": readings,
    "rounding": rounding,
    "square": square,
}
"""What can be reproduced."""
