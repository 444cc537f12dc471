"""Scenarios along polylines: what is valid, how the target moves, files of the first version."""

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from fikm_drake import (
    DhArm,
    FuzzyIkConfig,
    FuzzyMapping,
    Scenario,
    TrackingScenario,
    load_arm,
    load_scenario,
)
from fikm_drake.resources import model_names

LINE = [[0.2, -0.6, 0.6], [0.7, -0.35, -0.15]]
CORNER = [[1.0, 0.0], [1.3, 0.0], [1.3, 0.0], [1.3, 0.1]]  # 0.4 m in all, one corner twice

GOOD = """\
arm: arm7
waypoints: [[0.2, -0.6, 0.6], [0.7, -0.35, -0.15]]
duration: 2.0
"""


def scenario(**changes):
    return TrackingScenario(**{"arm": "arm7", "waypoints": LINE, "duration": 2.0, **changes})


def round_trip(value):
    return yaml_load_typed(schema=Scenario, data=yaml_dump_typed(value))


@pytest.mark.parametrize("name", model_names("scenarios"))
def test_our_scenarios_load_and_round_trip(name):
    loaded = load_scenario(name)
    loaded.validate()
    assert round_trip(loaded) == loaded
    assert loaded.start().shape == (loaded.load_arm().num_joints,)


def test_table_6_scenarios_are_the_papers_line():
    for name, duration in (("table6_10s", 10), ("table6_5s", 5), ("table6_2s", 2)):
        loaded = load_scenario(name)
        assert (loaded.robot, loaded.target.duration, loaded.control_rate) == ("arm7", duration, 50)
        assert loaded.target.positions == LINE
        assert loaded.num_cycles == 50 * duration + 20


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"profile": "cubic", "hold": 1.5, "control_rate": 200.0},
        {"initial_position": [0.1] * 7},
        {"waypoints": [LINE[0]]},
        {"config": FuzzyIkConfig(error_limit=np.inf)},
        {"config": FuzzyIkConfig(law=FuzzyMapping("direct"), fused=True, error_limit=0.3)},
    ],
)
def test_round_trip_through_typed_yaml(changes):
    assert round_trip(scenario(**changes)) == scenario(**changes)


def test_inline_arm_round_trips_and_a_dh_arm_is_taken():
    arm = load_arm("planar2")
    for given in (arm, arm.table):
        made = TrackingScenario(arm=given, waypoints=CORNER, duration=1.0)
        again = round_trip(made)
        assert again == made
        assert isinstance(again.load_arm(), DhArm)
        assert again.load_arm().table == arm.table


def test_inline_arm_table_in_a_file(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        "arm: !DhTable\n  name: mine\n  joints: [{a: 0.0}, {a: 1.0}]\n  tool: {a: 0.5}\n"
        "waypoints: [[1.5, 0.0]]\nhold: 0.2\n"
    )
    arm = load_scenario(path).load_arm()
    np.testing.assert_allclose(arm.forward_kinematics([0.0, 0.0])[:3, 3], [1.5, 0, 0], atol=1e-15)


def test_numpy_arrays_are_taken():
    made = scenario(waypoints=np.array(LINE), initial_position=np.zeros(7))
    assert made == scenario(initial_position=[0.0] * 7)


@pytest.mark.parametrize("points, task", [(CORNER, "xy"), (LINE, "position")])
def test_size_of_waypoints_chooses_the_task_and_the_rate_goes_to_the_config(points, task):
    config = TrackingScenario("planar4", points, 1.0, control_rate=80.0).controller_config()
    assert (config.task, config.control_rate) == (task, 80.0)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"waypoints": []}, ["positions or poses"]),
        ({"waypoints": [0.1, 0.2]}, ["positions", "(2,)"]),
        ({"waypoints": [[0.1], [0.2]]}, ["positions", "(2, 1)"]),
        ({"waypoints": [[0.1] * 4]}, ["positions", "(1, 4)"]),
        ({"waypoints": [[0.1, np.nan]]}, ["positions", "nan"]),
        ({"waypoints": [[0.1, np.inf, 0.0]]}, ["positions", "inf"]),
        ({"waypoints": [[0.1, 0.2], [0.1, 0.2, 0.3]]}, ["waypoints"]),
        ({"waypoints": [["here", "there"]]}, ["waypoints", "here"]),
        ({"initial_position": [[0.0] * 7]}, ["7 finite numbers"]),
        ({"initial_position": "home"}, ["initial_position", "home"]),
        ({"duration": -1.0}, ["duration", "-1.0"]),
        ({"duration": np.inf}, ["duration", "inf"]),
        ({"hold": -0.1}, ["hold", "-0.1"]),
        ({"hold": np.nan}, ["hold", "nan"]),
        ({"control_rate": 0.0}, ["control_rate", "0.0"]),
        ({"control_rate": -50.0}, ["control_rate", "-50.0"]),
        ({"control_rate": np.nan}, ["control_rate", "nan"]),
        ({"control_rate": np.inf}, ["control_rate", "inf"]),
        ({"duration": 0.0, "hold": 0.0}, ["duration", "hold", "cycle"]),
        ({"profile": "quintic"}, ["'quintic'", "constant", "cubic"]),
        ({"initial_position": [0.0] * 6}, ["7"]),
        ({"initial_position": [0.0] * 6 + [np.nan]}, ["nan"]),
        ({"config": FuzzyIkConfig(following_time=0.0)}, ["following_time", "0.0"]),
        ({"config": FuzzyIkConfig(error_limit=0.0)}, ["error_limit", "0.0"]),
    ],
)
def test_bad_values_are_named(changes, words):
    with pytest.raises(ValueError) as error:
        scenario(**changes)
    for word in words:
        assert word in str(error.value)


def test_unknown_arm_lists_ours():
    with pytest.raises(FileNotFoundError, match=r"'arm8'.*arm7.*panda"):
        scenario(arm="arm8")


@pytest.mark.parametrize(
    "text, words",
    [
        ("", []),
        ("- 1\n", []),
        ("arm: [\n", []),
        ("{}\n", ["robot"]),
        (GOOD + "speed: 3\n", ["speed"]),
        (GOOD + "profile: quintic\n", ["quintic", "cubic"]),
        (GOOD.replace("2.0", "-2.0"), ["duration", "-2.0"]),
        (GOOD.replace("2.0", "soon"), ["soon"]),
        (GOOD + "config: {gain: 3}\n", ["gain"]),
        (GOOD.replace("arm: arm7\n", ""), []),
        (GOOD.replace("arm: arm7", "arm: !DhTable {name: a}"), ["joints"]),
    ],
)
def test_bad_files_name_the_file_and_the_value(text, words, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises((ValueError, FileNotFoundError)) as error:
        load_scenario(path)
    for word in words:
        assert word in str(error.value)
    if error.type is ValueError:
        assert str(path) in str(error.value)


def test_unknown_scenario_lists_ours():
    with pytest.raises(FileNotFoundError, match=r"scenario 'table7'.*table6_10s"):
        load_scenario("table7")


def sampled(made, count=401):
    """Times, targets and the target over time."""
    motion = made.target_motion()
    times = np.linspace(0, made.target.duration, count)
    return times, np.array([motion.position(t) for t in times]), motion


def travelled(points):
    """Length of the path so far; the corner lies on a sample or is cut by next to nothing."""
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def test_constant_profile_has_constant_speed_along_all_edges():
    made = TrackingScenario("planar2", CORNER, duration=2.0)
    times, points, motion = sampled(made)
    np.testing.assert_allclose(travelled(points), 0.2 * times, atol=1e-12)
    np.testing.assert_allclose(points[300], [1.3, 0.0], atol=1e-12)  # after 0.3 of 0.4 m
    np.testing.assert_allclose(points[[0, -1]], [CORNER[0], CORNER[-1]], atol=1e-14)
    np.testing.assert_allclose(motion.position(2.5), CORNER[-1], atol=1e-14)


def test_cubic_profile_starts_and_ends_at_rest():
    made = TrackingScenario("planar2", CORNER, duration=2.0, profile="cubic")
    times, points, motion = sampled(made)
    s = times / 2.0
    np.testing.assert_allclose(travelled(points), 0.4 * (3 * s**2 - 2 * s**3), atol=1e-3)
    speed = np.gradient(travelled(points), times)
    assert speed[0] < 2e-3 and speed[-1] < 2e-3
    np.testing.assert_allclose(speed.max(), 1.5 * 0.4 / 2.0, rtol=1e-2)
    np.testing.assert_allclose(motion.position(2.5), CORNER[-1], atol=1e-14)


@pytest.mark.parametrize("profile", ["constant", "cubic"])
@pytest.mark.parametrize("points, duration", [([[0.3, 1.0]], 1.0), (CORNER, 0.0)])
def test_one_waypoint_or_no_duration_is_a_step(points, duration, profile):
    made = TrackingScenario("planar2", points, duration, hold=0.5, profile=profile)
    for t in (0.0, 0.1, 1.0, 9.0):
        np.testing.assert_array_equal(made.target_motion().position(t), points[-1])


def test_repeated_single_waypoint_is_a_step():
    made = TrackingScenario("planar2", [[0.3, 1.0], [0.3, 1.0]], 1.0)
    np.testing.assert_array_equal(made.target_motion().position(0.5), [0.3, 1.0])


def test_start_is_the_default_position_or_the_given_one():
    panda = TrackingScenario("panda", [[0.5, 0.0, 0.4]])
    np.testing.assert_array_equal(panda.start(), load_arm("panda").default_position)
    given = scenario(initial_position=np.arange(7) / 10)
    np.testing.assert_array_equal(given.start(), np.arange(7) / 10)


def test_a_path_of_an_arm_is_relative_to_its_scenario(tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    arm = load_arm("planar2").table
    arm.name = "mine"
    (tmp_path / "arm.yaml").write_text(yaml_dump_typed(arm))
    scenario = tmp_path / "deep" / "scenario.yaml"
    scenario.write_text("arm: ../arm.yaml\nwaypoints: [[0.5, 0.5]]\n")
    monkeypatch.chdir("/")
    assert load_scenario(scenario).load_arm().name == "mine"
    scenario.write_text("arm: planar2\nwaypoints: [[0.5, 0.5]]\nwaypoints: [[0.1, 0.1]]\n")
    with pytest.raises(ValueError, match="'waypoints' stands twice"):
        load_scenario(scenario)
