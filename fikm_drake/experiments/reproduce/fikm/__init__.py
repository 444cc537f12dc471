"""Paper 1, Xu & Nechyba 1993: every table and figure with numbers (`fikm-drake reproduce fikm`)."""

from fikm_drake.experiments.reproduce.fikm.ablation import ablation
from fikm_drake.experiments.reproduce.fikm.claims import claims
from fikm_drake.experiments.reproduce.fikm.costs import direct, table_7, times
from fikm_drake.experiments.reproduce.fikm.default_config import default
from fikm_drake.experiments.reproduce.fikm.lost_numbers import readings
from fikm_drake.experiments.reproduce.fikm.past import past, supervise, torque
from fikm_drake.experiments.reproduce.fikm.random_curves import spread
from fikm_drake.experiments.reproduce.fikm.rules import table_1, table_2
from fikm_drake.experiments.reproduce.fikm.stability import stability
from fikm_drake.experiments.reproduce.fikm.tracking import (
    figure_11,
    figure_12,
    figure_13,
    figure_16,
    figure_19,
    figure_21,
    table_6,
)
from fikm_drake.experiments.reproduce.report import Experiment

EXPERIMENTS: dict[str, Experiment] = {
    "table 1": table_1,
    "table 2": table_2,
    "figure 11": figure_11,
    "figure 12": figure_12,
    "figure 13": figure_13,
    "figure 16": figure_16,
    "figure 19": figure_19,
    "figure 21": figure_21,
    "table 6": table_6,
    "readings": readings,
    "spread": spread,
    "default": default,
    "direct": direct,
    "ablation": ablation,
    "past": past,
    "table 7": table_7,
    "times": times,
    "claims": claims,
    "stability": stability,
    "torque": torque,
    "supervise": supervise,
}
"""What can be reproduced, in the paper's order."""
