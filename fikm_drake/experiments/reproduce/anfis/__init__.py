"""Paper 2, Hassantabar 2021: its figures with numbers (`fikm-drake reproduce anfis`)."""

from fikm_drake.experiments.reproduce.anfis.accuracy import accuracy
from fikm_drake.experiments.reproduce.anfis.arms_without_closed_form import no_closed_form
from fikm_drake.experiments.reproduce.anfis.feasible_regions import figure_3_6, figure_3_13
from fikm_drake.experiments.reproduce.anfis.learning import figure_4_8
from fikm_drake.experiments.reproduce.anfis.mid_points import figure_3_16
from fikm_drake.experiments.reproduce.anfis.minimum_norm import minimum_norm
from fikm_drake.experiments.reproduce.anfis.open_choices import readings
from fikm_drake.experiments.reproduce.anfis.postures import figure_3_7, figure_3_8, figure_3_12
from fikm_drake.experiments.reproduce.anfis.seven_joints import freedom
from fikm_drake.experiments.reproduce.anfis.structures import structures
from fikm_drake.experiments.reproduce.anfis.three_ways import algorithm_1, exactness
from fikm_drake.experiments.reproduce.anfis.validation import figure_4_12, figure_4_16, resolution
from fikm_drake.experiments.reproduce.report import Experiment

EXPERIMENTS: dict[str, Experiment] = {
    "figure 3.6": figure_3_6,
    "figure 3.7": figure_3_7,
    "figure 3.8": figure_3_8,
    "figure 3.12": figure_3_12,
    "figure 3.13": figure_3_13,
    "figure 3.16": figure_3_16,
    "minimum norm": minimum_norm,
    "algorithm 1": algorithm_1,
    "exactness": exactness,
    "figure 4.8": figure_4_8,
    "accuracy": accuracy,
    "figure 4.12": figure_4_12,
    "figure 4.16": figure_4_16,
    "resolution": resolution,
    "readings": readings,
    "structures": structures,
    "no closed form": no_closed_form,
    "freedom": freedom,
}
"""What can be reproduced, in the thesis's order."""
