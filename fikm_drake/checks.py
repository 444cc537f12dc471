"""Checks of numbers that the constructors of all layers share: ValueErrors that name the bad value."""

from collections.abc import Callable, Iterable
from math import inf, isfinite, nan
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array


def check_number(name: str, value: object, what: str, good: Callable[[float], bool]) -> float:
    """The value as a float; ValueError, saying `what` it must be, unless it is a number and `good`."""
    if not good(_number(value)):
        raise ValueError(f"{name} must be {what}, got {value!r}")
    return _number(value)


def check_finite(name: str, value: object) -> float:
    """The value as a float; ValueError, naming it, unless it is a finite number."""
    return check_number(name, value, "a finite number", isfinite)


def check_positive(name: str, value: object) -> float:
    """The value, which may be infinite; ValueError, naming it, unless it is positive."""
    return check_number(name, value, "positive", lambda x: x > 0.0)


def check_positive_finite(name: str, value: object, unit: str) -> float:
    """The value in its unit; ValueError, naming both, unless it is positive and finite."""
    return check_number(name, value, f"positive and finite [{unit}]", lambda x: 0.0 < x < inf)


def check_not_negative(name: str, value: object) -> float:
    """The value; ValueError, naming it, unless it is finite and not negative."""
    return check_number(name, value, "finite and not negative", lambda x: 0.0 <= x < inf)


def check_below_one(name: str, value: object) -> float:
    """The value; ValueError, naming it, unless 0 ≤ value < 1."""
    return check_number(name, value, "in [0, 1)", lambda x: 0.0 <= x < 1.0)


def check_finites(name: str, values: object, count: int, unit: str) -> list[float]:
    """The values as floats; ValueError, naming them, unless they are `count` finite numbers."""
    numbers = [_number(value) for value in values] if isinstance(values, Iterable) else []
    if len(numbers) != count or not all(map(isfinite, numbers)):
        raise ValueError(f"{name} must be {count} finite numbers [{unit}], got {values!r}")
    return numbers


def check_joint(joint: object, num_joints: int) -> None:
    """ValueError, naming it, unless `joint` is the index of one of `num_joints` joints, from 0."""
    if isinstance(joint, bool) or joint not in range(num_joints):
        raise ValueError(
            f"joint must be in 0 … {num_joints - 1} (joints count from 0), got {joint!r}"
        )


def check_flag(name: str, value: object) -> bool:
    """The value; ValueError, naming it, unless it is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def check_counts(least: int = 1, **counts: object) -> None:
    """Raise ValueError, naming the count, unless all are integers of at least `least`."""
    for name, count in counts.items():
        if isinstance(count, bool) or not isinstance(count, Integral) or count < least:
            raise ValueError(f"{name} must be an integer of at least {least}, got {count!r}")


def check_period(period: float) -> float:
    """The period [s]; ValueError unless it is positive and finite (Drake lets a negative one pass)."""
    return check_positive_finite("period", period, "s")


def check_bandwidth(bandwidth: float) -> float:
    """The bandwidth [rad/s]; ValueError unless it is positive and finite."""
    return check_positive_finite("bandwidth", bandwidth, "rad/s")


def check_limits(lower: ArrayLike, upper: ArrayLike) -> tuple[Array, Array]:
    """Lower and upper limits as arrays; ValueError unless they are vectors with lower ≤ upper."""
    lower, upper = np.array(lower, dtype=float), np.array(upper, dtype=float)
    if lower.ndim != 1 or lower.shape != upper.shape or not lower.size:
        raise ValueError(f"lower and upper must be (n,), got {lower.shape} and {upper.shape}")
    if not (lower <= upper).all():
        raise ValueError(f"lower must not exceed upper, got {lower.tolist()}, {upper.tolist()}")
    return lower, upper


def check_position(
    position: ArrayLike, lower: Array, upper: Array, *, name: str = "joint position"
) -> Array:
    """The joint position (n,); ValueError, with the joint's index, unless it is finite and inside limits."""
    position = np.array(position, dtype=float)
    if position.shape != lower.shape or not np.isfinite(position).all():
        raise ValueError(f"{name} must be {len(lower)} finite numbers, got {position.tolist()}")
    for j in np.flatnonzero((position < lower) | (position > upper)):
        raise ValueError(f"{name}[{j}] must be from {lower[j]} to {upper[j]}, got {position[j]}")
    return position


def _number(value: object) -> float:
    """The value as a float; NaN if it is no number."""
    if isinstance(value, (list, tuple, dict)):
        return nan
    array = np.asarray(value)
    return float(array) if array.shape == () and array.dtype.kind in "biuf" else nan
