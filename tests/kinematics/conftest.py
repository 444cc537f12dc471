"""Random arms, and the same arms in a MultibodyPlant."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from fikm_drake.kinematics.add_dh_arm import AddDhArm
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform

RIGHT = np.pi / 2


def _angle(rng):
    """Any angle, a right one, or one so near a right one that roll-pitch-yaw nearly locks."""
    near = rng.choice([-RIGHT, RIGHT]) + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-16, -3)
    return float(rng.choice([rng.uniform(-np.pi, np.pi), 0.0, RIGHT, -RIGHT, np.pi, near, near]))


def _row(rng):
    return {
        "alpha": _angle(rng),
        "a": float(rng.choice([0.0, rng.uniform(-1, 1)])),
        "d": float(rng.choice([0.0, rng.uniform(-1, 1)])),
        "theta": _angle(rng),
    }


@pytest.fixture
def random_arm():
    """Makes a random arm: random_arm(rng, convention=…, limited=…)."""

    def make(rng, *, convention=None, limited=False):
        joints = []
        for _ in range(rng.integers(1, 8)):
            joint = DhJoint(
                **_row(rng), type=str(rng.choice(["revolute", "prismatic"], p=[0.7, 0.3]))
            )
            if limited or rng.random() < 0.5:
                joint.lower, joint.upper = np.sort(rng.uniform(-2, 2, 2)).tolist()
            joints.append(joint)
        convention = convention or str(rng.choice(["craig", "standard"]))
        return DhArm(DhTable("random", convention, joints, DhTransform(**_row(rng))))

    return make


class PlantTwin:
    """An arm in a MultibodyPlant of its own."""

    def __init__(self, arm):
        self.plant = MultibodyPlant(0.0)
        self.instance = AddDhArm(self.plant, arm)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.tool = self.plant.GetFrameByName("tool")

    def pose(self, q):
        self.plant.SetPositions(self.context, q)
        return self.tool.CalcPoseInWorld(self.context).GetAsMatrix4()

    def jacobian(self, q):
        self.plant.SetPositions(self.context, q)
        world = self.plant.world_frame()
        return self.plant.CalcJacobianSpatialVelocity(
            self.context, JacobianWrtVariable.kV, self.tool, np.zeros(3), world, world
        )


@pytest.fixture
def plant_twin():
    """Makes the PlantTwin of an arm."""
    return PlantTwin
