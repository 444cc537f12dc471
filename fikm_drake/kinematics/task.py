"""Which coordinates of the tool count."""

from dataclasses import dataclass

TASKS = ("position", "xy", "xz", "yz", "x", "y", "z")


@dataclass(frozen=True)
class Task:
    """Coordinates of the tool point that a controller moves to a target.

    Args:
        name: `position` (x, y, z), or the axes that count: `xy`, `xz`, `yz`, `x`, `y`, `z`.

    Raises:
        ValueError: another name.
    """

    name: str = "position"

    def __post_init__(self) -> None:
        if self.name not in TASKS:
            raise ValueError(f"task must be one of {TASKS}, got {self.name!r}")

    @property
    def axes(self) -> str:
        """The axes of the base frame that count, such as `xyz`."""
        return "xyz" if self.name == "position" else self.name

    @property
    def size(self) -> int:
        """The number of rows, m."""
        return len(self.axes)

    @property
    def coordinates(self) -> list[int]:
        """Their indices in a position (x, y, z)."""
        return ["xyz".index(axis) for axis in self.axes]

    @property
    def rows(self) -> list[int]:
        """Their rows in a Jacobian with rows [ω; v]."""
        return [3 + i for i in self.coordinates]
