"""A point that follows another at limited speed, with or without a limit of acceleration."""

import numpy as np

from fikm_drake.arrays import Array


def follow(
    position: Array,
    velocity: Array,
    target: Array,
    target_velocity: Array,
    *,
    step: float,
    speed: Array,
    acceleration: float | Array,
) -> tuple[Array, Array]:
    """Position and velocity after one time step toward a target that moves; each element alone.

    Where the limits allow, the position is on the target after the step. Behind it, it approaches no
    faster than it can brake, so that it does not overshoot a target that keeps its velocity.

    Args:
        position: (n,) [rad or m].
        velocity: of the last step (n,) [rad/s or m/s].
        target: where the target is after the step (n,) [rad or m].
        target_velocity: (n,) [rad/s or m/s].
        step: the time step [s].
        speed: limits (n,) [rad/s or m/s], inf for none.
        acceleration: limit of all elements, or of each (n,) [rad/s² or m/s²], finite.
    """
    behind = target - step * target_velocity - position
    gain = acceleration * step  # of velocity in a step
    # Braking by `gain` a step from the speed x takes the way x (x + gain) / (2 acceleration).
    way = 2.0 * acceleration * np.abs(behind)
    approach = way / (np.sqrt(0.25 * gain * gain + way) + 0.5 * gain)
    approach = np.minimum(np.abs(behind) / step, approach) * np.sign(behind)
    wanted = np.minimum(np.maximum(target_velocity + approach, -speed), speed)
    velocity = np.minimum(np.maximum(wanted, velocity - gain), velocity + gain)
    return position + step * velocity, velocity


def straight_toward(position: Array, goal: Array, most: Array) -> Array:
    """A goal, or as far as one step goes straight toward it.

    Args:
        position: (n,) [rad or m].
        goal: (n,) [rad or m].
        most: what each element goes at the most, positive (n,) [rad or m].

    Returns:
        (n,); exactly `goal` where that is within one step.
    """
    way = goal - position
    steps = float((np.abs(way) / most).max())
    return goal if steps <= 1.0 else position + way / steps
