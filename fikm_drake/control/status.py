"""What the controller reports of itself."""

from enum import IntEnum

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.restart_state import RestartState


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
    NOT_FOLLOWING = 8
    """The measured robot is further from the command than its limits explain, or not finite."""
    BLOCKED = 9
    """An obstacle takes away half of the joint step or more; the controller's `BlockingPair` names it."""


ORDINARY_SPEED = 3.0
"""A joint without limit of speed is taken to move no faster [rad/s or m/s]."""


def following_distance(speeds: Array, time: float) -> Array:
    """How far a joint that follows can be from its command (n,) [rad or m].

    Args:
        speeds: limits of speed (n,), inf for none [rad/s or m/s].
        time: by which a robot may be late [s].
    """
    return np.minimum(speeds, ORDINARY_SPEED) * time


def follows(command: Array, measured: Array, distance: Array) -> bool:
    """True if every joint (n,) is within `distance` (n,) of its command; a joint of NaN is not."""
    return bool((np.abs(measured - command) <= distance).all())


def controller_status(
    *,
    valid: bool,
    error: float,
    tolerance: float,
    limited: bool,
    oscillating: bool,
    calmed: bool = False,
    restart_search: float = RestartState.NONE,
    following: bool = True,
    blocked: bool = False,
    settled: bool = True,
) -> ControllerStatus:
    """The status of a cycle.

    Args:
        valid: every input is finite.
        error: length of the task error [m].
        tolerance: within this the target counts as reached [m].
        limited: a joint limit cuts the joint step.
        oscillating: the supervisor sees a joint oscillate.
        calmed: the supervisor has calmed the arm and it rests.
        following: the measured robot is near its command.
        blocked: obstacles take away half of the step or more.
        restart_search: what the restart search does, a `RestartState`.
        settled: False while the command that goes out, smoothed for a limit of jerk, is not within the
            tolerance yet.
    """
    if not valid:
        return ControllerStatus.INVALID_INPUT
    if not following:
        return ControllerStatus.NOT_FOLLOWING
    if error <= tolerance and settled:
        return ControllerStatus.CONVERGED
    if restart_search == RestartState.STUCK:
        return ControllerStatus.STUCK
    if restart_search in (RestartState.SEARCHING, RestartState.UNDERWAY):
        return ControllerStatus.RESTART_SEARCH
    if blocked:
        return ControllerStatus.BLOCKED
    if oscillating:
        return ControllerStatus.OSCILLATING
    if calmed:
        return ControllerStatus.CALMED
    return ControllerStatus.LIMITED if limited else ControllerStatus.TRACKING
