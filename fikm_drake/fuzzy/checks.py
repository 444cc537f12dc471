"""Checks that the data classes of the fuzzy engine share."""

from math import isfinite, nan


def check_finite(name: str, value: object) -> float:
    """The value as a float; ValueError, naming it, unless it is a finite number."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = nan
    if not isfinite(number):
        raise ValueError(f"{name} must be a finite number, got {value!r}")
    return number
