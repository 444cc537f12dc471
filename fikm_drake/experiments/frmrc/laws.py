"""The laws that paper 3's experiments compare."""

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse

PAPER, ONE, THREE, FIXED = "paper", "smooth", "smooth, 3 sweeps", "smooth, fixed universes"
RMRC = "pseudo-inverse"


def laws(arm: DhArm, task: str) -> dict[str, Law]:
    """Each variant with its default gain, and resolved-rate control by the pseudo-inverse."""
    return {
        PAPER: FuzzyRateControl.for_arm(arm, "paper", task=task),
        FIXED: FuzzyRateControl.for_arm(arm, task=task),
        ONE: FuzzyRateControl(),
        THREE: FuzzyRateControl(sweeps=3),
        RMRC: PseudoInverse(),
    }
