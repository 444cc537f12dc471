"""Inverse dynamics of some joints of a plant that holds more than an arm."""

import threading

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.checks import check_bandwidth
from fikm_drake.kinematics.serial_chain import SerialChain


class ChainInverseDynamics(LeafSystem):
    """Torques that make a chain's joints follow a desired state, whatever else the plant holds.

    .. pydrake_system::

        name: ChainInverseDynamics
        input_ports:
        - estimated_state
        - desired_state
        output_ports:
        - actuation

    - **estimated_state** (nq + nv): of the whole plant, finite: `LastFinite` before it sees to that.
    - **desired_state** (2n) [q; v]: of the chain's joints.
    - **actuation** (num_actuators) [N m or N]: of all of the plant's actuators, zero for others; Drake adds
      up what comes to a plant's ports for all actuators and for those of a model instance.

    Like Drake's `InverseDynamicsController`, which takes plants with nothing but the arm: mass,
    Coriolis terms and gravity are cancelled, what a gripper or a held body that is welded to it adds
    too, and each joint is left a critically damped second-order error. Other joints are taken not to
    accelerate; contact is not known.

    Args:
        plant: a finalized plant; it is not copied.
        chain: the joints, each with an actuator; of `SerialChain.from_plant`.
        bandwidth: of the error [rad/s].

    Raises:
        ValueError: a joint has no actuator, or the bandwidth is not positive and finite.
    """

    def __init__(self, plant: MultibodyPlant, chain: SerialChain, *, bandwidth: float) -> None:
        super().__init__()
        check_bandwidth(bandwidth)
        self._plant, self._n = plant, chain.num_joints
        self._inputs = actuators(plant, chain)
        self._q, self._v = chain.position_indices, chain.velocity_indices
        self._kp, self._kd = bandwidth**2, 2.0 * bandwidth
        self._scratch = _Scratch(plant)
        state = plant.num_multibody_states()
        self._estimated = self.DeclareVectorInputPort("estimated_state", state).Eval
        self._desired = self.DeclareVectorInputPort("desired_state", 2 * self._n).Eval
        self.DeclareVectorOutputPort(
            "actuation",
            plant.num_actuators(),
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        plant, scratch = self._plant, self._scratch.context
        state, desired = self._estimated(context), self._desired(context)
        plant.SetPositionsAndVelocities(scratch, state)
        q, v = state[self._q], state[plant.num_positions() :][self._v]
        acceleration = np.zeros(plant.num_velocities())
        acceleration[self._v] = self._kp * (desired[: self._n] - q) + self._kd * (
            desired[self._n :] - v
        )
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(scratch, forces)
        torque = plant.CalcInverseDynamics(scratch, acceleration, forces)
        actuation = np.zeros(plant.num_actuators())
        actuation[self._inputs] = torque[self._v]
        output.set_value(actuation)


def actuators(plant: MultibodyPlant, chain: SerialChain) -> list[int]:
    """Where the chain's joints stand in the plant's vector of actuations (n).

    Raises:
        ValueError: joints have no actuator; the message names them.
    """
    starts = {}
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        starts[actuator.joint().velocity_start()] = actuator.input_start()
    velocities = [] if chain.velocity_indices is None else chain.velocity_indices.tolist()
    if lacking := [n for n, v in zip(chain.joint_names, velocities) if v not in starts]:
        raise ValueError(
            f"torque control needs an actuator for each joint, {lacking} have none: add a transmission "
            "to the URDF, plant.AddJointActuator before Finalize, or leave them out of joints="
        )
    return [starts[v] for v in velocities]


class _Scratch(threading.local):
    """A plant Context for each thread; each use writes all of it that it reads."""

    def __init__(self, plant: MultibodyPlant) -> None:
        self.context = plant.CreateDefaultContext()
