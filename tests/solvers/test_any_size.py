"""Arms of all sizes are alike: lengths count as fractions of the reach."""

import numpy as np
import pytest

import fikm_drake as fd


def arm_of_size(name, size):
    table = fd.load_arm(name).table
    for row in (*table.joints, table.tool):
        row.a *= size
        row.d *= size
    return fd.DhArm(table)


def poses_of(arm, count):
    q = np.random.default_rng(4).uniform(arm.lower, arm.upper, (count, arm.num_joints))
    return arm.forward_kinematics(q)


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("name", ["hassantabar4r", "iiwa14"])
def test_self_motions_do_not_depend_on_the_size(name, size):
    """The same components at every pose, with the same ends, from a micrometre to a thousand km."""
    arm, other = fd.load_arm(name), arm_of_size(name, size)
    for pose, same in zip(poses_of(arm, 3), poses_of(other, 3)):
        motion = fd.trace_self_motion(arm, pose, "pose")
        found = fd.trace_self_motion(other, same, "pose")
        assert found.status == motion.status
        assert len(found.components) == len(motion.components)
        for joint in range(arm.num_joints):
            np.testing.assert_allclose(
                [(part.lower, part.upper) for part in found.intervals(joint)],
                [(part.lower, part.upper) for part in motion.intervals(joint)],
                atol=1e-6,
            )


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e3, 1e6])
def test_redundancy_does_not_depend_on_the_size(size):
    """The middle of the same bounds, by Newton's method; the tool is there to rounding."""
    arm, other = fd.load_arm("hassantabar4r"), arm_of_size("hassantabar4r", size)
    expected = fd.RedundancyResolver(arm, task="pose", joint=1).resolve(poses_of(arm, 10))
    found = fd.RedundancyResolver(other, task="pose", joint=1).resolve(poses_of(other, 10))
    assert found.success.all() and expected.success.all()
    np.testing.assert_allclose(found.lower, expected.lower, atol=1e-6)
    np.testing.assert_allclose(found.upper, expected.upper, atol=1e-6)
    assert found.position_error.max() < 1e-9 * size
