"""From a scenario to a Diagram."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, SceneGraph
from pydrake.manipulation import IiwaDriver, SimIiwaDriver, kIiwaArmNumJoints
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, PdControllerGains
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    Adder,
    ConstantVectorSource,
    MatrixGain,
    Multiplexer,
)
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.laws.law import LawLike
from fikm_drake.simulation.scenario.environment import (
    Kinematic,
    Sensor,
    Servos,
    SimIiwa,
    TorqueDriven,
)
from fikm_drake.simulation.scenario.motion import Motion
from fikm_drake.simulation.scenario.robots import Robot
from fikm_drake.simulation.scenario.schema import Scenario
from fikm_drake.simulation.scenario.sensors import add_joint_sensor, add_state_sensor
from fikm_drake.simulation.scenario.site import Site, Wired
from fikm_drake.simulation.scenario.surroundings import Surroundings, add_world
from fikm_drake.systems.joint_sensor import JointSensor
from fikm_drake.systems.target_source import TargetSource


@dataclass(frozen=True)
class BuiltScenario:
    """A scenario's Diagram, and where its parts are."""

    scenario: Scenario
    diagram: Diagram
    plant: MultibodyPlant
    """In the Diagram, but in kinematic runs, where its geometry follows the command; see `plant_context`."""
    scene_graph: SceneGraph
    robot: Robot
    chain: SerialChain
    motion: Motion
    """The target that the controller gets."""
    wired: Wired
    sensor: JointSensor | None
    rest: Array
    """Default positions of the whole plant."""
    surroundings: Surroundings | None = None
    """What is near the robot; None where nothing stands about it."""
    driver_model: MultibodyPlant | None = None
    """What Drake's driver computes with; it must live as long as the Diagram."""

    @property
    def is_kinematic(self) -> bool:
        """Whether the robot is where its command is."""
        return isinstance(self.scenario.plant_options(), Kinematic)

    def set_start(self, root: Context) -> None:
        """Put controller, plant and sensor where the scenario starts."""
        start = self.scenario.start()
        self.wired.set_start(root, start)
        measured = start
        if not self.is_kinematic:
            context = self.plant.GetMyMutableContextFromRoot(root)
            q = self.chain.to_full(start, self.plant.GetPositions(context))
            self.plant.SetPositions(context, q)
            if isinstance(self.scenario.plant_options(), TorqueDriven):
                measured = self.plant.GetPositionsAndVelocities(context)
        if self.sensor is not None:
            self.sensor.SetPositions(self.sensor.GetMyMutableContextFromRoot(root), measured)

    def positions(self, root: Context) -> Array:
        """Joint positions (n,) of the robot [rad or m]."""
        if self.is_kinematic:
            command = self.wired.command
            return command.Eval(command.get_system().GetMyContextFromRoot(root))
        return self.chain.from_full(self.all_positions(root))

    def all_positions(self, root: Context) -> Array:
        """All positions of `plant`, those that no controller moves too."""
        if self.is_kinematic:
            return self.chain.to_full(self.positions(root), self.rest)
        return self.plant.GetPositions(self.plant.GetMyContextFromRoot(root))

    def plant_context(self, root: Context) -> Context:
        """A Context of `plant` with the robot where it is: the Diagram's own, in kinematic runs a copy."""
        if not self.is_kinematic:
            return self.plant.GetMyContextFromRoot(root)
        context = self.plant.CreateDefaultContext()
        self.plant.SetPositions(context, self.all_positions(root))
        return context


def build_scenario(
    scenario: Scenario,
    *,
    law: LawLike | None = None,
    meshcat: Meshcat | None = None,
    target: Callable[[DiagramBuilder, Motion], OutputPort] | None = None,
) -> BuiltScenario:
    """The Diagram of a scenario: target, controller, sensor, the robot's plant and its SceneGraph.

    A log, a visualizer and a collision query all see the same robot: in kinematic runs Drake's
    `MultibodyPositionToGeometryPose` puts the plant's geometry where the command is.

        built = fd.build_scenario(fd.load_scenario("table6_10s"), meshcat=StartMeshcat())
        simulator = Simulator(built.diagram)
        built.set_start(simulator.get_mutable_context())
        simulator.AdvanceTo(10.0)

    Args:
        scenario: what to build.
        law: another law in place of the controller's own.
        meshcat: where the run is shown; None: nowhere.
        target: makes another source of targets, of the same kind as the scenario's.

    Raises:
        ValueError: the scenario is not valid, or its parts do not fit together.
    """
    scenario.validate()
    builder = DiagramBuilder()
    robot, option = scenario.load_robot(), scenario.plant_options()
    plant, scene_graph, source = _plant(builder, scenario, robot)
    chain = robot.chain(plant)
    rest = plant.GetPositions(plant.CreateDefaultContext())
    motion, start = scenario.target_motion(), scenario.start()
    surroundings = Surroundings.of(scenario, robot, chain)
    sensor = None
    if isinstance(option, TorqueDriven) and scenario.sensor != Sensor():
        sensor = add_state_sensor(builder, scenario, option, plant, chain)
    site = Site(
        builder,
        robot,
        plant,
        chain,
        motion.size,
        scenario.control_rate,
        start,
        option if isinstance(option, TorqueDriven) else None,
        sensor and sensor.get_output_port(),
        surroundings.checker if surroundings and scenario.avoids else None,
        scenario.clearance,
    )
    wired = scenario.controller_options().add(site, law)
    if wired.size == 7 and motion.orientation is None:
        motion = _hold_orientation(motion, chain, start)
    model = None
    desired = target(builder, motion) if target else _source(builder, motion)
    builder.Connect(desired, wired.desired)
    if isinstance(option, Kinematic):
        full = _full_position(builder, chain, rest, wired.command)
        poses = MultibodyPositionToGeometryPose(plant)
        builder.AddNamedSystem("robot", poses)
        builder.Connect(full, poses.get_input_port())
        builder.Connect(poses.get_output_port(), scene_graph.get_source_pose_port(source))
    elif isinstance(option, (Servos, SimIiwa)):
        model = _drive(builder, option, plant, chain, robot, wired.command)
    sensor = sensor or add_joint_sensor(builder, scenario, plant, chain, wired)
    if meshcat is not None:
        MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    diagram.set_name(f"{robot.name} scenario")
    return BuiltScenario(
        scenario,
        diagram,
        plant,
        scene_graph,
        robot,
        chain,
        motion,
        wired,
        sensor,
        rest,
        surroundings,
        model,
    )


def _plant(
    builder: DiagramBuilder, scenario: Scenario, robot: Robot
) -> tuple[MultibodyPlant, SceneGraph, object]:
    """The finalized plant with robot and obstacles, its SceneGraph, and its source there."""
    option = scenario.plant_options()
    if isinstance(option, Kinematic):
        scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
        plant = MultibodyPlant(time_step=0.0)
        source = plant.RegisterAsSourceForSceneGraph(scene_graph)
    else:
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=option.time_step)
        plant.set_name("plant")
        source = plant.get_source_id()
    add_world(plant, robot, scenario.obstacles)
    if isinstance(option, Servos):
        gains = PdControllerGains(p=option.stiffness, d=option.damping)
        for index in plant.GetJointActuatorIndices():
            plant.get_joint_actuator(index).set_controller_gains(gains)
    plant.Finalize()
    return plant, scene_graph, source


def _source(builder: DiagramBuilder, motion: Motion) -> OutputPort:
    function = motion.position if motion.orientation is None else motion.pose
    return builder.AddNamedSystem("desired", TargetSource(function)).get_output_port()


def _hold_orientation(motion: Motion, chain: SerialChain, start: Array) -> Motion:
    """The target with the orientation that the tool has at the start."""
    rotation = RigidTransform(chain.forward_kinematics(start)).rotation()
    return Motion(7, motion.duration, motion.position, lambda _: rotation, motion.corners)


def _full_position(
    builder: DiagramBuilder, chain: SerialChain, q: Array, command: OutputPort
) -> OutputPort:
    """The command in the plant's default positions q."""
    n = chain.num_joints
    if command.size() != n:
        raise ValueError(f"the controller commands {command.size()} joints, the tool has {n}")
    assert chain.position_indices is not None
    if len(q) == n and np.array_equal(chain.position_indices, np.arange(n)):
        return command
    spread = np.zeros((len(q), n))
    spread[chain.position_indices, np.arange(n)] = 1.0
    rest = builder.AddNamedSystem(
        "other_joints", ConstantVectorSource(chain.to_full(np.zeros(n), q))
    )
    gain = builder.AddNamedSystem("controlled_joints", MatrixGain(spread))
    total = builder.AddNamedSystem("all_joints", Adder(2, len(q)))
    builder.Connect(command, gain.get_input_port())
    builder.Connect(gain.get_output_port(), total.get_input_port(0))
    builder.Connect(rest.get_output_port(), total.get_input_port(1))
    return total.get_output_port()


def _drive(
    builder: DiagramBuilder,
    option: Servos | SimIiwa,
    plant: MultibodyPlant,
    chain: SerialChain,
    robot: Robot,
    command: OutputPort,
) -> MultibodyPlant | None:
    """Servos or Drake's driver between the position command and the plant; the driver's own model."""
    n = chain.num_joints
    instance = plant.get_body(robot_body(plant, robot.frame_name(plant))).model_instance()
    if plant.num_positions(instance) != n or plant.num_actuators(instance) != n:
        raise ValueError(
            f"plant {type(option).__name__} needs a robot with nothing but the {n} joints that the "
            f"controller moves, each with an actuator; this one has {plant.num_positions(instance)} "
            f"joints and {plant.num_actuators(instance)} actuators"
        )
    if isinstance(option, SimIiwa):
        if n != kIiwaArmNumJoints:
            raise ValueError(f"plant sim_iiwa needs an arm of {kIiwaArmNumJoints} joints, not {n}")
        model = MultibodyPlant(option.time_step)
        robot.add(model)
        model.Finalize()
        driver = SimIiwaDriver.AddToBuilder(
            builder, plant, instance, IiwaDriver(control_mode="position_only"), model
        )
        driver.set_name("driver")
        builder.Connect(command, driver.GetInputPort("position"))
        return model
    rest = builder.AddNamedSystem("rest", ConstantVectorSource(np.zeros(n)))
    state = builder.AddNamedSystem("servo_target", Multiplexer([n, n]))
    builder.Connect(command, state.get_input_port(0))
    builder.Connect(rest.get_output_port(), state.get_input_port(1))
    builder.Connect(state.get_output_port(), plant.get_desired_state_input_port(instance))
    return None


def robot_body(plant: MultibodyPlant, frame: str) -> BodyIndex:
    """The body that carries a frame, by `name` or `instance::name`."""
    instance, _, name = frame.rpartition("::")
    if instance:
        return plant.GetFrameByName(name, plant.GetModelInstanceByName(instance)).body().index()
    return plant.GetFrameByName(name).body().index()
