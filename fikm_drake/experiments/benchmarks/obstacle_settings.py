"""What users of Drake's and of Pink's differential IK choose, and the best of a few values each."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

Settings = TypeVar("Settings", bound="DrakeSettings | PinkSettings")


@dataclass(frozen=True)
class DrakeSettings:
    """Of `DifferentialInverseKinematicsController`."""

    gain: float = 0.05
    """K_VX: the fraction of the error that a cycle asks for [-]."""
    weight: float = 100.0
    """Weight of the least-squares cost."""
    posture_gain: float = 0.0
    """Posture gain of the joint-centering cost toward the start [-]; 0: there is none."""
    speed: float = 1.0
    """Largest speed that is asked of the tool [rad/s, m/s]."""


@dataclass(frozen=True)
class PinkSettings:
    """Of `solve_ik` with a `SelfCollisionBarrier`."""

    gain: float = 0.2
    """Of the tool's task: the fraction of the error that a cycle asks for [-]."""
    barrier: float = 20.0
    """Gain of the barrier, in Pink's examples 20 [1/s]."""
    posture: float = 1e-3
    """Cost of the posture beside the tool's 1 [-]."""
    damping: float = 1e-3
    """`lm_damping` of the tool's task."""


DRAKE_GRID: dict[str, tuple[float, ...]] = {
    "gain": (0.02, 0.05, 0.1, 0.3),
    "weight": (1.0, 10.0, 100.0, 1000.0),
    "posture_gain": (0.0, 0.01, 0.1),
    "speed": (0.3, 1.0, 3.0, 10.0),
}
PINK_GRID: dict[str, tuple[float, ...]] = {
    "gain": (0.05, 0.2, 1.0),
    "barrier": (5.0, 20.0, 100.0),
    "posture": (1e-4, 1e-3, 1e-2),
    "damping": (1e-5, 1e-3),
}
"""The values that are tried."""


@dataclass(frozen=True)
class Sweep:
    """What a sweep found."""

    best: Any
    """The settings that reach most; of several the first."""
    reached: int
    """Of the scenes, with these."""
    lines: list[str]
    """Field by field how many each value reaches."""


def sweep(
    start: Settings,
    grid: dict[str, tuple[float, ...]],
    reached: Callable[[Settings], int],
) -> Sweep:
    """The best of the values of each field, one field after the other, the others at their best so far.

    Args:
        start: the settings to begin with.
        grid: values of each field.
        reached: how many scenes are reached with settings.
    """
    known = {start: reached(start)}
    best, lines = start, []
    for field in fields(start):
        changes: list[dict[str, Any]] = [{field.name: value} for value in grid[field.name]]
        own = {change[field.name]: replace(best, **change) for change in changes}
        for settings in own.values():
            if settings not in known:
                known[settings] = reached(settings)
        counts = ", ".join(f"{value:g}: {known[own[value]]}" for value in own)
        lines.append(f"{field.name} {counts}")
        best = max([best, *own.values()], key=known.__getitem__)
    return Sweep(best, known[best], lines)
