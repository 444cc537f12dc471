"""The LabVolt 5250 picks a box from above and holds it by contact; a log and its servos' counts are kept."""

import sys
from pathlib import Path

import numpy as np
from pydrake.geometry import Box, DefaultProximityProperties, HalfSpace, SceneGraphConfig
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PdControllerGains, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

import fikm_drake as fd

FROM, TO, SIZE, ROUGH = [0.42, -0.12], [0.36, 0.20], [0.03, 0.03, 0.06], CoulombFriction(1.0, 0.9)
PLAN = [(*FROM, 0.15, 0.03), (*FROM, 0.04, 0.03), (*FROM, 0.04, 0.0), (*FROM, 0.15, 0.0),
        (*TO, 0.15, 0.0), (*TO, 0.042, 0.0), (*TO, 0.042, 0.03), (*TO, 0.15, 0.03)]  # fmt: skip
builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=4e-3)
soft = DefaultProximityProperties(compliance_type="compliant", slab_thickness=0.1)
scene_graph.set_config(SceneGraphConfig(default_proximity_properties=soft))
(arm,) = Parser(plant).AddModelsFromString(fd.labvolt.gripper_urdf(), "urdf")
plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base", arm))
plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "table", ROUGH)
mass = SpatialInertia.SolidBoxWithMass(0.1, *SIZE)
box = plant.AddRigidBody("box", plant.AddModelInstance("box"), mass)
plant.RegisterCollisionGeometry(box, RigidTransform(), Box(*SIZE), "box", ROUGH)
for index in plant.GetJointActuatorIndices():  # servos
    plant.get_joint_actuator(index).set_controller_gains(PdControllerGains(p=2000.0, d=60.0))
plant.Finalize()
times, knots = 1.2 * np.arange(len(PLAN)), np.transpose(PLAN)
ways = [PiecewisePolynomial.FirstOrderHold(times, rows) for rows in (knots[:3], knots[3:])]
target, fingers = (builder.AddSystem(TrajectorySource(way)) for way in ways)
ik = builder.AddSystem(fd.LabVoltIk(period=0.02, approach=True))
down = builder.AddSystem(ConstantVectorSource([-np.pi / 2]))
roll, speeds = (builder.AddSystem(ConstantVectorSource([0.0] * n)) for n in (1, 7))
wish = builder.AddSystem(Multiplexer([4, 1, 1, 1, 7]))
builder.Connect(target.get_output_port(), ik.GetInputPort("desired_position"))
builder.Connect(down.get_output_port(), ik.GetInputPort("approach"))
for k, system in enumerate([ik, roll, fingers, fingers, speeds]):
    builder.Connect(system.get_output_port(0), wish.get_input_port(k))
builder.Connect(wish.get_output_port(), plant.get_desired_state_input_port(arm))
of_box = plant.get_state_output_port(box.model_instance())
recorder = fd.record(builder, {"box": of_box, "angles": ik.GetOutputPort("angles")}, period=0.02)
simulator = Simulator(builder.Build())
own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
start = fd.labvolt.solve(PLAN[0][:3], approach=-np.pi / 2).joints[0]
plant.SetPositions(own, [*start, 0, 0.03, 0.03, 1, 0, 0, 0, *FROM, SIZE[2] / 2])
simulator.AdvanceTo(times[-1] + 0.3)
log = recorder.log()
if len(sys.argv) > 1:  # a folder: the log, and counts for the arm's own controller
    log.to_csv(Path(sys.argv[1]) / "run.csv")
    fd.labvolt.save_servo_counts(Path(sys.argv[1]) / "counts.csv", log.time, log["angles"])
error = float(np.linalg.norm(log["box"][-1, 4:7] - [*TO, SIZE[2] / 2]))
print(f"the box lies {1e3 * error:.1f} mm from its place; it was {log['box'][:, 6].max():.2f} m up")
