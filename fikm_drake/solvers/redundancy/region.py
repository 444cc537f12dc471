"""What `RedundancyResolver` needs to know of an arm."""

from dataclasses import dataclass
from typing import Protocol

from fikm_drake.arrays import Array, Bools


@dataclass(frozen=True)
class Middle:
    """Postures in the middle of the exact bounds of the redundant joint, for N points."""

    q: Array
    """(N,n) [rad or m]; arbitrary where there is none inside the limits."""
    inside: Bools
    """(N,): whether there is one inside the limits."""
    lower: Array
    """(N,) lower bound of the joint [rad or m]."""
    upper: Array
    """(N,) upper bound of the joint [rad or m]."""


class Region(Protocol):
    """The feasible region of one joint of an arm, for valid points: in closed form, or traced."""

    def postures(self, points: Array, joint_position: Array) -> tuple[Array, Bools]:
        """Postures (N,n) with the joint at given positions (N,), and which are inside the limits."""

    def middle(self, points: Array) -> Middle:
        """Postures in the middle of the widest exact interval."""
