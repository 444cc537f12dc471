"""An arm's Denavit-Hartenberg table: the dataclasses that a YAML file of `models/` is read into."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import inf

from fikm_drake.checks import check_finite, check_number

CONVENTIONS = ("craig", "standard")
JOINT_TYPES = ("revolute", "prismatic")


@dataclass
class DhTransform:
    """Four Denavit-Hartenberg numbers: angles [rad], lengths [m]."""

    alpha: float = 0.0
    """Twist [rad]."""
    a: float = 0.0
    """Link length [m]."""
    d: float = 0.0
    """Joint offset [m]."""
    theta: float = 0.0
    """Joint angle [rad]."""

    def validate(self, where: str) -> None:
        """Raise ValueError, naming `where` and the number, unless all four are finite."""
        for name in ("alpha", "a", "d", "theta"):
            check_finite(f"{where}: {name}", getattr(self, name))


@dataclass
class DhJoint(DhTransform):
    """One row of the table and the joint that moves in it.

    The joint variable adds to `theta` of a revolute joint [rad], to `d` of a prismatic one [m];
    the number in the row is its offset. Limits are of the joint variable, in rad or m.
    """

    type: str = "revolute"
    """`revolute` or `prismatic`."""
    lower: float | None = None
    """Lower limit [rad or m]; None: no limit."""
    upper: float | None = None
    """Upper limit [rad or m]; None: no limit."""
    velocity: float | None = None
    """Limit of the speed [rad/s or m/s]; None: no limit."""

    @property
    def is_revolute(self) -> bool:
        """True for a revolute joint, False for a prismatic one."""
        return self.type == "revolute"

    @property
    def limits(self) -> tuple[float, float]:
        """Lower and upper limit [rad or m], infinite where there is none."""
        lower = -inf if self.lower is None else float(self.lower)
        upper = inf if self.upper is None else float(self.upper)
        return lower, upper

    def validate(self, where: str) -> None:
        """Raise ValueError, naming `where` and the bad value, unless the row describes a joint."""
        super().validate(where)
        if self.type not in JOINT_TYPES:
            raise ValueError(f"{where}: type must be one of {JOINT_TYPES}, got {self.type!r}")
        for name in ("lower", "upper", "velocity"):
            value = getattr(self, name)
            if value is not None:
                check_number(f"{where}: {name}", value, "a number or None", lambda x: x == x)
        lower, upper = self.limits
        if not lower < upper:
            raise ValueError(f"{where}: lower must be less than upper, got {lower} and {upper}")
        if self.velocity is not None and not self.velocity > 0:
            raise ValueError(f"{where}: velocity must be positive, got {self.velocity!r}")


@dataclass
class DhTable:
    """A whole arm as its Denavit-Hartenberg table.

    `craig` (modified) rows hold α_{i-1}, a_{i-1}, d_i, θ_i and mean
    Rx(α) Tx(a) Rz(θ) Tz(d); `standard` rows mean Rz(θ) Tz(d) Tx(a) Rx(α).
    """

    name: str = ""
    """The arm's name: a letter, then letters, digits, `_` or `-`."""
    convention: str = "craig"
    """`craig` or `standard`."""
    joints: list[DhJoint] = field(default_factory=list)
    """One row a joint, from the base outward."""
    tool: DhTransform = field(default_factory=DhTransform)
    """The last, fixed row, read in the same convention."""

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones, unless this is an arm."""
        if not self.name or not self.name[0].isalpha() or not _is_identifier(self.name):
            raise ValueError(
                f"arm name must be a letter followed by letters, digits, '_' or '-', "
                f"got {self.name!r}"
            )
        if self.convention not in CONVENTIONS:
            raise ValueError(
                f"arm {self.name!r}: convention must be one of {CONVENTIONS}, "
                f"got {self.convention!r}"
            )
        if not self.joints:
            raise ValueError(f"arm {self.name!r}: needs at least one row in joints")
        for i, joint in enumerate(self.joints, start=1):
            joint.validate(f"arm {self.name!r}, joint {i}")
        self.tool.validate(f"arm {self.name!r}, tool")


def _is_identifier(name: str) -> bool:
    return all(c.isalnum() or c in "_-" for c in name)
