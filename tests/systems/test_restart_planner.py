"""The block that leaves dead points, against the law on the arm's own kinematics."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

import fikm_drake as fd
from fikm_drake import RestartState
from fikm_drake.control.restart_search import RestartSearch

PERIOD = 0.02
REST = {"position": np.zeros(2), "law_step": np.zeros(2)}
DEAD_POINT = REST | {"desired_position": np.array([1.0, 0.0])}
"""planar2, stretched, that should reach a point straight inward: no local law moves it."""


@pytest.fixture(scope="module")
def planar(plant_with):
    return plant_with("planar2")


@pytest.fixture
def driver(planar, drive):
    return drive(fd.RestartPlanner(planar, period=PERIOD, task="xy"))


def until(driver, state, inputs=DEAD_POINT):
    for _ in range(300):
        if driver.feed(**inputs)["restart_search"] == state:
            return driver
        driver.cycle(**inputs)
    raise AssertionError(f"{state.name} was not reached")


def test_it_is_the_law(driver):
    """The same memory as the law's with the DH arm's kinematics, cycle by cycle."""
    arm = fd.load_arm("planar2")

    def kinematics(desired, q):
        return desired - arm.forward_kinematics(q)[:2, 3], arm.jacobian(q)[3:5]

    law = RestartSearch(
        kinematics,
        2,
        lower=arm.lower,
        upper=arm.upper,
        tolerance=1e-3,
        pace=1.5 * PERIOD,
        turning=arm.chain.revolute,
        longest_error=2.0 * arm.chain.reach,
    )
    memory, q, target = law.initial_memory(), np.zeros(2), DEAD_POINT["desired_position"]
    seen = set()
    for _ in range(120):
        inputs = {"desired_position": target, "position": q, "law_step": 1e-3 * q}
        outputs = driver.feed(**inputs).read()
        np.testing.assert_allclose(outputs["joint_step"], law.step(memory, q, 1e-3 * q), atol=1e-9)
        assert outputs["restart_search"] == law.state(memory)
        seen.add(law.state(memory))
        driver.update()
        law.remember(memory, target, q, float(np.linalg.norm(kinematics(target, q)[0])))
        q = q + outputs["joint_step"]
    assert seen == {RestartState.NONE, RestartState.SEARCHING, RestartState.UNDERWAY}


def test_the_speed_is_that_of_the_fastest_joint(planar, drive):
    for speed, period in ((0.5, 0.02), (3.0, 0.005)):
        block = fd.RestartPlanner(planar, period=period, task="xy", speed=speed)
        step = until(drive(block), RestartState.UNDERWAY)["joint_step"]
        assert np.abs(step).max() == pytest.approx(speed * period)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("port", list(DEAD_POINT))
@pytest.mark.parametrize("state", [RestartState.SEARCHING, RestartState.UNDERWAY])
def test_a_lost_input_gives_zeros_and_ends_the_restart(driver, bad, port, state):
    until(driver, state)
    lost = DEAD_POINT | {port: np.array([0.1, bad])}
    outputs = driver.cycle(**lost)
    np.testing.assert_array_equal(outputs["joint_step"], 0.0)
    assert outputs["valid"] == 0
    assert driver["restart_search"] == RestartState.NONE
    np.testing.assert_array_equal(driver.state()[0], 0.0)
    until(driver, RestartState.UNDERWAY)  # and it begins again


def test_state_and_outputs_are_of_the_cycle_before(driver):
    """`restart_search` changes at the cycle's end, so a loop may be closed over it."""
    until(driver, RestartState.SEARCHING)
    before = driver["restart_search"].copy()
    driver.feed(**DEAD_POINT | {"desired_position": np.array([1.5, 0.0])})  # where the tool is
    np.testing.assert_array_equal(driver["restart_search"], before)
    driver.update()
    assert driver["restart_search"] == RestartState.NONE


def test_out_of_reach_it_is_stuck_and_the_law_leads(driver):
    far = DEAD_POINT | {"desired_position": np.array([2.5, 0.0]), "law_step": np.full(2, 1e-9)}
    until(driver, RestartState.STUCK, far)
    np.testing.assert_array_equal(driver.cycle(**far)["joint_step"], far["law_step"])


def test_in_a_diagram_of_one_s_own(planar):
    """TaskError, DifferentialIk, RestartPlanner and JointIntegrator, wired by hand."""
    builder = DiagramBuilder()
    target = builder.AddSystem(ConstantVectorSource([1.0, 0.0]))
    error = builder.AddSystem(fd.TaskError(planar, task="xy"))
    ik = builder.AddSystem(fd.DifferentialIk(planar, task="xy"))
    planner = builder.AddSystem(fd.RestartPlanner(planar, period=PERIOD, task="xy"))
    arm = fd.load_arm("planar2")
    joints = builder.AddSystem(
        fd.JointIntegrator(arm.lower, arm.upper, period=PERIOD, initial_position=[0.0, 0.0])
    )
    for block in (error, planner):
        builder.Connect(target.get_output_port(), block.GetInputPort("desired_position"))
    builder.Connect(error.GetOutputPort("task_error"), ik.GetInputPort("task_error"))
    builder.Connect(ik.GetOutputPort("joint_step"), planner.GetInputPort("law_step"))
    builder.Connect(planner.GetOutputPort("joint_step"), joints.GetInputPort("joint_step"))
    for block in (error, ik, planner):
        builder.Connect(joints.GetOutputPort("position"), block.GetInputPort("position"))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(4.0)
    context = error.GetMyContextFromRoot(simulator.get_context())
    assert np.linalg.norm(error.GetOutputPort("task_error").Eval(context)) < 1e-6


def test_poses(plant_with, drive):
    """A pose that is the tool's own is reached: nothing to do. A NaN in it is seen."""
    arm = fd.load_arm("iiwa14")
    driver = drive(fd.RestartPlanner(plant_with("iiwa14"), period=PERIOD, task="pose"))
    q = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0])
    T = arm.forward_kinematics(q)
    pose = RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])
    for _ in range(60):
        outputs = driver.cycle(desired_pose=Value(pose), position=q, law_step=np.zeros(7))
        assert outputs["restart_search"] == RestartState.NONE and outputs["valid"] == 1
    lost = RigidTransform([np.nan, 0.0, 0.5])
    outputs = driver.cycle(desired_pose=Value(lost), position=q, law_step=np.ones(7))
    assert outputs["valid"] == 0 and not outputs["joint_step"].any()
    turned = RigidTransform(RotationMatrix.MakeXRotation(0.3) @ pose.rotation(), pose.translation())
    for _ in range(30):
        driver.cycle(desired_pose=Value(turned), position=q, law_step=np.zeros(7))
    assert driver["restart_search"] != RestartState.NONE
