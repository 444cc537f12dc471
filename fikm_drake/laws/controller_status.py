"""What the controller reports of itself."""

from enum import IntEnum


class ControllerStatus(IntEnum):
    """Value of a controller's `status` port; the first that holds, in this order."""

    INVALID_INPUT = 0
    """An input is NaN or infinite: the last good command holds."""
    CONVERGED = 1
    """The task error is within the tolerance."""
    LIMITED = 2
    """A joint limit takes away a part of the joint step."""
    OSCILLATING = 3
    """The supervisor sees a joint oscillate and has lowered the gain."""
    TRACKING = 4
    """None of these: the arm follows."""


def controller_status(
    *, valid: bool, error: float, tolerance: float, limited: bool, oscillating: bool
) -> ControllerStatus:
    """The status of a cycle.

    Args:
        valid: every input is finite.
        error: length of the task error [m].
        tolerance: within this the target counts as reached [m].
        limited: a joint limit cuts the joint step.
        oscillating: the supervisor sees a joint oscillate.
    """
    if not valid:
        return ControllerStatus.INVALID_INPUT
    if error <= tolerance:
        return ControllerStatus.CONVERGED
    if limited:
        return ControllerStatus.LIMITED
    return ControllerStatus.OSCILLATING if oscillating else ControllerStatus.TRACKING
