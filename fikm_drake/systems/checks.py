"""Checks that the constructors of the blocks share."""

from math import isfinite
from numbers import Integral


def check_sizes(**sizes: int) -> None:
    """Raise ValueError, naming the size, unless all are positive integers."""
    for name, size in sizes.items():
        if not isinstance(size, Integral) or size < 1:
            raise ValueError(f"{name} must be a positive integer, got {size!r}")


def check_period(period: float) -> float:
    """The period [s]; ValueError unless it is positive and finite (Drake lets a negative one pass)."""
    if not (isfinite(period) and period > 0.0):
        raise ValueError(f"period must be positive and finite [s], got {period!r}")
    return float(period)


def check_bandwidth(bandwidth: float) -> float:
    """The bandwidth [rad/s]; ValueError unless it is positive and finite."""
    if not (isfinite(bandwidth) and bandwidth > 0.0):
        raise ValueError(f"bandwidth must be positive and finite [rad/s], got {bandwidth!r}")
    return float(bandwidth)


def check_positive(name: str, value: float) -> float:
    """The value, which may be infinite; ValueError unless it is positive."""
    if not value > 0.0:
        raise ValueError(f"{name} must be positive, got {value!r}")
    return float(value)


def check_not_negative(name: str, value: float) -> float:
    """The value; ValueError unless it is finite and not negative."""
    if not (isfinite(value) and value >= 0.0):
        raise ValueError(f"{name} must be finite and not negative, got {value!r}")
    return float(value)


def check_smoothing(name: str, smoothing: float) -> float:
    """The smoothing [-]; ValueError unless 0 ≤ smoothing < 1."""
    if not 0.0 <= smoothing < 1.0:
        raise ValueError(f"{name} must be in [0, 1), 0 filters nothing, got {smoothing!r}")
    return float(smoothing)
