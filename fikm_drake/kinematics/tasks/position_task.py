"""Position of the tool, or some of its axes."""

from typing import Any

from fikm_drake.arrays import Array
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import POSITION_TASKS, Task
from fikm_drake.kinematics.task_kinematics import PlantTask, native_task_of


class PositionTask(PlantTask):
    """The tool's origin is at a position (m) [m] in the world frame.

    Args:
        arm: the joints and the tool's frame.
        axes: `position` (x, y, z), or those that count: `xy`, `xz`, `yz`, `x`, `y`, `z`.

    Raises:
        ValueError: other axes, naming them and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> fd.PositionTask(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("planar4"))), "xy").size
        2
    """

    port = "desired_position"

    def __init__(self, arm: PlantArm, axes: str = "position") -> None:
        super().__init__(arm)
        if axes not in POSITION_TASKS:
            raise ValueError(f"axes must be one of {POSITION_TASKS}, got {axes!r}")
        rows = Task(axes).coordinates
        self.size = len(rows)
        # A slice costs a step less than a list.
        self._axes = slice(rows[0], rows[-1] + 1, rows[1] - rows[0] if len(rows) > 1 else 1)
        if type(self) is PositionTask:
            self.native = native_task_of(self, [3 + row for row in rows])

    def target_error(self, context: Any, target: Array) -> Array:
        """Desired minus actual position (m,) [m]."""
        return target - self.arm.pose(context).translation()[self._axes]

    def target_jacobian(self, context: Any) -> Array:
        """Rows of the translational Jacobian (m,n)."""
        return self.arm.translational_jacobian(context)[self._axes]

    def jacobian_range(self) -> Array:
        """Bounds of the Jacobian's |J_ij| (m,n) over all joint positions."""
        return self.arm.jacobian_range()[3:][self._axes]
