"""An arm on a torso that lifts and turns: the whole way to the tool moves, or the arm alone."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

TARGET = np.array([0.3, 0.8, 1.3])  # [m]; too high and too far aside for the arm alone

plant = MultibodyPlant(time_step=0.0)
torso, inertia = plant.AddModelInstance("torso"), SpatialInertia.SolidSphereWithMass(5.0, 0.1)
lift, turn = (plant.AddRigidBody(name, torso, inertia) for name in ("lift", "turn"))
plant.AddJoint(
    PrismaticJoint("up", plant.world_frame(), lift.body_frame(), [0, 0, 1], 0.0, 0.5)
).set_velocity_limits([-0.2], [0.2])
plant.AddJoint(
    RevoluteJoint("yaw", lift.body_frame(), turn.body_frame(), [0, 0, 1], -1.0, 1.0)
).set_velocity_limits([-1.0], [1.0])
(arm,) = Parser(plant).AddModelsFromString(fd.load_arm("panda").to_urdf(), "urdf")
X_TorsoArm = RigidTransform([0.1, -0.2, 0.5])
plant.WeldFrames(turn.body_frame(), plant.GetFrameByName("base", arm), X_TorsoArm)
plant.Finalize()


def reach(joints):
    """Distance to the target after 6 s [m], with joints of one's choice."""
    builder = DiagramBuilder()
    config = fd.FuzzyIkConfig(control_rate=100.0, limit_margin=0.05)
    ik = fd.AddFuzzyIkController(builder, plant, config=config, joints=joints)
    builder.ExportInput(ik.GetInputPort("desired_position"), "target")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("target").FixValue(context, TARGET)
    ready = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    own = ik.GetMyMutableContextFromRoot(context)
    ik.SetPositions(own, ready if joints is not None else [0.1, 0.0, *ready])
    simulator.AdvanceTo(6.0)
    return float(np.linalg.norm(ik.GetOutputPort("task_error").Eval(own)))


errors = {"with the torso": reach(None), "the arm alone": reach(arm)}
for name, error in errors.items():
    print(f"{name}: {1e3 * error:.1f} mm from the target")
