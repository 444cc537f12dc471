"""The laws that paper 3's experiments compare."""

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse

PAPER, ONE, THREE, FIXED = "paper", "smooth", "smooth, 3 sweeps", "smooth, fixed universes"
RMRC = "pseudo-inverse"
ALLOWED = {
    "line": {FIXED: 3.0, ONE: 3.0, THREE: 1.5},
    "circle": {FIXED: 5.0, ONE: 5.0, THREE: 2.0},
}
"""The largest error that we claim on each path, over that of the pseudo-inverse [-]."""
SETTLED = 0.01
"""What we call zero [mm]."""


def laws(arm: DhArm, task: str) -> dict[str, Law]:
    """Each variant with its default gain, and resolved-rate control by the pseudo-inverse."""
    return {
        PAPER: FuzzyRateControl.for_arm(arm, "paper", task=task),
        FIXED: FuzzyRateControl.for_arm(arm, task=task),
        ONE: FuzzyRateControl(),
        THREE: FuzzyRateControl(sweeps=3),
        RMRC: PseudoInverse(),
    }
