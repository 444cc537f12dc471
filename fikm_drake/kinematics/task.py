"""Which coordinates of the tool count."""

from dataclasses import dataclass

from fikm_drake.checks import check_positive_finite

POSITION_TASKS = ("position", "xy", "xz", "yz", "x", "y", "z")
TASKS = (*POSITION_TASKS, "orientation", "pose")
CHARACTERISTIC_LENGTH = 0.3
"""A turn of 1 rad counts as this much by default [m]."""


@dataclass(frozen=True)
class Task:
    """Coordinates of the tool that a controller moves to a target, in the order [ω; v].

    Args:
        name: `position` (x, y, z), the axes that count (`xy`, `xz`, `yz`, `x`, `y`, `z`),
            `orientation` or `pose` (orientation and position).
        characteristic_length: a turn of 1 rad counts as this much [m]: rows of rotation are
            multiplied by it, so that all are in metres.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    name: str = "position"
    characteristic_length: float = CHARACTERISTIC_LENGTH

    def __post_init__(self) -> None:
        if self.name not in TASKS:
            raise ValueError(f"task must be one of {TASKS}, got {self.name!r}")
        check_positive_finite("characteristic_length", self.characteristic_length, "m")

    @property
    def turns(self) -> bool:
        """True if orientation counts."""
        return self.name not in POSITION_TASKS

    @property
    def coordinates(self) -> list[int]:
        """Indices in a position (x, y, z) of the axes that count."""
        axes = {"position": "xyz", "pose": "xyz", "orientation": ""}.get(self.name, self.name)
        return ["xyz".index(axis) for axis in axes]

    @property
    def rows(self) -> list[int]:
        """Rows in a Jacobian with rows [ω; v]."""
        return [*(range(3) if self.turns else ()), *(3 + i for i in self.coordinates)]

    @property
    def size(self) -> int:
        """The number of rows, m."""
        return len(self.rows)
