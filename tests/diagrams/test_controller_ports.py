"""The controller's ports and configuration, as a Diagram and as one block."""

import re
from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

OUTPUTS = {
    "commanded_position": 7,
    "commanded_velocity": 7,
    "joint_step": 7,
    "task_error": 3,
    "gain": 1,
    "oscillating": 1,
    "oscillating_joint": 1,
    "status": 1,
}
Q0 = np.array([0.2, -0.3, 0.4, 0.5, -0.2, 0.3, 0.1])


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("task", ["position", "xz", "y"])
def test_ports(plant, ports, fused, measured, task):
    config = fd.FuzzyIkConfig(
        fused=fused, measured_position=measured, task=task, restart_search=measured
    )
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=config)
    m = {"position": 3, "xz": 2, "y": 1}[task]
    inputs = {"desired_position": m, "estimated_position": 7}
    assert ports(controller) == (inputs, OUTPUTS | {"task_error": m})
    assert controller.get_name() == "fuzzy_ik_controller"
    assert isinstance(controller, fd.FusedFuzzyIk if fused else fd.FuzzyIkController)


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("restart_search", [False, True])
def test_direct_feedthrough_is_that_of_the_blocks(plant, fused, measured, restart_search):
    """The command comes from the state, so any loop may be closed around the controller."""
    config = fd.FuzzyIkConfig(
        fused=fused, measured_position=measured, restart_search=restart_search
    )
    controller = fd.MakeFuzzyIkController(plant, config=config)
    for i in range(controller.num_input_ports()):
        through = {name for j, name in enumerate(OUTPUTS) if controller.HasDirectFeedthrough(i, j)}
        late = controller.get_input_port(i).get_name() == "estimated_position" and not measured
        if late and not fused:  # it only starts the command, and the status looks at it
            assert through == {"status"}
        else:
            assert through == {"joint_step", "task_error", "gain", "status"}


@pytest.mark.parametrize(
    "config",
    [
        fd.FuzzyIkConfig(),
        fd.FuzzyIkConfig(
            law=fd.FuzzyMapping("direct"), frame="arm7::tool", task="xy", control_rate=1000.0
        ),
        fd.FuzzyIkConfig(fused=True, measured_position=True, error_limit=np.inf, tolerance=1e-4),
        fd.FuzzyIkConfig(gain_smoothing=0.0, error_smoothing=0.1, law=fd.DampedLeastSquares(0.2)),
        fd.FuzzyIkConfig(
            restart_search=True,
            restart_speed=3.0,
            singularity_nudge=0.0,
            limit_margin=0.0,
            posture_rate=2.0,
            nominal_position=[0.1] * 7,
            velocity_limits=[1.5],
            acceleration_limits=[9.0],
            jerk_limits=[900.0],
            max_joint_step=np.inf,
            supervisor=fd.GainSupervisorConfig(
                calming=0.9,
                recovery=1.5,
                calm_damping=0.0,
                slow_window=80,
                slow_sign_changes=9,
            ),
        ),
        fd.FuzzyIkConfig(
            supervisor=fd.GainSupervisorConfig(
                12, [0.1, 0.5, 1.0], [1.0, 2.0, 3.0], [0.0, 0.1, 0.2], 3, 1e-9, 0.5
            )
        ),
    ],
)
def test_config_survives_yaml(config, plant):
    text = yaml_dump_typed(config)
    assert yaml_load_typed(schema=fd.FuzzyIkConfig, data=text) == config
    # All fields are written, so that a file tells what there is to set.
    assert re.findall(r"^(\w+):", text, re.M) == list(vars(config))
    fd.MakeFuzzyIkController(plant, config=config)


def test_partial_yaml_keeps_the_defaults():
    data = "{task: xy, error_limit: .inf, supervisor: {window: 12, gains: [1, 2, 3]}}"
    expected = fd.FuzzyIkConfig(
        task="xy",
        error_limit=np.inf,
        supervisor=fd.GainSupervisorConfig(window=12, gains=[1.0, 2.0, 3.0]),
    )
    assert yaml_load_typed(schema=fd.FuzzyIkConfig, data=data) == expected
    base = fd.FuzzyIkConfig(control_rate=100.0, supervisor=fd.GainSupervisorConfig(window=7))
    loaded = yaml_load_typed(schema=fd.FuzzyIkConfig, data="{task: y}", defaults=base)
    assert loaded == replace(base, task="y")


def test_the_config_of_the_paper():
    """Without what calms and bounds ours; what is asked for besides is kept."""
    config = fd.FuzzyIkConfig(fused=True, error_limit=0.3).as_in_paper()
    assert (config.max_joint_step, config.limit_margin, config.error_limit) == (np.inf, 0.0, np.inf)
    assert config.supervisor == fd.GainSupervisorConfig(calming=1.0)
    assert config.fused and not config.restart_search and config.singularity_nudge == 0.0
    own = fd.GainSupervisorConfig(window=7)
    assert fd.FuzzyIkConfig(supervisor=own).as_in_paper().supervisor == replace(own, calming=1.0)


def test_two_configs_share_nothing():
    one, other = fd.FuzzyIkConfig(), fd.FuzzyIkConfig()
    one.supervisor.gains[0] = 9.0
    one.nominal_position.append(1.0)
    assert other.supervisor.gains[0] == 1.0 and not other.nominal_position


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law": "pinv"}, ["law", "pinv", "PseudoInverse", "FuzzyMapping"]),
        ({"task": "posture"}, ["task", "posture", "position", "xy", "pose"]),
        ({"frame": "hand"}, ["frame", "hand", "tool", "link7"]),
        ({"frame": "hand", "law": fd.FuzzyMapping("direct")}, ["frame", "hand", "tool", "link7"]),
        ({"control_rate": 0.0}, ["control_rate", "0.0", "positive"]),
        ({"control_rate": -50.0}, ["control_rate", "-50.0", "positive"]),
        ({"control_rate": np.nan}, ["control_rate", "nan"]),
        ({"control_rate": np.inf}, ["control_rate", "inf"]),
        ({"error_limit": 0.0}, ["error_limit", "0.0", "positive"]),
        ({"error_limit": np.nan}, ["error_limit", "nan"]),
        ({"tolerance": -1.0}, ["tolerance", "-1.0", "positive"]),
        ({"gain_smoothing": 1.0}, ["gain_smoothing", "1.0", "[0, 1)"]),
        ({"error_smoothing": -0.1}, ["error_smoothing", "-0.1", "[0, 1)"]),
        ({"error_smoothing": np.nan}, ["error_smoothing", "nan"]),
        ({"max_joint_step": 0.0}, ["max_joint_step", "0.0", "positive"]),
        ({"max_joint_step": np.nan}, ["max_joint_step", "nan"]),
        ({"singularity_nudge": -0.1}, ["singularity_nudge", "-0.1", "negative"]),
        ({"singularity_nudge": np.nan}, ["singularity_nudge", "nan", "finite"]),
        ({"limit_margin": -0.1}, ["limit_margin", "-0.1", "negative"]),
        ({"limit_margin": np.inf}, ["limit_margin", "inf", "finite"]),
        ({"limit_margin": np.nan}, ["limit_margin", "nan"]),
        ({"posture_rate": -1.0}, ["posture_rate", "-1.0"]),
        ({"posture_rate": 50.5}, ["posture_rate", "50.5", "control_rate = 50"]),
        ({"posture_rate": np.nan}, ["posture_rate", "nan"]),
        (
            {"posture_rate": 1.0, "nominal_position": [0.1, 0.2]},
            ["nominal_position", "[0.1, 0.2]", "7"],
        ),
        (
            {"posture_rate": 1.0, "nominal_position": [np.nan] * 7},
            ["nominal_position", "nan", "finite"],
        ),
        ({"velocity_limits": [0.0]}, ["velocity_limits", "0.0", "positive"]),
        ({"velocity_limits": [np.nan]}, ["velocity_limits", "nan"]),
        ({"acceleration_limits": [-1.0]}, ["acceleration_limits", "-1.0", "positive"]),
        ({"acceleration_limits": [np.nan]}, ["acceleration_limits", "nan"]),
        ({"restart_search": True, "restart_speed": 0.0}, ["restart_speed", "0.0", "positive"]),
        ({"restart_speed": np.nan}, ["restart_speed", "nan"]),
        ({"supervisor": fd.GainSupervisorConfig(window=0)}, ["window", "0"]),
        ({"supervisor": fd.GainSupervisorConfig(calming=0.0)}, ["calming", "0.0", "(0, 1]"]),
        ({"supervisor": fd.GainSupervisorConfig(recovery=1.0)}, ["recovery", "1.0", "above 1"]),
        (
            {"supervisor": fd.GainSupervisorConfig(error_breakpoints=[0.0, 0.0, 1.0])},
            ["error_breakpoints", "0.0, 0.0"],
        ),
    ],
)
def test_errors_name_the_bad_value_and_the_valid_ones(plant, fused, changes, words):
    with pytest.raises(ValueError) as error:
        fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(fused=fused, **changes))
    for word in words:
        assert word in str(error.value)


def test_set_positions(plant, fused):
    builder = DiagramBuilder()
    controller = fd.AddFuzzyIkController(builder, plant, config=fd.FuzzyIkConfig(fused=fused))
    builder.ExportInput(controller.GetInputPort("desired_position"))
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    own = controller.GetMyMutableContextFromRoot(root)
    controller.SetPositions(own, Q0)
    np.testing.assert_array_equal(controller.GetOutputPort("commanded_position").Eval(own), Q0)
    for wrong in (Q0[:6], np.append(Q0, 0.0), np.full(7, np.nan)):
        with pytest.raises(ValueError, match="joint position"):
            controller.SetPositions(own, wrong)
    with pytest.raises(RuntimeError):
        controller.SetPositions(root, Q0)
    np.testing.assert_array_equal(controller.GetOutputPort("commanded_position").Eval(own), Q0)


def test_positions_outside_the_limits_are_refused(plant_with, fused):
    plant = plant_with("panda")
    controller = fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(fused=fused))
    with pytest.raises(ValueError, match=r"joint position\[3\]"):
        controller.SetPositions(controller.CreateDefaultContext(), np.zeros(7))


def test_the_default_start_is_the_plant_s(plant_with, fused):
    """Inside the limits, whatever the plant's defaults are."""
    plant = plant_with("panda")
    controller = fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(fused=fused))
    start = controller.GetOutputPort("commanded_position").Eval(controller.CreateDefaultContext())
    np.testing.assert_array_equal(start, fd.load_arm("panda").default_position)
