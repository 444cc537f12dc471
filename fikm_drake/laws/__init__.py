"""Differential-IK laws and the small steps around them: pure functions, no blocks.

A law maps a Jacobian J (m×n) and a task error dr (m) to a joint step dθ (n). The fuzzy inverse
kinematic mapping of Xu & Nechyba 1993 is dθ = C⁻¹ Jᵀ R⁻¹ dr with the absolute row sums R and column
sums C of J, one step of the simultaneous algebraic reconstruction technique: with J frozen it is
stable for every gain 0 < K < 2.
"""

from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.jacobian_transpose import JacobianTranspose
from fikm_drake.laws.law import Law, LawLike, as_law
from fikm_drake.laws.pseudo_inverse import PseudoInverse

__all__ = [
    "LAWS",
    "DampedLeastSquares",
    "FuzzyMapping",
    "FuzzyRateControl",
    "JacobianTranspose",
    "Law",
    "LawConfig",
    "LawLike",
    "PseudoInverse",
    "checked_law",
    "named_law",
]

LawConfig = FuzzyMapping | DampedLeastSquares | PseudoInverse | JacobianTranspose | FuzzyRateControl
"""The laws that YAML can name by a tag, `law: !DampedLeastSquares {damping: 0.05}`; without a tag the
first. A new law with a name is added here."""

LAWS: dict[str, type] = {law.__name__: law for law in LawConfig.__args__}
"""Laws by name."""


def named_law(name: str) -> LawConfig:
    """The law of this name with its default options, as `fikm-drake run --law NAME` has it.

    Raises:
        ValueError: there is none; the message lists the names.
    """
    if name not in LAWS:
        raise ValueError(f"law must be one of {tuple(LAWS)}, got {name!r}")
    return LAWS[name]()


def checked_law(law: LawLike, size: int, num_joints: int) -> Law:
    """The law for m = `size` rows and n = `num_joints` joints, checked by one call.

    Raises:
        ValueError: it is no law, raises, or gives something else than n finite numbers; the message
            lists the laws.
    """
    return as_law(law, size, num_joints, known=LAWS)
