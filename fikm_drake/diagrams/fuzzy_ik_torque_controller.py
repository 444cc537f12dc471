"""Fuzzy IK in front of inverse dynamics: from a desired position to joint torques."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import Demultiplexer

from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController
from fikm_drake.laws.law import Law
from fikm_drake.systems.checks import check_bandwidth
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.systems.joint_reference import JointReference
from fikm_drake.systems.last_finite import LastFinite

BANDWIDTH = 100.0
"""Of the inner loop by default [rad/s]."""
ERROR_LIMIT = 0.05
"""Of the controller by default [m]."""


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
        - status
        - valid

    - **desired_position** (m) [m], or **desired_pose**: as of `FuzzyIkController`.
    - **estimated_state** (2n) [q; v]: the plant's.
    - **actuation** (n) [N m or N]: for the plant, of Drake's `InverseDynamicsController`.
    - **valid** (1): 1 while the estimated state is finite, else 0; the inner loop then goes on from
      the last one that was.
    - all other outputs: as of `FuzzyIkController`, described there.

    The controller's position command, a new one each period, becomes a reference at the plant's rate
    by a first-order hold (`JointReference`); its slope is the commanded velocity. The inner loop
    cancels the arm's own dynamics and gravity and leaves each joint a critically damped second-order
    error of `bandwidth`.

    The command must be one that the arm can follow. A target that steps asks for speed at once, and
    an inner loop at its effort limits is not stable: keep `config.error_limit` small, as the default
    does, or let the target move.

    With `config.measured_position` the IK starts from the plant's joints, and the inner loop's lag
    is in its loop: Table I's gains need a bandwidth of at least 1 / period, better twice that; lower
    the gains of `config.supervisor` for a slower one. Too high gains make the arm swing ever more.

    Args:
        plant: a finalized, discrete plant, fully actuated, with nothing but the arm; it is not
            copied and must live as long.
        config: by default `FuzzyIkConfig` with an `error_limit` of `ERROR_LIMIT`.
        law: another law in place of the fuzzy mapping that the config describes.
        bandwidth: of the inner loop [rad/s].

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        config: FuzzyIkConfig | None = None,
        law: Law | None = None,
        bandwidth: float = BANDWIDTH,
    ) -> None:
        super().__init__()
        config = config or FuzzyIkConfig(error_limit=ERROR_LIMIT)
        check_bandwidth(bandwidth)
        builder = DiagramBuilder()
        ik = AddFuzzyIkController(builder, plant, config=config, law=law)
        n = plant.num_positions()
        if plant.time_step() == 0.0 or plant.num_actuators() != n:
            raise ValueError(
                f"the plant must be discrete with an actuator for each of its {n} joints, "
                f"got a time step of {plant.time_step()} s and {plant.num_actuators()} actuators"
            )
        reference = builder.AddNamedSystem(
            "joint_reference",
            JointReference(n, period=config.period, time_step=plant.time_step()),
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
        if config.measured_position:
            split = builder.AddNamedSystem("positions", Demultiplexer(np.array([n, n])))
            builder.ConnectInput("estimated_state", split.get_input_port())
            builder.Connect(split.get_output_port(0), ik.GetInputPort("estimated_position"))
        builder.ExportOutput(servo.get_output_port_control(), "actuation")
        for i in range(ik.num_output_ports()):
            port = ik.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        builder.ExportOutput(guard.GetOutputPort("valid"), "valid")
        builder.BuildInto(self)

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
    law: Law | None = None,
    bandwidth: float = BANDWIDTH,
    name: str = "fuzzy_ik_torque_controller",
) -> FuzzyIkTorqueController:
    """Add a controller for `plant`, which is in `builder`, connect the two, and return it.

    Its desired position or pose is left to connect. See `FuzzyIkTorqueController` for all else.
    """
    controller = builder.AddNamedSystem(
        name, FuzzyIkTorqueController(plant, config=config, law=law, bandwidth=bandwidth)
    )
    builder.Connect(plant.get_state_output_port(), controller.GetInputPort("estimated_state"))
    builder.Connect(controller.GetOutputPort("actuation"), plant.get_actuation_input_port())
    return controller
