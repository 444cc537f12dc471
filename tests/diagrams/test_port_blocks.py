"""Every public system's docstring begins with its real ports and describes each of them."""

import inspect
import re

import numpy as np
import pytest
import yaml
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import BasicVector, LeafSystem, System

import fikm_drake as fd
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant

PERIOD = 0.02
ELSEWHERE = {"DrakesPorts", "FusedFuzzyIk", "FuzzyIkTorqueController"}
"""Refer to `FuzzyIkController` for ports of the same names."""


class Still(LeafSystem):
    """A differential IK that stays where it is."""

    def __init__(self, size):
        super().__init__()
        self.DeclareVectorInputPort("position", size)
        self.DeclareVectorInputPort("target", 3)
        self.DeclareVectorOutputPort("commanded_velocity", BasicVector(size), lambda *_: None)


def workplane_ik():
    rules = fd.IntegerFuzzyIk()
    return fd.IntegerFuzzyIkSystem(rules, fd.load_workplane("tojo4dof"), period=PERIOD)


def clearance_filter():
    """With everything it can have: limits, and a ball that floats in its world."""

    def populate(robot):
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        robot.plant().AddRigidBody("ball", robot.plant().AddModelInstance("ball"), inertia)

    arm = fd.load_arm("arm7")
    checker = fd.MakeCollisionChecker(arm, populate, robots=["arm7"])
    limits = JointLimits(arm.lower, arm.upper, period=PERIOD)
    return fd.ClearanceFilter(fd.Clearance(checker, period=PERIOD), limits=limits)


ALL = fd.FuzzyIkConfig(measured_position=True)
JERK_LIMIT = fd.JerkLimit(
    900.0, period=PERIOD, velocity_limits=2.0, acceleration_limits=9.0, num_joints=7
)
LIMITS = fd.JointLimits(np.full(7, -3.0), np.full(7, 3.0), period=PERIOD)


def drakes_ports(plant):
    controller = fd.MakeFuzzyIkController(plant, config=fd.FuzzyIkConfig(task="pose"))
    return fd.DrakesPorts(controller, fd.PlantArm(plant), ports="integrator")


MAKERS = {
    "ChainInverseDynamics": lambda p: fd.ChainInverseDynamics(
        p, fd.SerialChain.from_plant(p, "tool"), bandwidth=50.0
    ),
    "DrakesPorts": drakes_ports,
    "TargetInFrame": lambda p: fd.TargetInFrame(),
    "ClearanceFilter": lambda p: clearance_filter(),
    "NullSpaceFilter": lambda p: fd.NullSpaceFilter(fd.PositionTask(fd.PlantArm(p)), period=PERIOD),
    "NullSpaceMotion": lambda p: fd.NullSpaceMotion(7, lambda q: -q),
    "CommandSmoother": lambda p: fd.CommandSmoother(
        JERK_LIMIT, period=PERIOD, initial_position=np.zeros(7)
    ),
    "CommandSupervisor": lambda p: fd.CommandSupervisor(7, period=PERIOD),
    "RestartPlanner": lambda p: fd.RestartPlanner(p, period=PERIOD),
    "FusedFuzzyIk": lambda p: fd.FusedFuzzyIk(p, law=fd.FuzzyMapping(), config=ALL),
    "DifferentialIk": lambda p: fd.DifferentialIk(
        p, law=fd.FuzzyMapping(iterations=2), guarded=True, damped=True, limits=LIMITS, yields=True
    ),
    "FuzzyIkController": lambda p: fd.FuzzyIkController(p, law=fd.FuzzyMapping(), config=ALL),
    "FuzzyIkTorqueController": lambda p: fd.FuzzyIkTorqueController(p),
    "GainSupervisor": lambda p: fd.GainSupervisor(3, 7, period=PERIOD),
    "GuardBlock": lambda p: fd.GuardBlock(LIMITS),
    "IntegerFuzzyIkSystem": lambda p: workplane_ik(),
    "JointIntegrator": lambda p: fd.JointIntegrator(
        [-1.0], [1.0], period=PERIOD, initial_position=[0.0]
    ),
    "JointReference": lambda p: fd.JointReference(
        1, period=PERIOD, time_step=1e-3, velocity_limits=[1.0], acceleration_limits=1.0
    ),
    "JointSensor": lambda p: fd.JointSensor(7, period=PERIOD),
    "LabVoltIk": lambda p: fd.LabVoltIk(period=PERIOD, approach=True),
    "LastFinite": lambda p: fd.LastFinite(3, period=PERIOD),
    "LowPassFilter": lambda p: fd.LowPassFilter(3, period=PERIOD),
    "RedundancyIk": lambda p: fd.RedundancyIk(
        fd.RedundancyResolver(fd.load_arm("hassantabar3r")), period=PERIOD
    ),
    "SlowFeedback": lambda p: fd.SlowFeedback(7, period=PERIOD),
    "SpeedLimiter": lambda p: fd.SpeedLimiter([1.0], period=PERIOD),
    "StatusMonitor": lambda p: fd.StatusMonitor(
        3, restart_search=True, blocked=True, smoothed=True
    ),
    "SupervisedDifferentialIk": lambda p: fd.SupervisedDifferentialIk(Still(7), p, period=PERIOD),
    "TargetSource": lambda p: fd.TargetSource(lambda t: [0.4, 0.1, 0.5]),
    "TaskError": lambda p: fd.TaskError(p),
    "VariableGain": lambda p: fd.VariableGain(3),
}


def test_every_public_system_is_here():
    public = {name: getattr(fd, name) for name in fd.__all__}
    systems = {n for n, x in public.items() if isinstance(x, type) and issubclass(x, System)}
    assert systems == set(MAKERS) | {"Recorder"}  # its ports are those that it is asked to record


@pytest.mark.parametrize("name", MAKERS)
def test_the_block_lists_the_real_ports_and_the_text_describes_them(name, ports):
    inputs, outputs = map(
        list, ports(MAKERS[name](MakeDhArmPlant(fd.load_arm("arm7"), time_step=1e-3)))
    )
    text = inspect.getdoc(getattr(fd, name))  # Python 3.13 has it without indentation
    found = re.search(r"\.\. pydrake_system::\n\n((?: {4}.*\n)+)", text)
    described = yaml.safe_load(found.group(1))
    if name == "SupervisedDifferentialIk":  # has the inputs of the system it holds
        assert inputs == ["target"]
        described["input_ports"] = inputs
    if name == "DrakesPorts":  # all of the controller's come after its own
        assert described["output_ports"].pop() == "<all of FuzzyIkController>"
        described["output_ports"] += outputs[1:]
    assert described == {"name": name, "input_ports": inputs, "output_ports": outputs}
    rest = text[found.end() :]
    if name in ELSEWHERE:
        rest += inspect.getdoc(fd.FuzzyIkController)
    for port in [*inputs, *outputs]:
        assert f"**{port}**" in rest or port == "target"
