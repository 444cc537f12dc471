"""The tasks that come with the library, one a file, and their names.

A task says which coordinates of the tool count and what is wrong with them. With the pose X_WE of
the tool's frame E and its spatial velocity V = [ω; v] = J q̇ in the world,

- position and axes: e = p_desired − p, rows v;
- orientation: e = L · (angle · axis) of R_desired Rᵀ, rows L · ω;
- pose: both, [ω; v];
- pointing: e = L · the turn of one axis of E toward a direction, then position, five rows.

L is the characteristic length [m], which makes the rows commensurable. What enters is an arm and a
target; no law, no filter. A task of one's own is a `PlantTask`: one class, given as an object.
"""

from collections.abc import Callable, Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex
from pydrake.systems.framework import Context

from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import CHARACTERISTIC_LENGTH, POSITION_TASKS
from fikm_drake.kinematics.task_kinematics import PlantTask, TaskKinematics
from fikm_drake.kinematics.tasks.pointing_task import PointingTask
from fikm_drake.kinematics.tasks.pose_task import OrientationTask, PoseTask
from fikm_drake.kinematics.tasks.position_task import PositionTask

__all__ = [
    "TASK_KINEMATICS",
    "OrientationTask",
    "PointingTask",
    "PoseTask",
    "PositionTask",
    "as_task",
    "check_task_name",
    "make_task",
]


def _position_task(axes: str) -> Callable[[PlantArm, float], PlantTask]:
    return lambda arm, characteristic_length: PositionTask(arm, axes)


TASK_KINEMATICS: dict[str, Callable[[PlantArm, float], PlantTask]] = {
    **{axes: _position_task(axes) for axes in POSITION_TASKS},
    "orientation": OrientationTask,
    "pose": PoseTask,
    "pointing": lambda arm, length: PointingTask(arm, characteristic_length=length),
}
"""Tasks by name: makes one for an arm and a characteristic length [m]."""


def check_task_name(name: str) -> str:
    """The name; ValueError, listing the valid ones, unless it is a task's."""
    if not isinstance(name, str) or name not in TASK_KINEMATICS:
        raise ValueError(f"task must be one of {tuple(TASK_KINEMATICS)}, got {name!r}")
    return name


def make_task(
    arm: PlantArm, name: str, characteristic_length: float = CHARACTERISTIC_LENGTH
) -> PlantTask:
    """The task of this name.

    Args:
        arm: the joints and the tool's frame.
        name: a key of `TASK_KINEMATICS`: `position`, axes, `orientation`, `pose`, `pointing`.
        characteristic_length: a turn of 1 rad counts as this much [m].

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    return TASK_KINEMATICS[check_task_name(name)](arm, characteristic_length)


def as_task(
    plant: MultibodyPlant,
    frame: str,
    task: str | TaskKinematics,
    characteristic_length: float = CHARACTERISTIC_LENGTH,
    *,
    joints: Sequence[str] | ModelInstanceIndex | None = None,
    reference_frame: str | Frame | None = None,
    context: Context | None = None,
) -> TaskKinematics:
    """The task, made by its name or given as an object.

    Args:
        plant: a finalized plant.
        frame: name of the tool's frame, for a name.
        task: a name, or an object whose arm is of the same plant.
        characteristic_length: for a name: a turn of 1 rad counts as this much [m].
        joints: for a name: see `PlantArm`, as are the next two.
        reference_frame: in which targets are.
        context: of the plant, for joints that are held.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """
    if isinstance(task, str):
        check_task_name(task)
        arm = PlantArm(
            plant, frame, joints=joints, reference_frame=reference_frame, context=context
        )
        return make_task(arm, task, characteristic_length)
    if not isinstance(task, TaskKinematics):
        raise ValueError(
            f"task must be one of {tuple(TASK_KINEMATICS)} or a TaskKinematics, got {task!r}"
        )
    if joints is not None or reference_frame is not None or context is not None:
        raise ValueError(
            "joints, reference_frame and context are for a task by its name; a task that is an object "
            f"has them in its PlantArm: {type(task).__name__}(PlantArm(plant, frame, joints=…))"
        )
    if task.arm.plant is not plant:
        raise ValueError(f"task {type(task).__name__} is of another plant than the controller's")
    return task
