"""How a scenario's sensor stands between the robot and its controller."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.simulation.scenario.environment import Kinematic, TorqueDriven
from fikm_drake.simulation.scenario.schema import Scenario
from fikm_drake.simulation.scenario.site import Wired
from fikm_drake.systems.joint_sensor import JointSensor


def add_state_sensor(
    builder: DiagramBuilder,
    scenario: Scenario,
    option: TorqueDriven,
    plant: MultibodyPlant,
    chain: SerialChain,
) -> JointSensor:
    """What measures the state of a torque-driven plant; noise is in the controller's joints only."""
    measured = scenario.sensor
    noise = np.zeros(plant.num_multibody_states())
    noise[chain.position_indices] = measured.noise
    noise[plant.num_positions() :][chain.velocity_indices] = measured.speed_noise
    sensor = builder.AddNamedSystem(
        "sensor",
        JointSensor(
            len(noise),
            period=1.0 / measured.rate if measured.rate else option.time_step,
            delay=measured.delay,
            noise=noise,
            seed=scenario.seed,
        ),
    )
    builder.Connect(plant.get_state_output_port(), sensor.get_input_port())
    return sensor


def add_joint_sensor(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    chain: SerialChain,
    wired: Wired,
) -> JointSensor | None:
    """What the controller measures; None where it does not."""
    if wired.measured is None:
        return None
    option = scenario.sensor
    sensor = builder.AddNamedSystem(
        "sensor",
        JointSensor(
            chain.num_joints,
            period=1.0 / (option.rate or scenario.control_rate),
            delay=option.delay,
            noise=option.noise,
            seed=scenario.seed,
        ),
    )
    if isinstance(scenario.plant_options(), Kinematic):
        builder.Connect(wired.command, sensor.get_input_port())
    else:
        pick = np.zeros((chain.num_joints, plant.num_positions() + plant.num_velocities()))
        pick[np.arange(chain.num_joints), chain.position_indices] = 1.0
        gain = builder.AddNamedSystem("measured_joints", MatrixGain(pick))
        builder.Connect(plant.get_state_output_port(), gain.get_input_port())
        builder.Connect(gain.get_output_port(), sensor.get_input_port())
    builder.Connect(sensor.get_output_port(), wired.measured)
    return sensor
