"""Two torque-driven arms in one plant, each with a controller of its own."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

HOME = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0])
TARGETS = {"left": [0.5, 0.3, 0.5], "right": [0.4, -0.3, 0.6]}  # [m], in the world

builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
for name, y in (("left", 0.5), ("right", -0.5)):
    text = fd.load_arm("iiwa14").to_urdf().replace('name="iiwa14"', f'name="{name}"')
    (arm,) = Parser(plant).AddModelsFromString(text, "urdf")
    base = plant.GetFrameByName("base", arm)
    plant.WeldFrames(plant.world_frame(), base, RigidTransform([0.0, y, 0.0]))
plant.Finalize()

for name in TARGETS:
    config = fd.FuzzyIkConfig(frame=f"{name}::tool", control_rate=100.0, error_limit=0.2)
    ik = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
    builder.ExportInput(ik.GetInputPort("desired_position"), name)
diagram = builder.Build()
simulator = Simulator(diagram)
context = simulator.get_mutable_context()
own = plant.GetMyMutableContextFromRoot(context)
for name, target in TARGETS.items():
    diagram.GetInputPort(name).FixValue(context, target)
    plant.SetPositions(own, plant.GetModelInstanceByName(name), HOME)
simulator.AdvanceTo(2.0)

errors = {}
for name, target in TARGETS.items():
    tool = plant.GetFrameByName("tool", plant.GetModelInstanceByName(name))
    errors[name] = float(np.linalg.norm(tool.CalcPoseInWorld(own).translation() - target))
    print(f"{name}: {1e3 * errors[name]:.2f} mm from its target")
