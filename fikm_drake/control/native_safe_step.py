"""The joint step of a filtered error inside the limits of the joints, by the native kernel."""

import threading

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control import box_step, saturation
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.posture import DAMPING as POSTURE_DAMPING
from fikm_drake.control.retreating_step import UNBOUNDED, RetreatingStep
from fikm_drake.control.safe_step import PASSES, UNMOVED, SafeStep
from fikm_drake.kinematics.native.kernel import Kernel, address, kernel
from fikm_drake.kinematics.task_kinematics import PlantTask, TaskKinematics
from fikm_drake.laws import Law
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.normal_equations import LARGEST_GROWTH

LIMITED = 2
"""What the kernel answers where limits take a part of the step away; 0: it leaves the step to Python."""


class NativeSafeStep(threading.local):
    """`SafeStep.inside` with the Jacobian as one call, for what `native_safe_step` takes.

    The buffers are one set for each thread.

    Args:
        loaded: the kernel.
        options: as `native/limits.h` lists them.
        num_rows: m.
        num_joints: n.
    """

    def __init__(self, loaded: Kernel, options: Array, num_rows: int, num_joints: int) -> None:
        self._made_of = options, num_rows, num_joints
        self._command, self._q, self._error = (
            np.zeros(k) for k in (num_joints, num_joints, num_rows)
        )
        self._step = np.zeros(num_joints)
        self._run = loaded.step_at
        self._at = tuple(map(address, (options, self._command, self._q, self._error)))
        self._at_step = address(self._step)

    def __reduce__(self) -> tuple:
        """Pickled as what it was made of: addresses hold in one process only."""
        return _loaded, self._made_of

    def __call__(
        self, q: Array, error: Array, command: Array, damping: float, *, resolved: bool = True
    ) -> tuple[Array, bool] | None:
        """The joint step (n,) [rad or m] and whether limits took a part of it away, or None: Python does it.

        Args:
            q: joint positions (n,) [rad or m].
            error: filtered error (m,) [m].
            command: joint positions (n,) [rad or m].
            damping: 0 for none [-].
            resolved: see `SafeStep.inside`.
        """
        self._q[:], self._error[:], self._command[:] = q, error, command
        done = self._run(*self._at, damping, not resolved, self._at_step)
        return (self._step.copy(), done == LIMITED) if done else None


def native_safe_step(
    task: TaskKinematics, law: Law, safe_step: SafeStep, limits: JointLimits
) -> NativeSafeStep | None:
    """The kernel's step for what `step_options` takes, or None: `SafeStep` does it."""
    options = step_options(task, law, safe_step, limits)
    return None if options is None else _loaded(options, task.size, task.arm.num_joints)


def _loaded(options: Array, num_rows: int, num_joints: int) -> NativeSafeStep | None:
    loaded = kernel()
    return None if loaded is None else NativeSafeStep(loaded, options, num_rows, num_joints)


def step_options(
    task: TaskKinematics, law: Law, safe_step: SafeStep, limits: JointLimits
) -> Array | None:
    """What `native/limits.h` is told of a step; None where it does not know law, task or limits.

    It knows tasks of the tool's position and orientation under the indirect fuzzy mapping, with one
    iteration or with as many as there are rows.
    """
    if not isinstance(task, PlantTask) or task.native is None:
        return None
    if type(law) is not FuzzyMapping or law.method != "indirect" or 1 < law.iterations < task.size:
        return None
    n, near, turns = task.arm.num_joints, safe_step.limits, task.native.options
    step: list[float] = [task.size, n, safe_step.longest, safe_step.dead, safe_step.side_step]
    step += [UNMOVED, near is not None, PASSES, limits.brakes, limits.period, saturation.PASSES]
    step += [saturation.GAIN, saturation.BRAKING_GAIN, saturation.HALF, saturation.BETTER]
    step += [saturation.TINY, law.row_floor, law.column_floor, law.zero_threshold, law.damping]
    retreat = safe_step.retreat if isinstance(safe_step, RetreatingStep) else None
    step += [law.error_damping, LARGEST_GROWTH if law.iterations > 1 else 0.0]
    step += [retreat is not None, *(retreat.options if retreat else (0.0,) * 6), UNBOUNDED]
    step += [box_step.ROUNDING, box_step.BLOCKS, box_step.PASSES]
    pulls = safe_step.posture is not None and safe_step.posture_gain > 0.0
    step += [safe_step.posture_gain if pulls else 0.0, POSTURE_DAMPING, *turns]
    zones = (np.zeros(n),) * 5 if near is None else near.numbers
    if retreat:
        zones = retreat.numbers
    each = limits.lower, limits.upper, limits.fastest, limits.change
    posture = safe_step.posture if safe_step.posture is not None else np.zeros(n)
    arrays = (*each, *zones, posture, task.native.packed)
    return np.concatenate([np.array(step, dtype=float), *arrays])
