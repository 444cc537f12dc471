"""A limit of jerk: the command that goes out is the mean of the last ones."""

from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.control.joint_limits import each_limit

MOST_CYCLES = 2000
"""A mean over more cycles is refused: it would be later than any loop bears."""


class JerkLimit:
    """Smooths a joint command that keeps limits of position, speed and acceleration, so that it keeps jerk.

    The command that goes out is the mean of the last M commands of the loop. Limits of position, speed,
    acceleration and the length of a step are convex: the mean keeps what each of the M kept, and a stop that
    was possible before a position limit still is. In a cycle its acceleration changes by
    (Δu_k − Δu_{k−M}) / M for steps u, so that a jerk j is kept by

        M ≥ 2 a / (j T)

    with the acceleration a and the period T (Biagiotti & Melchiorri, FIR filters for online trajectory
    planning with time- and frequency-domain specifications, 2012). All joints share M, so that the tool's
    way keeps its shape: it is rounded, not bent. The price is time: what goes out is (M − 1) / 2 cycles
    late, at every speed.

    More acceleration than √(½ v j) would lengthen M by more than it gains on the way to the speed v, so
    this is the limit where the joint's own is higher: `accelerations`. From rest to v then takes
    2.83 √(v / j), where the least is 2 √(v / j).

        limit = JerkLimit(500.0, period=0.01, velocity_limits=2.0, acceleration_limits=10.0, num_joints=7)
        memory = limit.start(q)
        sent = limit.command(memory, command)      # each cycle
        limit.remember(memory, command)

    Args:
        jerk_limits: one for all joints or (n,), inf for none [rad/s³ or m/s³].
        period: of the control cycle [s].
        velocity_limits: one or (n,), inf for none [rad/s or m/s].
        acceleration_limits: one or (n,), inf for none [rad/s² or m/s²].
        num_joints: n.

    Raises:
        ValueError: a limit is not positive or of another size; a joint with a limit of jerk has none of speed
            nor of acceleration; the mean would be over more than `MOST_CYCLES`.
    """

    def __init__(
        self,
        jerk_limits: ArrayLike,
        *,
        period: float,
        velocity_limits: ArrayLike,
        acceleration_limits: ArrayLike,
        num_joints: int,
    ) -> None:
        jerks = each_limit("jerk_limits", jerk_limits, num_joints)
        self.accelerations = smooth_accelerations(
            jerks,
            each_limit("velocity_limits", velocity_limits, num_joints),
            each_limit("acceleration_limits", acceleration_limits, num_joints),
        )
        """Limits (n,) that the commands must keep which are smoothed [rad/s² or m/s²]."""
        bounded = np.isfinite(jerks)
        cycles = 2.0 * self.accelerations[bounded] / (jerks[bounded] * period)
        longest = float(cycles.max(initial=1.0))
        if longest > MOST_CYCLES:
            raise ValueError(
                f"jerk_limits must be high enough for a mean over {MOST_CYCLES} cycles of {period:g} s, "
                f"got {jerks.tolist()}, which need {longest:.0f}: raise them or lower the accelerations"
            )
        self.cycles = ceil(longest * (1.0 - 1e-12))
        """M, cycles of the mean [-]."""
        self._rate = 1.0 / (self.cycles * period)

    @property
    def late(self) -> float:
        """By how many cycles what goes out is late [-]."""
        return 0.5 * (self.cycles - 1)

    def start(self, position: Array) -> Array:
        """The memory of an arm at rest at joint positions (n,): the last M commands (M,n), newest first."""
        return np.tile(np.asarray(position, dtype=float), (self.cycles, 1))

    def command(self, memory: Array, latest: Array) -> Array:
        """What goes out (n,) [rad or m]: the mean of the latest command (n,) and those before."""
        before = memory[:-1]
        mean = (latest + before.sum(axis=0)) / self.cycles
        low, high = before.min(axis=0, initial=np.inf), before.max(axis=0, initial=-np.inf)
        return np.minimum(np.maximum(mean, np.minimum(latest, low)), np.maximum(latest, high))

    def velocity(self, memory: Array, latest: Array) -> Array:
        """Change of what goes out over the period (n,) [rad/s or m/s]."""
        return (latest - memory[-1]) * self._rate

    def remember(self, memory: Array, latest: Array) -> None:
        """Write the latest command (n,) into the memory."""
        memory[1:] = memory[:-1].copy()
        memory[0] = latest


def smooth_accelerations(jerks: Array, speeds: Array, accelerations: Array) -> Array:
    """The accelerations (n,) that lead to each speed (n,) soonest under these limits of jerk (n,).

    Raises:
        ValueError: a joint with a limit of jerk has none of speed nor of acceleration.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        useful = np.where(np.isfinite(jerks), np.sqrt(0.5 * speeds * jerks), np.inf)
    least = np.minimum(accelerations, useful)
    bare = np.isfinite(jerks) & ~np.isfinite(least)
    if bare.any():
        raise ValueError(
            f"jerk_limits need a limit of speed or acceleration of joint {int(np.argmax(bare))}: "
            "set velocity_limits, acceleration_limits or default_velocity_limit"
        )
    return least
