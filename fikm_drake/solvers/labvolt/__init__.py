"""The LabVolt 5250 arm: exact, fuzzy and numerical inverse kinematics, and hybrids of them.

M. Elsharif, N. Drawil and M. S. Elbuni, "Optimizing inverse kinematic solutions using fuzzy logic".
Three joints in a vertical plane put the tool on a point,

    x = a_1 cos θ_1 + a_2 cos θ_2 + a_3 cos θ_3,   y = a_1 sin θ_1 + a_2 sin θ_2 + a_3 sin θ_3

(equations 1 and 2), so one degree of freedom is left over. The angles θ are absolute, from the
horizontal; limits are of the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2, which are the joints of
`models/labvolt5250.yaml` after its turning base. Inside this package angles are relative, one column
a target; what users give and get is absolute, one row a target.
"""

from fikm_drake.solvers.labvolt.cell import gripper_urdf, save_servo_counts
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts, initial_guess
from fikm_drake.solvers.labvolt.geometry import (
    forward_kinematics,
    from_servo_counts,
    to_absolute,
    to_relative,
    to_servo_counts,
)
from fikm_drake.solvers.labvolt.methods import METHODS
from fikm_drake.solvers.labvolt.plane_targets import random_targets
from fikm_drake.solvers.labvolt.solution import LabVoltSolution, LabVoltStatus
from fikm_drake.solvers.labvolt.solve import solve

__all__ = [
    "METHODS",
    "FuzzyStarts",
    "LabVoltSolution",
    "LabVoltStatus",
    "forward_kinematics",
    "from_servo_counts",
    "gripper_urdf",
    "initial_guess",
    "random_targets",
    "save_servo_counts",
    "solve",
    "to_absolute",
    "to_relative",
    "to_servo_counts",
]
