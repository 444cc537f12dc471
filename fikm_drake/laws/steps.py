"""The small steps of a control cycle, in plain floats: the blocks and the fused block call the same."""

from collections.abc import Sequence
from math import hypot, isfinite

Vector = Sequence[float]


def all_finite(vector: Vector) -> bool:
    """True if no number is NaN or infinite."""
    # A sum is cheap and is finite only if all are; it alone can overflow.
    return isfinite(sum(vector)) or all(map(isfinite, vector))


def difference(desired: Vector, actual: Vector) -> list[float]:
    """The task error: desired minus actual."""
    return [d - a for d, a in zip(desired, actual)]


def amplify(gain: float, error: Vector, limit: float) -> list[float]:
    """gain · error, the error first shortened to the length `limit`; zeros if it is not finite."""
    length = hypot(*error)
    if length > limit:
        gain *= limit / length
    amplified = [gain * e for e in error]
    return amplified if all_finite(amplified) else [0.0] * len(amplified)


def low_pass(value: float, previous: float, smoothing: float) -> float:
    """(1 − smoothing) · value + smoothing · previous (equations 30 and 31 with 2/3)."""
    return (1.0 - smoothing) * value + smoothing * previous


def integrate(position: Vector, joint_step: Vector, lower: Vector, upper: Vector) -> list[float]:
    """position + joint_step held inside the limits; the position itself if a step is not finite.

    A position that is outside already, as at the start, is not pulled in, only not let further out.
    """
    moved = [q + s for q, s in zip(position, joint_step)]
    for low, x, high in zip(lower, moved, upper):
        if not low < x < high:  # also if x is not finite
            break
    else:
        return moved
    if not all_finite(moved):
        return list(position)
    return [
        min(max(x, min(low, q)), max(high, q))
        for q, x, low, high in zip(position, moved, lower, upper)
    ]


def is_limited(position: Vector, joint_step: Vector, lower: Vector, upper: Vector) -> bool:
    """True if a joint limit takes away a part of a finite joint step."""
    moved = [q + s for q, s in zip(position, joint_step)]
    return all_finite(joint_step) and integrate(position, joint_step, lower, upper) != moved
