"""Fuzzy IK in front of inverse dynamics: from a desired position to joint torques."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import Adder, Demultiplexer, Gain

from fikm_drake.checks import check_bandwidth
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.laws import LawLike
from fikm_drake.systems.joint_reference import JointReference
from fikm_drake.systems.last_finite import LastFinite

BANDWIDTH = 100.0
"""Of the inner loop by default [rad/s]."""
ACCELERATION_LIMIT = 20.0
"""Of the joints' reference by default [rad/s² or m/s²]."""


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
    - **estimated_state** (2n) [q; v]: the plant's; command and reference start there.
    - **actuation** (n) [N m or N]: for the plant, of Drake's `InverseDynamicsController`.
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
        plant: a finalized, discrete plant, fully actuated, with nothing but the arm; it is not
            copied and must live as long.
        config: by default `FuzzyIkConfig()`.
        law: another law than the config's.
        task: another task than the config's, an object.
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
        bandwidth: float = BANDWIDTH,
        acceleration_limits: float = ACCELERATION_LIMIT,
    ) -> None:
        super().__init__()
        config = config or FuzzyIkConfig()
        check_bandwidth(bandwidth)
        builder = DiagramBuilder()
        ik = AddFuzzyIkController(builder, plant, config=config, law=law, task=task)
        n = plant.num_positions()
        if plant.time_step() == 0.0 or plant.num_actuators() != n:
            raise ValueError(
                f"the plant must be discrete with an actuator for each of its {n} joints, "
                f"got a time step of {plant.time_step()} s and {plant.num_actuators()} actuators"
            )
        reference = builder.AddNamedSystem(
            "joint_reference",
            JointReference(
                n,
                period=config.period,
                time_step=plant.time_step(),
                velocity_limits=plant.GetVelocityUpperLimits(),
                acceleration_limits=acceleration_limits,
                initial_position=plant.GetPositions(plant.CreateDefaultContext()),
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
            ),
        )
        guard = builder.AddNamedSystem("state_guard", LastFinite(2 * n, period=plant.time_step()))
        self._ik, self._reference, self._guard = ik, reference, guard

        for name in ("commanded_position", "commanded_velocity"):
            builder.Connect(ik.GetOutputPort(name), reference.GetInputPort(name))
        builder.Connect(reference.get_output_port(), servo.get_input_port_desired_state())
        builder.Connect(
            guard.GetOutputPort("finite_signal"), servo.get_input_port_estimated_state()
        )
        desired = ik.get_input_port(0)  # desired_position or desired_pose
        builder.ExportInput(desired, desired.get_name())
        builder.ExportInput(guard.get_input_port(), "estimated_state")
        measured = builder.AddNamedSystem("measured_positions", Demultiplexer(np.array([n, n])))
        builder.ConnectInput("estimated_state", measured.get_input_port())
        positions = measured.get_output_port(0)
        builder.Connect(positions, reference.GetInputPort("estimated_position"))
        if config.measured_position:
            self._feed_back(builder, positions)
        else:
            builder.Connect(positions, ik.GetInputPort("estimated_position"))
        builder.ExportOutput(servo.get_output_port_control(), "actuation")
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
        state = np.concatenate([position, np.zeros(len(position))])
        self._guard.SetLast(self.GetMutableSubsystemContext(self._guard, context), state)


def AddFuzzyIkTorqueController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    *,
    config: FuzzyIkConfig | None = None,
    law: LawLike | None = None,
    task: TaskKinematics | None = None,
    bandwidth: float = BANDWIDTH,
    acceleration_limits: float = ACCELERATION_LIMIT,
    name: str = "fuzzy_ik_torque_controller",
) -> FuzzyIkTorqueController:
    """Add a controller for `plant`, which is in `builder`, connect the two, and return it.

    Its desired position or pose is left to connect. See `FuzzyIkTorqueController` for all else.
    """
    controller = builder.AddNamedSystem(
        name,
        FuzzyIkTorqueController(
            plant,
            config=config,
            law=law,
            task=task,
            bandwidth=bandwidth,
            acceleration_limits=acceleration_limits,
        ),
    )
    builder.Connect(plant.get_state_output_port(), controller.GetInputPort("estimated_state"))
    builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
    return controller
