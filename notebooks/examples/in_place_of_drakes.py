"""An iiwa draws a circle by Drake's differential IK, or by ours in its place: one line changes."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import fikm_drake as fd

OURS = True
arm = fd.load_arm("iiwa14")
plant = fd.MakeDhArmPlant(arm)
home = np.array([0.0, 0.6, 0.0, -1.75, 0.0, 1.0, 0.0])
law = fd.FuzzyMapping.iterated()
config = fd.FuzzyIkConfig(task="pose", law=law, control_rate=100.0, error_smoothing=0.0)
if OURS:
    ik = fd.MakeFuzzyIkController(plant, config=config, ports="integrator")
else:
    tool, params = plant.GetFrameByName("tool"), DifferentialInverseKinematicsParameters(7, 7)
    ik = DifferentialInverseKinematicsIntegrator(plant, tool, 0.01, params)
builder = DiagramBuilder()
builder.AddSystem(ik)
builder.ExportInput(ik.GetInputPort("X_AE_desired"), "target")
builder.ExportOutput(ik.GetOutputPort("joint_positions"), "joints")
diagram = builder.Build()
context = (simulator := Simulator(diagram)).get_mutable_context()
ik.SetPositions(ik.GetMyMutableContextFromRoot(context), home)
X, errors = RigidTransform(arm.forward_kinematics(home)), []
for angle in np.linspace(0.0, 2.0 * np.pi, 200):
    point = X.translation() + 0.1 * np.array([np.sin(angle), np.cos(angle) - 1.0, 0.0])
    diagram.GetInputPort("target").FixValue(context, Value(RigidTransform(X.rotation(), point)))
    simulator.AdvanceTo(context.get_time() + 0.02)
    q = diagram.GetOutputPort("joints").Eval(context)
    errors.append(float(np.linalg.norm(arm.forward_kinematics(q)[:3, 3] - point)))
print(f"largest distance from the circle: {1e3 * max(errors):.1f} mm")
