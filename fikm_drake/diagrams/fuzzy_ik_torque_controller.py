"""Fuzzy IK in front of inverse dynamics: from a desired position to joint torques."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex
from pydrake.planning import CollisionChecker
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import Adder, Demultiplexer, Gain, MatrixGain

from fikm_drake.checks import check_bandwidth
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController, Joints, unique_name
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws import LawLike
from fikm_drake.systems.chain_inverse_dynamics import ChainInverseDynamics, actuators
from fikm_drake.systems.joint_reference import JointReference
from fikm_drake.systems.last_finite import LastFinite

BANDWIDTH = 100.0
"""Bandwidth of the inner loop by default [rad/s]."""
ACCELERATION_LIMIT = 20.0
"""Acceleration limit of the joints' reference by default [rad/s² or m/s²]."""


class FuzzyIkTorqueController(Diagram):
    """Moves the tool of a torque-driven arm: the fuzzy IK controller before Drake's inverse dynamics.

    .. pydrake_system::

        name: FuzzyIkTorqueController
        input_ports:
        - desired_position
        - estimated_state
        output_ports:
        - actuation
        - commanded_position
        - commanded_velocity
        - joint_step
        - task_error
        - gain
        - oscillating
        - oscillating_joint
        - status
        - valid

    - **desired_position** (m) [m], or **desired_pose**: as of `FuzzyIkController`.
    - **estimated_state** (nq + nv) [q; v]: the whole plant's; command and reference start there.
    - **actuation** (num_actuators) [N m or N]: for the plant, zero for actuators of other joints; of Drake's
      `InverseDynamicsController`, or of `ChainInverseDynamics` where the plant holds more than the arm.
    - **valid** (1): 1 while the estimated state is finite, else 0; the inner loop then goes on from
      the last one that was.
    - all other outputs: as of `FuzzyIkController`, described there.

    The controller's position command, a new one each period, becomes a reference at the plant's rate
    (`JointReference`) by straight lines whose slope is the commanded velocity, inside the plant's
    velocity limits and `acceleration_limits`. The inner loop cancels the arm's own dynamics and
    gravity and leaves each joint a critically damped second-order error of `bandwidth`. It is not
    stable where the actuators are at their effort limits: keep `acceleration_limits` below that.

    With `config.measured_position` the IK starts from its command plus what the plant's joints are
    off the reference, so that the tool is right though the arm droops, and no wait for the limits of
    the reference is in the loop. The inner loop's own lag is: Table I's gains need a bandwidth of at
    least 1 / period, better twice that; with a slower one the arm swings, unless the gains of
    `config.supervisor` are lowered.

    Args:
        plant: a finalized, discrete plant; it is not copied and must live as long. It may hold more than
            the arm: bodies that the arm touches, a gripper, a second arm.
        config: by default `FuzzyIkConfig()`.
        law: another law than the config's.
        task: another task than the config's, an object.
        collision_checker: what the reference keeps clear of, see `FuzzyIkController`; the outputs
            **clearance** and **blocking_bodies** are there with one, and `BlockingPair`. The arm is behind
            the reference by its lag: raise `config.clearance.safe_distance` by that.
        joints: which joints on the way to the tool are driven, see `MakeFuzzyIkController`, as are the
            next two; each needs an actuator.
        reference_frame: in which targets are.
        context: of the plant.
        bandwidth: of the inner loop [rad/s].
        acceleration_limits: of every joint of the reference [rad/s² or m/s²].

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        config: FuzzyIkConfig | None = None,
        law: LawLike | None = None,
        task: TaskKinematics | None = None,
        collision_checker: CollisionChecker | None = None,
        joints: Joints = None,
        reference_frame: str | Frame | None = None,
        context: Context | None = None,
        bandwidth: float = BANDWIDTH,
        acceleration_limits: float = ACCELERATION_LIMIT,
    ) -> None:
        super().__init__()
        config = config or FuzzyIkConfig()
        check_bandwidth(bandwidth)
        builder = DiagramBuilder()
        whole = as_task(
            plant,
            config.frame,
            task or config.task,
            config.characteristic_length,
            joints=joints,
            reference_frame=reference_frame,
            context=context,
        )
        ik = AddFuzzyIkController(
            builder,
            plant,
            config=config,
            law=law,
            task=whole,
            collision_checker=collision_checker,
        )
        self.chain = chain = whole.arm.chain
        """The joints that are driven."""
        if plant.time_step() == 0.0:
            raise ValueError("the plant must be discrete, got a time step of 0.0 s")
        n, inputs = chain.num_joints, actuators(plant, chain)
        alone = plant.num_multibody_states() == 2 * n and inputs == list(range(n))
        reference = builder.AddNamedSystem(
            "joint_reference",
            JointReference(
                n,
                period=config.period,
                time_step=plant.time_step(),
                velocity_limits=chain.velocity_limits,
                acceleration_limits=acceleration_limits,
                jerk_limits=config.jerks(whole.arm),
                initial_position=chain.default_position,
            ),
        )
        servo = builder.AddNamedSystem(
            "inverse_dynamics",
            InverseDynamicsController(
                plant,
                kp=np.full(n, bandwidth**2),
                ki=np.zeros(n),
                kd=np.full(n, 2.0 * bandwidth),
                has_reference_acceleration=False,
            )
            if alone
            else ChainInverseDynamics(plant, chain, bandwidth=bandwidth),
        )
        size = plant.num_multibody_states()
        guard = builder.AddNamedSystem("state_guard", LastFinite(size, period=plant.time_step()))
        self._default_state = plant.GetPositionsAndVelocities(plant.CreateDefaultContext())
        self._ik, self._reference, self._guard = ik, reference, guard

        for name in ("commanded_position", "commanded_velocity"):
            builder.Connect(ik.GetOutputPort(name), reference.GetInputPort(name))
        builder.Connect(reference.get_output_port(), servo.GetInputPort("desired_state"))
        builder.Connect(guard.GetOutputPort("finite_signal"), servo.GetInputPort("estimated_state"))
        desired = ik.get_input_port(0)  # desired_position or desired_pose
        builder.ExportInput(desired, desired.get_name())
        for name in ("null_space_motion", "obstacle_position"):
            if ik.HasInputPort(name):
                builder.ExportInput(ik.GetInputPort(name), name)
        builder.ExportInput(guard.get_input_port(), "estimated_state")
        selected = Demultiplexer(np.array([n, n])) if alone else joint_positions(chain, size)
        measured = builder.AddNamedSystem("measured_positions", selected)
        builder.ConnectInput("estimated_state", measured.get_input_port())
        positions = measured.get_output_port(0)
        builder.Connect(positions, reference.GetInputPort("estimated_position"))
        if config.measured_position:
            self._feed_back(builder, positions)
        else:
            builder.Connect(positions, ik.GetInputPort("estimated_position"))
        builder.ExportOutput(servo.get_output_port(0), "actuation")
        for i in range(ik.num_output_ports()):
            port = ik.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        builder.ExportOutput(guard.GetOutputPort("valid"), "valid")
        builder.BuildInto(self)

    def _feed_back(self, builder: DiagramBuilder, measured: OutputPort) -> None:
        """The IK's position: its command plus what the plant's joints are off the reference."""
        n = measured.size()
        desired = builder.AddNamedSystem("desired_positions", Demultiplexer(np.array([n, n])))
        minus = builder.AddNamedSystem("minus", Gain(-1.0, n))
        total = builder.AddNamedSystem("estimated_position", Adder(3, n))
        builder.Connect(self._reference.get_output_port(), desired.get_input_port())
        builder.Connect(desired.get_output_port(0), minus.get_input_port())
        for i, port in enumerate(
            (
                measured,
                minus.get_output_port(),
                self._ik.GetOutputPort("commanded_position"),
            )
        ):
            builder.Connect(port, total.get_input_port(i))
        builder.Connect(total.get_output_port(), self._ik.GetInputPort("estimated_position"))

    def BlockingPair(self, context: Context) -> tuple[str, str]:
        """Scoped names of the bodies that push most in this Diagram's context; empty for none."""
        return self._ik.BlockingPair(self.GetSubsystemContext(self._ik, context))

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this controller's context, at rest.

        The plant's own positions are the plant's to set, `plant.SetPositions`.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        position = np.array(position, dtype=float)
        for system in (self._ik, self._reference):
            system.SetPositions(self.GetMutableSubsystemContext(system, context), position)
        state = self._default_state.copy()
        state[self.chain.position_indices] = position
        self._guard.SetLast(self.GetMutableSubsystemContext(self._guard, context), state)


def joint_positions(chain: SerialChain, num_states: int) -> MatrixGain:
    """A block that takes a plant's state and gives the chain's positions (n)."""
    select = np.zeros((chain.num_joints, num_states))
    select[np.arange(chain.num_joints), chain.position_indices] = 1.0
    return MatrixGain(select)


def AddFuzzyIkTorqueController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
    collision_checker: CollisionChecker | None = None,
    joints: Joints = None,
    reference_frame: str | Frame | None = None,
    context: Context | None = None,
    bandwidth: float = BANDWIDTH,
    acceleration_limits: float = ACCELERATION_LIMIT,
    estimated_state: OutputPort | None = None,
    name: str = "fuzzy_ik_torque_controller",
) -> FuzzyIkTorqueController:
    """Add a controller for `plant`, which is in `builder`, connect the two, and return it.

    The state is the plant's, or what `estimated_state` measures of it. The desired position or pose is
    left to connect. The actuation goes to the plant's port for all actuators, or to that of the joints'
    model instance where another controller has that one: Drake adds up what comes to both. See
    `FuzzyIkTorqueController` for all else.

    Raises:
        ValueError: see `FuzzyIkTorqueController`; or both ports are connected already.
    """
    controller = builder.AddNamedSystem(
        unique_name(builder, name),
        FuzzyIkTorqueController(
            plant,
            config=config,
            law=law,
            task=task,
            collision_checker=collision_checker,
            joints=joints,
            reference_frame=reference_frame,
            context=context,
            bandwidth=bandwidth,
            acceleration_limits=acceleration_limits,
        ),
    )
    state = estimated_state or plant.get_state_output_port()
    builder.Connect(state, controller.GetInputPort("estimated_state"))
    _connect_actuation(builder, plant, controller)
    return controller


def _connect_actuation(
    builder: DiagramBuilder, plant: MultibodyPlant, controller: FuzzyIkTorqueController
) -> None:
    """To the model instance's port if the joints are of one and it is free, else to that for all."""
    inputs = actuators(plant, controller.chain)
    everything, output = plant.get_actuation_input_port(), controller.GetOutputPort("actuation")
    by_instance: dict[ModelInstanceIndex, list[int]] = {}
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        by_instance.setdefault(actuator.model_instance(), []).append(actuator.input_start())
    for instance, starts in by_instance.items():
        port = plant.get_actuation_input_port(instance)
        whole = len(starts) == plant.num_actuators()
        if whole or not set(inputs) <= set(starts) or builder.IsConnectedOrExported(port):
            continue
        select = np.zeros((len(starts), plant.num_actuators()))
        select[np.arange(len(starts)), starts] = 1.0
        gain = MatrixGain(select)
        builder.AddNamedSystem(unique_name(builder, f"{controller.get_name()}_actuation"), gain)
        builder.Connect(output, gain.get_input_port())
        builder.Connect(gain.get_output_port(), port)
        return
    if builder.IsConnectedOrExported(everything):
        raise ValueError(
            "the plant's actuation ports are connected already: build a FuzzyIkTorqueController and add "
            "its port actuation to what comes to one of them"
        )
    builder.Connect(output, everything)
