"""The one schema: every controller, target, plant and sensor from YAML to a log."""

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.trajectories import PiecewisePolynomial, PiecewisePose

import fikm_drake as fd
from fikm_drake.simulation.scenario import (
    Circle,
    Csv,
    Fuzzy,
    Model,
    Obstacle,
    Path,
    Pose,
    Samples,
    Scenario,
    Sensor,
)

SHORT = """\
robot: panda
controller: fuzzy
target:
  poses:
  - {xyz: [0.4, 0.1, 0.5], rpy: [3.14159, 0.0, 0.0]}
  - {xyz: [0.5, -0.1, 0.4], rpy: [3.0, 0.1, 0.2]}
  duration: 3.0
"""
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
"""Of the Panda."""


def load(text, tmp_path):
    (tmp_path / "mine.yaml").write_text(text)
    return fd.load_scenario(tmp_path / "mine.yaml")


def test_the_short_pose_run_ends_at_its_pose(tmp_path):
    log = fd.simulate(load(SHORT, tmp_path))
    assert log.status_names[-1] == "CONVERGED"
    wanted = RigidTransform(RollPitchYaw(3.0, 0.1, 0.2), [0.5, -0.1, 0.4])
    tool = fd.load_arm("panda").forward_kinematics(log.q[-1])
    np.testing.assert_allclose(tool, wanted.GetAsMatrix4(), atol=1e-3)
    assert log.error_after.shape == (171, 6) and log.desired.shape == (171, 7)
    metrics = log.metrics()
    assert metrics.e_ss < 1e-3 and metrics.turn_ss < 1e-3 and "turned off" in str(metrics)


CONTROLLERS = {
    "frmrc": "robot: kim_lee3r\ncontroller: !Frmrc {sweeps: 3}\n"
    "target: {positions: [[0.98, 0.39], [0.9, 0.5]], duration: 0.5, hold: 0.6}\n"
    "initial_position: [-0.5, 1.0, 0.8]\n",
    "paper 3's own": "robot: kim_lee3r\ncontroller: !Frmrc {variant: paper, own_reach: true}\n"
    "target: {positions: [[0.98, 0.39], [0.9, 0.5]], duration: 0.5, hold: 3.0}\n"
    "initial_position: [-0.5, 1.0, 0.8]\n",
    "supervised_drake": SHORT.replace("fuzzy", "supervised_drake").replace("3.0\n", "1.0\n"),
    "labvolt": "robot: labvolt5250\ncontroller: labvolt\n"
    "target: {positions: [[0.3, 0.0, 0.2], [0.25, 0.1, 0.25]], duration: 0.3}\n",
    "redundancy": "robot: hassantabar3r\ncontroller: redundancy\n"
    "target: {positions: [[1.0, 2.0], [1.0, 2.5]], duration: 0.3}\n",
    "integer": "robot: tojo4dof\ncontroller: !Integer {labels: [9, 9], conjunction: product}\n"
    "target: {positions: [[0.0, 0.25, 0.0], [0.05, 0.25, 0.0]], duration: 0.3}\n",
}
WITHIN = {"paper 3's own": 2e-3, "integer": 0.03}


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_controller_reaches_its_target(name, tmp_path):
    scenario = load(CONTROLLERS[name], tmp_path)
    if name == "integer":
        plane = fd.load_workplane("tojo4dof")
        points = plane.to_world([[100, 100], [150, 120]]).tolist()
        scenario = scenario.but(target__positions=points)
    log = fd.simulate(scenario)
    np.testing.assert_array_equal(log.q[0], scenario.start())
    assert np.linalg.norm(log.cycles.error[-1][-3:]) < WITHIN.get(name, 1e-3)
    assert {"time", *log.names} >= {"desired", "actual", "q", "command", "velocity"}
    assert all(text.isupper() for text in log.status_names)
    if name == "supervised_drake":
        assert "CONVERGED" not in log.status_names[:5] and log.status_names[-1] == "CONVERGED"
    np.testing.assert_allclose(
        np.diff(log.q, axis=0)[1:] * scenario.control_rate, log.velocity[2:], atol=1e-6
    )


@pytest.mark.parametrize("plant", ["torque_driven", "servos", "sim_iiwa"])
def test_every_plant_follows(plant):
    start = [0.1, 0.6, 0.0, -1.5, 0.0, 1.0, 0.0]
    scenario = Scenario(
        robot="iiwa14",
        target=Path(positions=[[0.5, 0.0, 0.5]], hold=1.5),
        plant=plant,
        initial_position=start,
    )
    log = fd.simulate(scenario)
    np.testing.assert_array_equal(log.q[0], start)
    assert np.linalg.norm(log.cycles.error[-1]) < 0.02
    assert np.isfinite(log.torque).all() and np.abs(log.torque[-1]).max() > 1.0
    assert (log.q[1:] != log.command[1:]).any()


def test_a_model_file_with_its_frame_and_joints(tmp_path):
    """A URDF with a gripper joint behind the tool: it is no business of the controller's."""
    arm = fd.load_arm("planar4")
    gripper = (
        '<link name="finger"/><joint name="finger_joint" type="prismatic"><parent link="tool"/>'
        '<child link="finger"/><axis xyz="1 0 0"/><limit lower="0" upper="0.04" effort="5"/>'
        "</joint></robot>"
    )
    (tmp_path / "mine.urdf").write_text(arm.to_urdf().replace("</robot>", gripper))
    text = (
        "robot: {file: mine.urdf, frame: tool, joints: [joint1, joint2, joint3, joint4]}\n"
        "target: {positions: [[0.6, 0.6]], hold: 2.0}\ninitial_position: [-0.6, 0.9, 0.9, -1.2]\n"
    )
    scenario = load(text, tmp_path)
    log = fd.simulate(scenario)
    same = fd.simulate(scenario.but(robot="planar4"))
    np.testing.assert_allclose(log.q, same.q, atol=1e-9)
    log.save(tmp_path / "run.npz")
    assert fd.RunLog.load(tmp_path / "run.npz").scenario == scenario


@pytest.mark.parametrize(
    "target",
    [
        Path(positions=[[0.5, 0.0, 0.4], [0.4, 0.2, 0.5], [0.3, 0.2, 0.5]], duration=2.0),
        Path(
            positions=[[0.5, 0.0, 0.4], [0.4, 0.2, 0.5], [0.3, 0.2, 0.5]],
            duration=2.0,
            shape="spline",
            profile="cubic",
        ),
        Path(poses=[Pose([0.4, 0.1, 0.5], [3.1, 0, 0]), Pose([0.4, 0.1, 0.5], [], [0, 1, 1, 0])]),
        Circle(center=[0.4, 0.0, 0.5], radius=0.1, normal=[1.0, 0.0, 0.0], cycles=2.0),
        Circle(center=[0.4, 0.0, 0.5], rpy=[3.1, 0.0, 0.0], profile="cubic"),
        Samples([0.0, 1.0], [[0.4, 0.0, 0.5], [0.5, 0.0, 0.5]], interpolation="hold"),
        Samples([0.0, 1.0], [[1.0, 0, 0, 0, 0.4, 0, 0.5], [0.9, 0.1, 0, 0, 0.5, 0, 0.5]]),
    ],
    ids=lambda target: type(target).__name__,
)
def test_targets_round_trip_and_move_without_jumps(target):
    scenario = Scenario(
        robot="panda",
        target=target,
        obstacles=[Obstacle([0.5, 0.5, 0.1], box=[0.1, 0.1, 0.2])],
        initial_position=READY,
    )
    text = yaml_dump_typed(scenario)
    assert yaml_load_typed(schema=Scenario, data=text, retain_map_defaults=True) == scenario
    motion = target.motion()
    if isinstance(target, Samples) and target.interpolation == "hold":
        return
    times = np.linspace(0.0, target.duration + 0.1, 200)
    rows = np.array([motion.numbers(t) for t in times])
    rows[:, :-3] *= np.sign(rows[:, :1])  # a quaternion's sign means nothing
    assert np.abs(np.diff(rows, axis=0)).max() < 0.03
    np.testing.assert_allclose(rows[-1, -3:], motion.corners[-1], atol=1e-9)


def test_circle_is_round_and_turns_as_told():
    motion = Circle(center=[0.4, 0.1, 0.5], radius=0.2, normal=[0, 1, 1], duration=4.0).motion()
    points = np.array([motion.position(t) for t in np.linspace(0, 4, 81)])
    away = points - [0.4, 0.1, 0.5]
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 0.2)
    np.testing.assert_allclose(away @ [0, 1, 1], 0.0, atol=1e-12)
    turned = np.cross(away[:-1], away[1:]) @ [0, 1, 1] / np.sqrt(2)
    np.testing.assert_allclose(turned, 0.04 * np.sin(2 * np.pi / 80), rtol=1e-9)


def test_a_table_and_a_trajectory_of_drakes(tmp_path):
    (tmp_path / "path.csv").write_text("time_s,x_m,y_m,z_m\n0,0.4,0,0.5\n1,0.5,0,0.5\n")
    text = "robot: panda\ntarget: !Csv {file: path.csv}\n" + f"initial_position: {READY}\n"
    table = load(text, tmp_path)
    line = PiecewisePolynomial.FirstOrderHold(
        [0.0, 1.0], np.array([[0.4, 0.5], [0.0, 0.0], [0.5, 0.5]])
    )
    python = Scenario(robot="panda", target=line, initial_position=READY)
    np.testing.assert_allclose(table.targets(), python.targets(), atol=1e-12)
    np.testing.assert_array_equal(fd.simulate(table).q[5:7], fd.simulate(python).q[5:7])
    assert isinstance(fd.simulate(table).scenario.target, Samples)  # the log needs no file
    poses = PiecewisePose.MakeLinear(
        [0.0, 1.0], [RigidTransform([0.4, 0, 0.5]), RigidTransform([0.5, 0, 0.5])]
    )
    assert Scenario(robot="panda", target=poses).target_motion().size == 7
    (tmp_path / "path.csv").write_text("time_s,x_m,y_m,z_m\n0,0.4,0,0.5\n1,0.5,zero,0.5\n")
    with pytest.raises(ValueError, match="line 3.*zero"):
        table.validate()
    with pytest.raises(FileNotFoundError):
        Csv(str(tmp_path / "gone.csv")).motion()


def test_sensor_noise_delay_and_rate_are_in_the_loop():
    def run(**options):
        scenario = Scenario(
            robot="planar4",
            controller=Fuzzy(fd.FuzzyIkConfig(measured_position=True)),
            target=Path(positions=[[0.6, 0.6]], hold=1.0),
            sensor=Sensor(**options),
            initial_position=[-0.6, 0.9, 0.9, -1.2],
            seed=3 if options.get("noise") else 0,
        )
        return fd.simulate(scenario)

    perfect, noisy, again = run(), run(noise=1e-3), run(noise=1e-3)
    ideal = fd.simulate(perfect.scenario.with_config(fd.FuzzyIkConfig()))
    np.testing.assert_allclose(perfect.q, ideal.q, atol=1e-12)  # a perfect sensor changes nothing
    np.testing.assert_array_equal(noisy.q, again.q)
    assert 1e-5 < np.abs(noisy.q - perfect.q).max() < 0.1
    late = run(delay=0.04)
    np.testing.assert_array_equal(late.q[:2], perfect.q[:2])
    assert np.abs(late.q - perfect.q).max() > 1e-3


def test_a_pose_task_on_positions_holds_the_orientation_of_the_start():
    log = fd.simulate(
        Scenario(
            robot="panda",
            controller=Fuzzy(
                fd.FuzzyIkConfig(task="pose", law=fd.FuzzyMapping(iterations=6, damping=0.1))
            ),
            target=Path(positions=[[0.4, 0.1, 0.5]], hold=3.0),
            initial_position=READY,
        )
    )
    assert log.error_after.shape[1] == 6
    start, end = fd.load_arm("panda").forward_kinematics(log.q[[0, -1]])
    np.testing.assert_allclose(end[:3, :3], start[:3, :3], atol=3e-3)
    np.testing.assert_allclose(end[:3, 3], [0.4, 0.1, 0.5], atol=3e-3)


BAD = {
    "unknown option": (SHORT + "speed: 3\n", ["speed"]),
    "unknown controller": (SHORT.replace("fuzzy", "magic"), ["'magic'", "frmrc", "labvolt"]),
    "unknown tag": (SHORT.replace("fuzzy", "!Magic {}"), ["Magic"]),
    "unknown option of a controller": (SHORT.replace("fuzzy", "!Frmrc {a: 3}"), ["'a'"]),
    "unknown plant": (SHORT + "plant: jelly\n", ["'jelly'", "kinematic", "sim_iiwa"]),
    "both targets": (SHORT + "  positions: [[0.1, 0.2, 0.3]]\n", ["positions or poses"]),
    "no orientation": (SHORT.replace(", rpy: [3.0, 0.1, 0.2]", ""), ["rpy", "quaternion"]),
    "sensor unused": (SHORT + "sensor: {noise: 0.1}\n", ["sensor is not used"]),
    "seed unused": (SHORT + "seed: 4\n", ["seed 4 is not used"]),
    "rate unused": (
        SHORT.replace("fuzzy", "{config: {control_rate: 10.0}}"),
        ["10", "not used"],
    ),
    "task that does not fit": (SHORT.replace("fuzzy", "{config: {task: xy}}"), ["'xy'", "pose"]),
    "no robot": (SHORT.replace("robot: panda\n", ""), ["robot"]),
    "an obstacle of nothing": (SHORT + "obstacles: [{xyz: [0, 0, 0]}]\n", ["box", "radius"]),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_not_used_or_not_known_is_an_error_that_names_it(name, tmp_path):
    text, words = BAD[name]
    with pytest.raises(ValueError) as error:
        load(text, tmp_path)
    for word in [*words, str(tmp_path / "mine.yaml")]:
        assert word in str(error.value)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"controller": "labvolt"}, ["LabVolt", "position", "pose"]),
        ({"controller": "supervised_drake", "plant": "torque_driven"}, ["kinematic", "servos"]),
        ({"robot": "planar4", "plant": "sim_iiwa", "initial_position": []}, ["7 joints"]),
    ],
)
def test_parts_that_do_not_fit_are_named(changes, words, tmp_path):
    scenario = load(SHORT, tmp_path).with_options(changes)
    with pytest.raises(ValueError) as error:
        fd.build_scenario(scenario)
    for word in words:
        assert word in str(error.value)
    with pytest.raises(ValueError, match="law is not used"):
        fd.simulate(
            fd.Scenario(
                robot="labvolt5250",
                controller="labvolt",
                target=Path(positions=[[0.3, 0.0, 0.2]]),
            ),
            law=fd.PseudoInverse(),
        )


def test_options_by_path(tmp_path):
    scenario = load(SHORT, tmp_path)
    other = scenario.but(target__duration=1.0, controller__config__fused=True)
    assert other.target.duration == 1.0 and other.controller.config.fused
    assert other.controller_config().task == "pose"
    assert scenario.target.duration == 3.0 and scenario.controller == "fuzzy"
    for path in ("target.speed", "speed", "target.duration.x"):
        with pytest.raises(ValueError, match="no option"):
            scenario.with_options({path: 1})
    with pytest.raises(ValueError, match="duration"):
        scenario.but(target__duration=-1.0)


@pytest.mark.parametrize("plant", ["kinematic", "torque_driven"])
def test_the_scene_graph_sees_the_robot_where_the_log_has_it(plant):
    """A ball 0.1 m beyond the tool: Drake's collision query in the run's own Diagram."""
    from pydrake.systems.analysis import Simulator

    scenario = Scenario(
        robot="panda",
        target=Path(positions=[[0.4, 0.1, 0.5]], hold=0.5),
        obstacles=[Obstacle([0.4, 0.1, 0.8], radius=0.1)],
        plant=plant,
        initial_position=READY,
    )
    built = fd.build_scenario(scenario)
    simulator = Simulator(built.diagram)
    root = simulator.get_mutable_context()
    built.set_start(root)
    simulator.AdvanceTo(0.5)
    log = fd.simulate(scenario)
    q = built.positions(root)
    np.testing.assert_allclose(q, log.q[-1], atol=1e-9)
    query = built.scene_graph.get_query_output_port().Eval(
        built.scene_graph.GetMyContextFromRoot(root)
    )
    frame = built.plant.GetBodyFrameIdOrThrow(built.plant.GetBodyByName("link7").index())
    own = MultibodyPlant(0.0)
    Parser(own).AddModelsFromString(fd.load_arm("panda").to_urdf(), "urdf")
    own.WeldFrames(own.world_frame(), own.GetFrameByName("base"))
    own.Finalize()
    context = own.CreateDefaultContext()
    own.SetPositions(context, q)
    expected = own.GetBodyByName("link7").EvalPoseInWorld(context)
    assert query.GetPoseInWorld(frame).IsNearlyEqualTo(expected, 1e-9)


def test_a_missing_robot_file_and_a_frame_that_is_not_there(tmp_path):
    target = Path(positions=[[0.4, 0.1, 0.5]])
    with pytest.raises(FileNotFoundError, match="gone.urdf"):
        Scenario(robot=Model("gone.urdf"), target=target)
    (tmp_path / "mine.urdf").write_text(fd.load_arm("panda").to_urdf())
    with pytest.raises(ValueError, match="hand"):
        Scenario(robot=Model(str(tmp_path / "mine.urdf"), frame="hand"), target=target)
