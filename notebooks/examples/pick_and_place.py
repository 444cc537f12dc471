"""An arm with a gripper moves a brick on a table: by torques, or through Drake's SimIiwaDriver."""

import sys
from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Box, DefaultProximityProperties, HalfSpace, SceneGraphConfig
from pydrake.manipulation import IiwaDriver, SimIiwaDriver
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

HOME, DOWN = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0]), RollPitchYaw(np.pi, 0, 0)
FROM, TO, ROUGH = [0.55, -0.15], [0.5, 0.25], CoulombFriction(1.0, 1.0)
PLAN = [(FROM, 0.3, 0.04), (FROM, 0.15, 0.04), (FROM, 0.15, 0.0), (FROM, 0.35, 0.0),
        (TO, 0.35, 0.0), (TO, 0.152, 0.0), (TO, 0.152, 0.04), (TO, 0.3, 0.04)]  # fmt: skip
driver = sys.argv[1] if len(sys.argv) > 1 else "torque"
builder, model = DiagramBuilder(), fd.load_arm("iiwa14")
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
soft = DefaultProximityProperties(compliance_type="compliant", slab_thickness=0.1)
scene_graph.set_config(SceneGraphConfig(default_proximity_properties=soft))
arm = fd.AddDhArm(plant, model, capsules=False)
(hand,) = Parser(plant).AddModels(str(Path(__file__).parent / "gripper.urdf"))
plant.WeldFrames(plant.GetFrameByName("tool"), plant.GetFrameByName("palm"))
plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "table", ROUGH)
mass = SpatialInertia.SolidBoxWithMass(0.2, 0.04, 0.04, 0.08)
brick = plant.AddRigidBody("brick", plant.AddModelInstance("brick"), mass)
plant.RegisterCollisionGeometry(brick, RigidTransform(), Box(0.04, 0.04, 0.08), "brick", ROUGH)
plant.Finalize()
law = fd.FuzzyMapping.iterated()
config = fd.FuzzyIkConfig(task="pose", control_rate=100.0, law=law, error_limit=0.1, fused=True)
if driver == "torque":
    ik = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
else:
    ik = fd.AddFuzzyIkController(builder, plant, config=config)
    mode, own_model = IiwaDriver(control_mode="position_only"), fd.MakeDhArmPlant(model)
    iiwa = SimIiwaDriver.AddToBuilder(builder, plant, arm, mode, own_model)
    builder.Connect(ik.GetOutputPort("commanded_position"), iiwa.GetInputPort("position"))
    builder.Connect(iiwa.GetOutputPort("position_measured"), ik.GetInputPort("estimated_position"))
builder.ExportInput(ik.GetInputPort("desired_pose"), "target")
builder.ExportInput(plant.get_desired_state_input_port(hand), "fingers")
context = (simulator := Simulator(diagram := builder.Build())).get_mutable_context()
own = plant.GetMyMutableContextFromRoot(context)
plant.SetPositions(own, [*HOME, 0.04, 0.04, 1.0, 0.0, 0.0, 0.0, *FROM, 0.04])
last = [*FROM, 0.3]
for place, height, fingers in PLAN:
    diagram.GetInputPort("fingers").FixValue(context, [fingers, fingers, 0.0, 0.0])
    for point in np.linspace(last, [*place, height], 160):  # a straight line, in 1.6 s
        diagram.GetInputPort("target").FixValue(context, Value(RigidTransform(DOWN, point)))
        simulator.AdvanceTo(context.get_time() + 0.01)
    last = [*place, height]
error = float(np.linalg.norm(plant.GetFreeBodyPose(own, brick).translation() - [*TO, 0.04]))
print(f"{driver}: the brick lies {1e3 * error:.0f} mm from its place")
