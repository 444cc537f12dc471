"""A tool stays 10 cm above a body that drives by: the target is given in the body's frame."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

builder = DiagramBuilder()
plant = builder.AddSystem(MultibodyPlant(time_step=1e-3))
fd.AddDhArm(plant, fd.load_arm("iiwa14"))
inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.05)
cart = plant.AddRigidBody("cart", plant.AddModelInstance("conveyor"), inertia)
start = RigidTransform([0.5, -0.3, 0.3])
rail = plant.AddJoint(
    PrismaticJoint("rail", plant.world_frame(), cart.body_frame(), [0, 1, 0], -2.0, 2.0)
)
plant.Finalize()

law = fd.FuzzyMapping(iterations=4)
config = fd.FuzzyIkConfig(control_rate=100.0, law=law, error_smoothing=0.0, error_limit=0.2)
ik = fd.AddFuzzyIkTorqueController(builder, plant, config=config)  # moves the arm, not the rail
over = builder.AddSystem(fd.TargetInFrame("position", plant=plant, frame="cart"))
builder.Connect(plant.get_state_output_port(), over.GetInputPort("plant_state"))
builder.Connect(over.get_output_port(), ik.GetInputPort("desired_position"))
builder.ExportInput(over.GetInputPort("desired_position"), "above")
diagram = builder.Build()
simulator = Simulator(diagram)
context = simulator.get_mutable_context()
above = start.translation() + [0.0, 0.0, 0.1]
diagram.GetInputPort("above").FixValue(context, above)
own = plant.GetMyMutableContextFromRoot(context)
home = [0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0]
plant.SetPositions(own, plant.GetModelInstanceByName("iiwa14"), home)
rail.set_translation_rate(own, 0.15)  # [m/s]

errors = []
tool = plant.GetFrameByName("tool")
while context.get_time() < 4.0:
    simulator.AdvanceTo(context.get_time() + 0.1)
    X_CartTool = tool.CalcPose(own, cart.body_frame())
    errors.append(float(np.linalg.norm(X_CartTool.translation() - above)))
print(f"{1e3 * errors[-1]:.1f} mm behind a cart at 0.15 m/s; {1e3 * errors[0]:.0f} mm at the start")
