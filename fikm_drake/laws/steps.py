"""The small steps of one control cycle, in plain floats: what the blocks and the fused block both call."""

from collections.abc import Sequence
from math import hypot, isfinite


def difference(desired: Sequence[float], actual: Sequence[float]) -> list[float]:
    """The task error: desired minus actual, m numbers."""
    return [d - a for d, a in zip(desired, actual)]


def all_finite(*vectors: Sequence[float]) -> bool:
    """True if no number of the vectors is NaN or infinite."""
    # One sum is cheap and is never finite unless all are; it could only overflow by itself.
    return all(isfinite(sum(v)) or all(map(isfinite, v)) for v in vectors)


def amplify(gain: float, error: Sequence[float], limit: float) -> list[float]:
    """gain · error, the error first shortened to the length `limit`; zeros if it is not finite."""
    length = hypot(*error)
    if length > limit:
        gain *= limit / length
    scaled = [gain * e for e in error]
    return scaled if all_finite(scaled) else [0.0] * len(scaled)


def low_pass(value: Sequence[float], previous: Sequence[float], smoothing: float) -> list[float]:
    """(1 − smoothing) · value + smoothing · previous (equations 30 and 31 with 2/3)."""
    new = 1.0 - smoothing
    return [new * v + smoothing * p for v, p in zip(value, previous)]


def integrate(
    position: Sequence[float],
    joint_step: Sequence[float],
    lower: Sequence[float],
    upper: Sequence[float],
) -> list[float]:
    """position + joint_step held inside the limits; the position itself if a step is not finite.

    A position that is outside already, as at the start, is not pulled in, only not let further out.
    """
    if not all_finite(joint_step):
        return list(position)
    return [
        q + s if low <= q + s <= high else min(max(q + s, min(low, q)), max(high, q))
        for q, s, low, high in zip(position, joint_step, lower, upper)
    ]
