"""Sliders in the browser move the target of a simulated arm: open the printed address."""

import sys

import numpy as np
from pydrake.geometry import StartMeshcat
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.visualization import AddDefaultVisualization, MeshcatPoseSliders

import fikm_drake as fd

seconds = float(sys.argv[1]) if len(sys.argv) > 1 else float("inf")
home = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0])
arm = fd.load_arm("iiwa14")
meshcat = StartMeshcat()
builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
fd.AddDhArm(plant, arm)
plant.Finalize()

law = fd.FuzzyMapping.iterated()
config = fd.FuzzyIkConfig(task="pose", control_rate=100.0, law=law, error_limit=0.2)
ik = fd.AddFuzzyIkTorqueController(builder, plant, config=config)
X = RigidTransform(arm.forward_kinematics(home))
sliders = builder.AddSystem(MeshcatPoseSliders(meshcat, initial_pose=X))
builder.Connect(sliders.get_output_port(), ik.GetInputPort("desired_pose"))
AddDefaultVisualization(builder, meshcat)
diagram = builder.Build()
simulator = Simulator(diagram)
context = simulator.get_mutable_context()
own = plant.GetMyMutableContextFromRoot(context)
plant.SetPositions(own, home)
if np.isinf(seconds):
    simulator.set_target_realtime_rate(1.0)
else:  # nobody there: move a slider ourselves
    meshcat.SetSliderValue("z", X.translation()[2] + 0.1)
simulator.AdvanceTo(seconds)
tool = plant.GetFrameByName("tool").CalcPoseInWorld(own)
moved = float(tool.translation()[2] - X.translation()[2])
print(f"the tool has moved up by {1e3 * moved:.1f} mm")
