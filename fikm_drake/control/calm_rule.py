"""When joints shake for no reason, and how far the gain is lowered for it."""

from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.motion_windows import Motion

LEAST_CALM = 1e-6
"""The calm falls no lower [-]."""

CANCELLED = 0.65
"""Joints shake if more than this fraction of their path leads nowhere [-]."""

CONSISTENT = 0.4
"""They run on if less than this fraction does; an error falls for good if less of its changes does [-]."""

EXPLAINED = 0.3
"""A target whose own jitter is above this fraction of the error's explains that joints shake [-]."""

NOISY = 2.5
"""Measured joints that stray by more than this times the joints' path have noise that explains it: a robot
that is a cycle late strays by twice that path at most [-]."""

STAYS = 0.85
"""An error above this fraction of its mean over the slow window does not fall [-]."""

AWAKE = 0.25
"""An arm that goes on has at least this calm [-]."""

DAMPED_FIRST = 0.2
"""Calm down to which a law that takes damping gets damping, and keeps its gain [-]."""

PROGRESS = 0.01
"""The error falls if a cycle takes away this fraction of it, times the calm [-]..."""

LEAST_PROGRESS = 1e-3
"""...of which this is the least that counts: the end of a motion is no progress [-]."""

CHANGES = 2e-3
"""An error that changes by this fraction of it within the fast window is not flat [-]."""

LASTS = 0.3
"""An error falls for good if it keeps this fraction of its changes over the slow window [-]."""

NEAR = 3.0
"""An error within this many times the way of the target in the fast window is that of a follower [-]."""

JUMP = 0.05
"""A target that moves by more than this fraction of the error in a cycle has left it behind [-]."""

CREEPS = 5e-4
"""A calmed arm gets nowhere if a cycle takes away less of the error than this, times the calm [-]..."""

STILL = 0.01
"""...before a target that moved by less than this fraction of the error in the slow window [-]."""

DEEP = 0.1
"""An arm at rest with less than this fraction of its gain is calmed further [-]."""


ROUNDED = 1e-9
"""Jitter below this fraction of the target's path is that of rounding: the target has none [-]."""


class CalmRule:
    """The calm of the next cycle: from 1, where nothing is calmed, down to `LEAST_CALM`.

    A law that takes damping gets it first, all of it at a calm of `DAMPED_FIRST`: that stills the
    directions in which the arm can't follow and leaves it the others, so that it keeps up with a target
    that moves out of reach. Only if the joints shake on the gain falls too. Other laws have the gain only.

    Joints shake for no reason if, before a target that is out of the tolerance,

    - one turns round `sign_changes` times within the fast window, or `slow_sign_changes` times within
      the slow one while the error stays; turns of joints that hardly move are left aside;
    - most of their motion in that window leads nowhere;
    - neither the target's own jitter nor noise of the measured joints explains it; of the noise the
      slow window tells more, since one of ten cycles is noisy itself.

    Args:
        config: the constants of the supervisor.
        damped: whether the law takes damping.
    """

    def __init__(self, config: GainSupervisorConfig, *, damped: bool) -> None:
        self._threshold, self._slow_threshold = config.sign_changes, config.slow_sign_changes
        self._calming, self._recovery = config.calming, config.recovery
        self._damping = config.calm_damping
        self._cycles = config.window - 1
        self.damped_first = DAMPED_FIRST if damped else 1.0
        self._range = 1.0 - DAMPED_FIRST if damped else 1.0

    @property
    def numbers(self) -> tuple[float, ...]:
        """All constants, in the order in which `native/supervision.h` takes them."""
        return (
            *(self._calming, self._recovery, self._damping, self.damped_first, self._range),
            *(LEAST_CALM, CANCELLED, CONSISTENT, EXPLAINED, NOISY, STAYS, AWAKE, PROGRESS),
            *(LEAST_PROGRESS, CHANGES, LASTS, NEAR, JUMP, CREEPS, STILL, DEEP, ROUNDED),
        )

    def gain(self, calm: float) -> float:
        """Factor of the gain [-]."""
        return min(1.0, calm / self.damped_first)

    def damping(self, calm: float) -> float:
        """Damping for a law that takes it [-]."""
        return self._damping * min(1.0, (1.0 - calm) / self._range)

    def shaking_joint(self, error: float, fast: Motion, slow: Motion) -> int:
        """The joint that shakes for no reason, −1 if none does.

        Args:
            error: length of the task error [m].
            fast: motion in the fast window.
            slow: motion in the slow one.
        """
        if _noisy(slow):
            return -1
        if fast.changes >= self._threshold and _to_and_fro(fast):
            return fast.joint
        if slow.changes >= self._slow_threshold and _to_and_fro(slow):
            return slow.joint if error > STAYS * slow.mean_error else -1
        return -1

    def too_few(self, changes: float) -> bool:
        """True if a joint with so many changes of sign in the slow window does not shake."""
        return changes < self._threshold and changes < self._slow_threshold

    def lowered(self, calm: float) -> float:
        """The calm of an arm that shakes."""
        return max(LEAST_CALM, calm * self._calming)

    def raised(self, calm: float) -> float:
        """The calm of an arm within the tolerance."""
        return min(1.0, calm * self._recovery)

    def awake(self, calm: float) -> float:
        """The calm of an arm that goes on."""
        return self.raised(max(AWAKE, calm))

    def undisturbed(
        self, calm: float, error: float, fast: Motion, slow: Motion, *, rests: bool
    ) -> float:
        """The calm of an arm that does not shake before a target out of the tolerance.

        It grows while the error falls by more than the target's own motion, and while the joints run on
        and the error changes, as behind a target that moves; if that is far away only the gain comes
        back, not what the damping stills. Both must hold in the slow window too: in the fast one half a
        swing looks the same. A flat error before a target that rests is that of an arm which creeps
        toward its best point: it becomes calmer, or it would come to the next shaking.

        Args:
            calm: of this cycle.
            error: length of the task error [m].
            fast: motion in the fast window.
            slow: motion in the slow one, which sees whether the error rises again.
            rests: nothing moves.
        """
        if calm == 1.0:
            return calm
        progress = PROGRESS * max(calm, LEAST_PROGRESS) * self._cycles * error
        falls = fast.fall - fast.net_target > max(progress, (1.0 - CONSISTENT) * fast.rough)
        if falls and slow.fall > LASTS * slow.rough:
            return self.awake(calm)
        runs = fast.path_step > 0.0 and fast.cancelled < CONSISTENT and slow.cancelled < CANCELLED
        if runs and abs(fast.fall) > CHANGES * error:
            if error < NEAR * fast.net_target:
                return self.awake(calm)
            return max(calm, min(self.damped_first, self.awake(calm)))
        if rests and calm < DEEP * self.damped_first:
            return self.lowered(calm)
        creeps = slow.fall < CREEPS * calm * slow.cycles * error
        if creeps and slow.cycles > self._cycles and slow.net_target < STILL * error:
            return self.lowered(calm)
        return calm


def _noisy(motion: Motion) -> bool:
    """True if noise of the measured joints explains how they move."""
    return motion.path_deviation > NOISY * motion.path_step


def _to_and_fro(motion: Motion) -> bool:
    """True if joints shake, and not because the target or their measurement does."""
    if motion.cancelled <= CANCELLED or _noisy(motion):
        return False
    jitter = motion.path_target - motion.net_target
    explains = EXPLAINED * (motion.path_error - motion.net_error)
    return not jitter > explains + ROUNDED * motion.path_target
