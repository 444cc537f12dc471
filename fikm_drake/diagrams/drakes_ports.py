"""The controller with the ports of Drake's own differential IK, to be put in its place."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    BusValue,
    Context,
    Diagram,
    DiagramBuilder,
    DiscreteValues,
    LeafSystem,
)

from fikm_drake.arrays import Array
from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk
from fikm_drake.systems.start import declare_start, mark_placed

PORTS = {
    "integrator": ("X_AE_desired", "robot_state"),
    "controller": ("desired_poses", "estimated_state"),
}
"""Names of the target's and the state's port as Drake's DifferentialInverseKinematics… has them."""


class DrakesPorts(Diagram):
    """A fuzzy IK controller that stands in for Drake's differential IK, one line of a script changed.

    .. pydrake_system::

        name: DrakesPorts
        input_ports:
        - X_AE_desired
        - robot_state
        output_ports:
        - joint_positions
        - <all of FuzzyIkController>

    With `ports="integrator"` as Drake's `DifferentialInverseKinematicsIntegrator`:

    - **X_AE_desired**: RigidTransform, the tool's target in the reference frame.
    - **robot_state** (nq + nv), may stay unconnected: the plant's. The command starts there; without it
      at `SetPositions`.
    - **joint_positions** (n) [rad or m]: the same as **commanded_position**.

    With `ports="controller"` as Drake's `DifferentialInverseKinematicsController`: **desired_poses**, a
    BusValue whose signal of the tool's scoped name (`iiwa14::tool`) is a RigidTransform, and
    **estimated_state** (nq + nv). **nominal_posture** (n) [rad or m], may stay unconnected: toward it go the
    joints as far as the task leaves them free, in a second by the fraction `posture_rate` of the config,
    or all of the way where that is 0. `set_initial_position` does what `SetPositions` does.

    All outputs of `FuzzyIkController` are there too, `status` first of all, which Drake's have not.

    Args:
        controller: for a task with a RigidTransform as target.
        arm: the controller's.
        ports: `integrator` or `controller`; for the latter the controller has the port
            `null_space_motion`.
        posture_rate: with which `nominal_posture` is approached [1/s].

    Raises:
        ValueError: other ports, or a task with another target.
    """

    def __init__(
        self,
        controller: FuzzyIkController | FusedFuzzyIk,
        arm: PlantArm,
        *,
        ports: str,
        posture_rate: float = 1.0,
    ) -> None:
        super().__init__()
        if ports not in PORTS:
            raise ValueError(f"ports must be one of {list(PORTS)} or None, got {ports!r}")
        if controller.get_input_port(0).get_name() != "desired_pose":
            raise ValueError(
                f"ports={ports!r} needs a task with a pose as target, such as "
                "FuzzyIkConfig(task='pose')"
            )
        self.chain = arm.chain
        self._whole = arm.plant.num_positions()
        target, state = PORTS[ports]
        builder = DiagramBuilder()
        ik = builder.AddNamedSystem("fuzzy_ik", controller)
        selected = _MeasuredJoints(arm.chain, arm.plant.num_multibody_states(), posture_rate)
        joints = builder.AddNamedSystem("measured_joints", selected)
        self._ik, self._joints = ik, joints
        if ports == "controller":
            bus = builder.AddNamedSystem("pose_of_bus", _PoseOfBus(arm.chain.name))
            builder.ExportInput(bus.get_input_port(), target)
            builder.Connect(bus.get_output_port(), ik.get_input_port(0))
        else:
            builder.ExportInput(ik.get_input_port(0), target)
        builder.ExportInput(joints.get_input_port(0), state)
        if ports == "controller":
            builder.ExportInput(joints.GetInputPort("nominal_posture"), "nominal_posture")
            motion = ik.GetInputPort("null_space_motion")
            builder.Connect(joints.GetOutputPort("null_space_motion"), motion)
        builder.Connect(ik.GetOutputPort("commanded_position"), joints.GetInputPort("command"))
        builder.Connect(joints.GetOutputPort("joints"), ik.GetInputPort("estimated_position"))
        if ports == "integrator":
            builder.ExportOutput(ik.GetOutputPort("commanded_position"), "joint_positions")
        for i in range(ik.num_output_ports()):
            builder.ExportOutput(ik.get_output_port(i), ik.get_output_port(i).get_name())
        builder.BuildInto(self)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position in this Diagram's context, at rest.

        Args:
            context: of this Diagram.
            position: (n,), or of all of the plant's joints (nq,), as Drake's own take [rad or m].

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        position = np.array(position, dtype=float)
        if position.shape == (self._whole,) and self._whole != self.chain.num_joints:
            position = self.chain.from_full(position)
        self._ik.SetPositions(self.GetMutableSubsystemContext(self._ik, context), position)
        mark_placed(self.GetMutableSubsystemContext(self._joints, context))

    def set_initial_position(self, context: Context, value: ArrayLike) -> None:
        """As `SetPositions`, under the name that Drake's Controller has."""
        self.SetPositions(context, value)


class _MeasuredJoints(LeafSystem):
    """The chain's joints out of a plant's state, or the command where no state is connected.

    And the motion toward a nominal posture, none where none is connected.
    """

    def __init__(self, chain: SerialChain, num_states: int, posture_rate: float) -> None:
        super().__init__()
        n, self._rate = chain.num_joints, posture_rate
        self._chosen = chain.position_indices
        self._state = self.DeclareVectorInputPort("state", num_states)
        self._command = self.DeclareVectorInputPort("command", n).Eval
        self._nominal = self.DeclareVectorInputPort("nominal_posture", n)
        joints = self.DeclareVectorOutputPort("joints", n, self._calc)
        self._joints = joints.Eval
        self.DeclareVectorOutputPort("null_space_motion", n, self._calc_motion)
        declare_start(self, self._state, _nothing)

    def _calc(self, context: Context, output: BasicVector) -> None:
        if self._state.HasValue(context):
            output.set_value(self._state.Eval(context)[self._chosen])
        else:
            output.set_value(self._command(context))

    def _calc_motion(self, context: Context, output: BasicVector) -> None:
        if self._nominal.HasValue(context):
            output.set_value(self._rate * (self._nominal.Eval(context) - self._joints(context)))
        else:
            output.SetZero()


def _nothing(discrete_state: DiscreteValues, position: Array) -> None:
    """The controller inside starts by itself; this block only warns where nothing says from where."""


class _PoseOfBus(LeafSystem):
    """One signal of a bus of poses; a pose of NaN, for which a controller holds, where it is missing."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name
        self._bus = self.DeclareAbstractInputPort("bus", Value(BusValue())).Eval
        self._lost = Value(RigidTransform(np.full(3, np.nan)))
        self.DeclareAbstractOutputPort("pose", Value(RigidTransform()).Clone, self._calc)

    def _calc(self, context: Context, output: AbstractValue) -> None:
        found = self._bus(context).Find(self._name)
        pose = found.get_value() if isinstance(found, AbstractValue) else found
        output.SetFrom(Value(pose) if isinstance(pose, RigidTransform) else self._lost)
