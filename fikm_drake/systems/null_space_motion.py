"""Blocks that fill the port `null_space_motion` of a controller."""

from collections.abc import Callable, Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.checks import check_position, check_positive_finite
from fikm_drake.control.clearance import Clearance
from fikm_drake.control.null_space import (
    Objective,
    away_from_obstacles,
    toward_manipulability,
    toward_middle,
    toward_posture,
)
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task_kinematics import TaskKinematics


class NullSpaceMotion(LeafSystem):
    """What the joints should do beside the task; the controller takes what the task leaves free of it.

    .. pydrake_system::

        name: NullSpaceMotion
        input_ports:
        - position
        output_ports:
        - null_space_motion

    - **position** (n) [rad or m]: the joints, such as the controller's `commanded_position`.
    - **null_space_motion** (n) [rad/s or m/s]: the joint velocity that is wished for; zeros while the
      position is not finite.

    Made by `toward_posture`, `toward_middle`, `toward_manipulability` or `away_from_obstacles`, or of any
    function of your own. Several are summed by Drake's `Adder`.

    Args:
        num_joints: n.
        objective: joint positions (n,) to the joint velocity (n,) that is wished for.

    Example:
        >>> import fikm_drake as fd
        >>> arm = fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("arm7")))
        >>> fd.NullSpaceMotion.toward_middle(arm).get_output_port().size()
        7
    """

    def __init__(self, num_joints: int, objective: Objective | Callable[[Array], Array]) -> None:
        super().__init__()
        self._objective, self._hold = objective, np.zeros(num_joints)
        port = self.DeclareVectorInputPort("position", num_joints)
        self._position = port.Eval
        self.DeclareVectorOutputPort(
            "null_space_motion", num_joints, self._calc, prerequisites_of_calc={port.ticket()}
        )

    @classmethod
    def toward_posture(
        cls, arm: PlantArm, posture: Sequence[float] | Array, *, rate: float = 1.0
    ) -> "NullSpaceMotion":
        """Toward joint positions (n,) [rad or m] at a rate [1/s].

        Raises:
            ValueError: the posture is not inside the limits, or the rate not positive and finite.
        """
        posture = check_position(posture, arm.lower, arm.upper, name="posture")
        rate = check_positive_finite("rate", rate, "1/s")
        return cls(arm.num_joints, toward_posture(posture, rate))

    @classmethod
    def toward_middle(cls, arm: PlantArm, *, rate: float = 2.0) -> "NullSpaceMotion":
        """Away from the joint limits, at a limit by `rate` [1/s] of the way to the middle.

        Raises:
            ValueError: the rate is not positive and finite.
        """
        rate = check_positive_finite("rate", rate, "1/s")
        return cls(arm.num_joints, toward_middle(arm.lower, arm.upper, rate))

    @classmethod
    def toward_manipulability(
        cls, task: TaskKinematics, *, speed: float = 0.3
    ) -> "NullSpaceMotion":
        """Away from singular postures of the task, at a `speed` [rad/s or m/s], see `control.null_space`.

        Raises:
            ValueError: the speed is not positive and finite.
        """
        speed = check_positive_finite("speed", speed, "rad/s or m/s")
        return cls(task.arm.num_joints, toward_manipulability(task.jacobian, speed))

    @classmethod
    def away_from_obstacles(
        cls, clearance: Clearance, task: TaskKinematics, *, speed: float = 0.3
    ) -> "NullSpaceMotion":
        """Away from what is within the influence distance, at up to a `speed` [rad/s or m/s].

        Raises:
            ValueError: the speed is not positive and finite.
        """
        speed = check_positive_finite("speed", speed, "rad/s or m/s")
        wish = away_from_obstacles(clearance, task.jacobian, speed)
        return cls(task.arm.num_joints, wish)

    def _calc(self, context: Context, output: BasicVector) -> None:
        q = self._position(context)
        output.set_value(self._objective(q) if all_finite(q) else self._hold)
