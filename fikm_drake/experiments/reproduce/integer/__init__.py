"""Paper 5, Tojo & Morishita 2010: its tables, its traces, and past them (`fikm-drake reproduce integer`)."""

from fikm_drake.experiments.reproduce.integer.errors import arms, errors, integers, order
from fikm_drake.experiments.reproduce.integer.microcontroller import mcu
from fikm_drake.experiments.reproduce.integer.open_choices import readings
from fikm_drake.experiments.reproduce.integer.table_1 import figure_4, table_1
from fikm_drake.experiments.reproduce.integer.table_2 import export, table_2
from fikm_drake.experiments.reproduce.integer.traces import figure_7, figure_9, figure_11
from fikm_drake.experiments.reproduce.report import Experiment

EXPERIMENTS: dict[str, Experiment] = {
    "table 1": table_1,
    "figure 4": figure_4,
    "figure 7": figure_7,
    "figure 9": figure_9,
    "figure 11": figure_11,
    "table 2": table_2,
    "mcu": mcu,
    "readings": readings,
    "errors": errors,
    "order": order,
    "integers": integers,
    "arms": arms,
    "export": export,
}
"""What can be reproduced: the paper's in its order, then what goes past it."""
