"""Public arms: every chain equals Drake's kinematics; the benchmark's table, with our own arms."""

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable

import fikm_drake as fd
from fikm_drake.experiments.benchmarks import arms_benchmark
from fikm_drake.experiments.benchmarks.public_arms import ARMS, public_plant
from fikm_drake.kinematics.plant_frames import frame_by_name


@pytest.mark.filterwarnings("ignore:velocity limit 0")
@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_chains_of_public_models_equal_drakes(arm):
    """Skipped where the packages of the extra `peers` are not installed."""
    plant = public_plant(arm)
    if plant is None:
        pytest.skip(f"the package with {arm.path} is not installed")
    chain = fd.SerialChain.from_plant(plant, arm.frame, base=arm.base)
    context, rng = plant.CreateDefaultContext(), np.random.default_rng(0)
    tool = frame_by_name(plant, arm.frame)
    base = frame_by_name(plant, arm.base) if arm.base else plant.world_frame()
    for _ in range(5):
        q = rng.uniform(-3, 3, chain.num_joints)
        plant.SetPositions(context, chain.to_full(q, plant.GetPositions(context)))
        X = tool.CalcPose(context, base).GetAsMatrix4()
        J = plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, tool, np.zeros(3), base, base
        )[:, chain.velocity_indices]
        np.testing.assert_allclose(chain.forward_kinematics(q), X, rtol=0, atol=1e-12)
        np.testing.assert_allclose(chain.jacobian(q), J, rtol=0, atol=1e-12)


def test_the_table_with_our_own_arms(monkeypatch):
    monkeypatch.setattr(arms_benchmark, "ARMS", ())
    monkeypatch.setattr(arms_benchmark, "OURS", ("iiwa14",))
    monkeypatch.setattr(arms_benchmark, "find_spec", lambda name: None)
    shown = []
    table = arms_benchmark.table(2, shown.append)
    (row,) = table.rows
    assert (row.arm, row.joints, row.targets, row.pink) == ("iiwa14", 7, 2, None)
    assert row.position == row.position_reaching == row.position_searched == 2
    assert row.pose_searched == 2 >= row.pose_reaching and 0 <= row.pose_snopt <= 2
    assert row.false_converged == 0 and row.largest_speed <= 1.0 + 1e-9 and row.outside <= 0.0
    assert "iiwa14" in table and "false CONVERGED: 0" in table and shown[-1] == 1.0
