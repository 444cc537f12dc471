"""Checks that the constructors of the blocks share."""

from fikm_drake.checks import check_positive_finite


def check_period(period: float) -> float:
    """The period [s]; ValueError unless it is positive and finite (Drake lets a negative one pass)."""
    return check_positive_finite("period", period, "s")


def check_bandwidth(bandwidth: float) -> float:
    """The bandwidth [rad/s]; ValueError unless it is positive and finite."""
    return check_positive_finite("bandwidth", bandwidth, "rad/s")
