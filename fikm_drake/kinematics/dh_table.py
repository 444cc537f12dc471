"""An arm's Denavit-Hartenberg table: the dataclasses that a YAML file of `models/` is read into."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import copy
import dataclasses
from dataclasses import dataclass, field
from math import inf, pi

from fikm_drake.checks import check_finite, check_number

CONVENTIONS = ("craig", "standard")
JOINT_TYPES = ("revolute", "prismatic")
ANGLES = {"rad": 1.0, "deg": pi / 180.0}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
DEGREES = (2.1 * pi, 4.1 * pi)
"""An angle of a row, and a limit, beyond which a table without a unit looks like degrees [rad]."""


@dataclass
class DhUnit:
    """Units of a table's numbers, limits and speeds included.

    Attributes:
        angle: `rad` or `deg`; None: rad, and numbers that look like degrees are refused.
        length: `m`, `cm`, `mm` or `in`.
    """

    angle: str | None = None
    length: str = "m"

    def validate(self, where: str) -> None:
        """Raise ValueError, naming `where`, the bad unit and the valid ones."""
        if self.angle is not None and self.angle not in ANGLES:
            raise ValueError(f"{where}: angle must be one of {list(ANGLES)}, got {self.angle!r}")
        if self.length not in LENGTHS:
            raise ValueError(f"{where}: length must be one of {list(LENGTHS)}, got {self.length!r}")


@dataclass
class DhTransform:
    """Four Denavit-Hartenberg numbers: angles [rad], lengths [m].

    Attributes:
        alpha: twist [rad].
        a: link length [m].
        d: joint offset [m].
        theta: joint angle [rad].
    """

    alpha: float = 0.0
    a: float = 0.0
    d: float = 0.0
    theta: float = 0.0

    def validate(self, where: str, *, radians: bool = True) -> None:
        """Raise ValueError, naming `where` and the number, unless all four are finite.

        Args:
            where: what the message begins with.
            radians: True if nobody said so: angles that look like degrees are refused.
        """
        for name in ("alpha", "a", "d", "theta"):
            check_finite(f"{where}: {name}", getattr(self, name))
        if radians:
            for name in ("alpha", "theta"):
                _check_radians(f"{where}: {name}", getattr(self, name), DEGREES[0])


@dataclass
class DhJoint(DhTransform):
    """One row of the table and the joint that moves in it.

    The joint variable adds to `theta` of a revolute joint [rad], to `d` of a prismatic one [m];
    the number in the row is its offset. Limits are of the joint variable, in rad or m.

    Attributes:
        type: `revolute` or `prismatic`.
        lower: lower limit [rad or m]; None: no limit.
        upper: upper limit [rad or m]; None: no limit.
        velocity: limit of the speed [rad/s or m/s]; None or inf: no limit.
        flip: true for a joint that turns, or slides, the other way: its variable is subtracted.
    """

    type: str = "revolute"
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    flip: bool = False

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

    @property
    def is_fixed(self) -> bool:
        """True if its limits leave it one position: it is no joint, but stands there."""
        return self.limits[0] == self.limits[1]

    def validate(self, where: str, *, radians: bool = True) -> None:
        """Raise ValueError, naming `where` and the bad value, unless the row describes a joint."""
        super().validate(where, radians=radians)
        if self.type not in JOINT_TYPES:
            raise ValueError(f"{where}: type must be one of {JOINT_TYPES}, got {self.type!r}")
        for name in ("lower", "upper", "velocity"):
            value = getattr(self, name)
            if value is not None:
                check_number(f"{where}: {name}", value, "a number or None", lambda x: x == x)
        lower, upper = self.limits
        if not lower <= upper:
            raise ValueError(f"{where}: lower must not exceed upper, got {lower} and {upper}")
        if self.is_fixed and abs(lower) == inf:
            raise ValueError(
                f"{where}: lower and upper are both {lower}; leave out a limit for none"
            )
        if radians and self.is_revolute:
            for name, value in (("lower", lower), ("upper", upper)):
                if abs(value) < inf:
                    _check_radians(f"{where}: {name}", value, DEGREES[1])
        if not isinstance(self.flip, bool):
            raise ValueError(f"{where}: flip must be true or false, got {self.flip!r}")
        if self.velocity is not None and not self.velocity > 0:
            raise ValueError(f"{where}: velocity must be positive, got {self.velocity!r}")


@dataclass
class DhTable:
    """A whole arm as its Denavit-Hartenberg table.

    `craig` (modified) rows hold α_{i-1}, a_{i-1}, d_i, θ_i and mean
    Rx(α) Tx(a) Rz(θ) Tz(d); `standard` rows mean Rz(θ) Tz(d) Tx(a) Rx(α).

    Attributes:
        name: the arm's name: a letter, then letters, digits, `_` or `-`.
        convention: `craig` or `standard`.
        joints: one row a joint, from the base outward.
        tool: the last, fixed row, read in the same convention.
        unit: unit of all numbers: `unit: {angle: deg, length: mm}`.
    """

    name: str = ""
    convention: str = "craig"
    joints: list[DhJoint] = field(default_factory=list)
    tool: DhTransform = field(default_factory=DhTransform)
    unit: DhUnit = field(default_factory=DhUnit)

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
        self.unit.validate(f"arm {self.name!r}, unit")
        radians = self.unit.angle is None
        for i, joint in enumerate(self.joints, start=1):
            joint.validate(f"arm {self.name!r}, joint {i}", radians=radians)
        self.tool.validate(f"arm {self.name!r}, tool", radians=radians)
        if all(joint.is_fixed for joint in self.joints):
            raise ValueError(f"arm {self.name!r}: all joints are fixed by equal limits")

    def in_si(self) -> "DhTable":
        """The same arm in radians and metres."""
        angle = ANGLES[self.unit.angle or "rad"]
        length = LENGTHS[self.unit.length]

        joints, tool = copy.deepcopy(self.joints), copy.deepcopy(self.tool)
        for row in (*joints, tool):
            row.alpha, row.theta = angle * row.alpha, angle * row.theta
            row.a, row.d = length * row.a, length * row.d
        for joint in joints:
            scale = angle if joint.is_revolute else length
            joint.lower = None if joint.lower is None else scale * joint.lower
            joint.upper = None if joint.upper is None else scale * joint.upper
            joint.velocity = None if joint.velocity is None else scale * joint.velocity
        unit = DhUnit(None if self.unit.angle is None else "rad")
        return dataclasses.replace(self, joints=joints, tool=tool, unit=unit)


def _check_radians(where: str, angle: float, most: float) -> None:
    if abs(angle) > most:
        raise ValueError(
            f"{where} is {angle}: that looks like degrees. Say `unit: {{angle: deg}}` in the table (it "
            "holds for all its angles and limits), or `unit: {angle: rad}` if it is radians"
        )


def _is_identifier(name: str) -> bool:
    return all(c.isalnum() or c in "_-" for c in name)
