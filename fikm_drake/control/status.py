"""What the controller reports of itself."""

from enum import IntEnum

from fikm_drake.control.restart_search import RestartState


class ControllerStatus(IntEnum):
    """Value of a controller's `status` port; the first that holds, in the order of `controller_status`."""

    INVALID_INPUT = 0
    """An input is NaN or infinite: the command holds (with limits of acceleration it brakes first)."""
    CONVERGED = 1
    """The task error is within the tolerance."""
    LIMITED = 2
    """A joint limit takes away a part of the joint step."""
    OSCILLATING = 3
    """The supervisor sees a joint oscillate and has lowered the gain."""
    TRACKING = 4
    """None of these: the arm follows."""
    CALMED = 5
    """The arm rests, calmed after an oscillation: the target can't be approached further."""
    RESTART_SEARCH = 6
    """The arm searches for another posture, or moves to it (`FuzzyIkConfig.restart_search`)."""
    STUCK = 7
    """No posture was found that solves the task: it seems out of reach (`FuzzyIkConfig.restart_search`)."""


def controller_status(
    *,
    valid: bool,
    error: float,
    tolerance: float,
    limited: bool,
    oscillating: bool,
    calmed: bool = False,
    restart_search: float = RestartState.NONE,
) -> ControllerStatus:
    """The status of a cycle.

    Args:
        valid: every input is finite.
        error: length of the task error [m].
        tolerance: within this the target counts as reached [m].
        limited: a joint limit cuts the joint step.
        oscillating: the supervisor sees a joint oscillate.
        calmed: the supervisor has calmed the arm and it rests.
        restart_search: what the restart search does, a `RestartState`.
    """
    if not valid:
        return ControllerStatus.INVALID_INPUT
    if error <= tolerance:
        return ControllerStatus.CONVERGED
    if restart_search == RestartState.STUCK:
        return ControllerStatus.STUCK
    if restart_search in (RestartState.SEARCHING, RestartState.UNDERWAY):
        return ControllerStatus.RESTART_SEARCH
    if oscillating:
        return ControllerStatus.OSCILLATING
    if calmed:
        return ControllerStatus.CALMED
    return ControllerStatus.LIMITED if limited else ControllerStatus.TRACKING
