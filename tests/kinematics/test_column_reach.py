"""Bounds of the lengths of a task Jacobian's columns."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.kinematics.column_reach import column_reach
from fikm_drake.kinematics.jacobian_range import jacobian_range
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import TASKS, Task


def columns(arm, task, q):
    """Lengths of the columns (N,n) at postures (N,n)."""
    J = arm.jacobian(q)
    J[:, :3] *= task.characteristic_length
    return np.linalg.norm(J[:, task.rows], axis=1)


def test_links_of_kim_and_lee():
    """Section 3: 0.5, 0.5 and 0.4 m; what lies beyond each joint."""
    arm = fd.load_arm("kim_lee3r")
    for task in ("xy", "position"):
        reach = column_reach(arm.jacobian_range(), Task(task))
        np.testing.assert_allclose(reach, [1.4, 0.9, 0.4], rtol=1e-12)


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("name", ["kim_lee3r", "arm7", "panda", "puma560"])
def test_our_arms_never_exceed_it(name, task):
    arm, task = fd.load_arm(name), Task(task)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, arm.num_joints))
    reach = column_reach(arm.jacobian_range(), task)
    assert (columns(arm, task, q) <= reach * (1 + 1e-9) + 1e-9).all()


@pytest.mark.parametrize("task", ["position", "yz", "pose"])
def test_random_arms_never_exceed_it(random_arm, plant_twin, task):
    rng, task = np.random.default_rng(3), Task(task)
    for _ in range(25):
        arm = random_arm(rng, limited=True)
        q = rng.uniform(arm.lower, arm.upper, (200, arm.num_joints))
        for bounds in (
            arm.jacobian_range(),
            jacobian_range(SerialChain.from_plant(plant_twin(arm).plant, "tool")),
        ):
            reach = column_reach(bounds, task)
            assert (columns(arm, task, q) <= reach * (1 + 1e-9) + 1e-9).all()


def test_a_tilted_prismatic_joint_moves_the_tool_by_one():
    slide = fd.DhJoint(type="prismatic", alpha=np.pi / 4, lower=0.0, upper=1.0)
    arm = fd.DhArm(fd.DhTable("slide", joints=[slide]))
    assert column_reach(arm.jacobian_range(), Task("position")) == pytest.approx([1.0])
