"""Paper 3, Kim & Lee 1993: Table 1, figures 4, 6 and 7, and past them (`fikm-drake reproduce frmrc`)."""

from fikm_drake.experiments.reproduce.frmrc.look_up import look_up_table
from fikm_drake.experiments.reproduce.frmrc.open_choices import readings
from fikm_drake.experiments.reproduce.frmrc.past import controller, descent, out_of_reach
from fikm_drake.experiments.reproduce.frmrc.random_lines import lines, starts
from fikm_drake.experiments.reproduce.frmrc.rules import table_1
from fikm_drake.experiments.reproduce.frmrc.tracking import cycles, figure_6, figure_7
from fikm_drake.experiments.reproduce.report import Experiment

EXPERIMENTS: dict[str, Experiment] = {
    "table 1": table_1,
    "figure 6": figure_6,
    "figure 7": figure_7,
    "cycles": cycles,
    "readings": readings,
    "starts": starts,
    "lines": lines,
    "descent": descent,
    "look-up table": look_up_table,
    "controller": controller,
    "out of reach": out_of_reach,
}
"""What can be reproduced, the paper's first."""
