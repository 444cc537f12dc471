"""The search's way down to a posture, and the errors of many postures, by the native kernel."""

import threading
from typing import Any

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.native_safe_step import step_options
from fikm_drake.control.safe_step import SafeStep
from fikm_drake.kinematics.native.kernel import Kernel, address, kernel
from fikm_drake.kinematics.task_kinematics import PlantTask, TaskKinematics
from fikm_drake.laws import Law


class NativeDescent(threading.local):
    """Steps of `RestartSearch` as one call, for the tasks that `native_descent` takes.

    The buffers are one set for each thread.

    Args:
        loaded: the kernel.
        task: whose error falls.
        options: as `native/limits.h` lists them.
        numbers: as `native/restart.h` lists them.
    """

    def __init__(self, loaded: Kernel, task: PlantTask, options: Array, numbers: Array) -> None:
        n, self._kept = task.arm.num_joints, (options, numbers)
        self._numbers, self._own = task.target_numbers, slice(0, 4 + n)
        self._target = np.zeros((3, 4) if task.port == "desired_pose" else task.size)
        self._memory = np.zeros(4 + n)
        self._run, self._sizes = loaded.descend, loaded.error_sizes
        self._at_options, self._at_numbers = address(options), address(numbers)
        self._at_target, self._at_memory = address(self._target), address(self._memory)

    def __call__(self, memory: Array, target: Any, looks: int) -> int:
        """How many of the search's next steps were taken; the next one is Python's, if there is one.

        Args:
            memory: of the search, which is changed.
            target: as the task takes it.
            looks: at most so many.
        """
        self._target[:], self._memory[:] = self._numbers(target), memory[self._own]
        done = self._run(
            *(self._at_options, self._at_numbers, self._at_target, looks, self._at_memory)
        )
        memory[self._own] = self._memory
        return done

    def sizes(self, target: Any, postures: Array) -> Array:
        """Lengths of the error (N,) at postures (N,n) [m]; inf where it is not finite."""
        self._target[:] = self._numbers(target)
        postures, sizes = np.ascontiguousarray(postures, dtype=float), np.empty(len(postures))
        self._sizes(
            *(self._at_options, self._at_target, len(postures), address(postures)), address(sizes)
        )
        return sizes


def native_descent(
    task: TaskKinematics, law: Law, step: SafeStep, numbers: tuple[float, ...]
) -> NativeDescent | None:
    """The kernel's search for the tasks that `step_options` takes, or None: `RestartSearch` does it.

    Args:
        task: whose error falls.
        law: of the step.
        step: that the search takes.
        numbers: as `native/restart.h` lists them.
    """
    loaded, arm = kernel(), task.arm
    options = step_options(task, law, step, JointLimits(arm.lower, arm.upper, period=1.0))
    if loaded is None or options is None or not isinstance(task, PlantTask):
        return None
    return NativeDescent(loaded, task, options, np.array(numbers, dtype=float))
