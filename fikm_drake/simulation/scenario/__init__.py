"""What a run is: one schema in YAML (`Scenario`), and how it becomes a Diagram (`build_scenario`).

A scenario names a robot, a controller, a target over time, a plant, a sensor and obstacles. What may
enter: descriptions that Drake's typed YAML loads, and how they become systems; no arithmetic of control.
"""

from fikm_drake.simulation.scenario.build_scenario import BuiltScenario, build_scenario
from fikm_drake.simulation.scenario.controllers import Frmrc, Fuzzy, SupervisedDrake
from fikm_drake.simulation.scenario.environment import (
    Kinematic,
    Obstacle,
    Sensor,
    Servos,
    SimIiwa,
    TorqueDriven,
)
from fikm_drake.simulation.scenario.load import TrackingScenario, load_scenario
from fikm_drake.simulation.scenario.motion import Motion, Pose
from fikm_drake.simulation.scenario.position_solvers import Integer, LabVolt, Redundancy
from fikm_drake.simulation.scenario.robots import Model
from fikm_drake.simulation.scenario.samples import Csv, Samples
from fikm_drake.simulation.scenario.schema import Scenario
from fikm_drake.simulation.scenario.targets import Circle, Path

__all__ = [
    "BuiltScenario",
    "Circle",
    "Csv",
    "Frmrc",
    "Fuzzy",
    "Integer",
    "Kinematic",
    "LabVolt",
    "Model",
    "Motion",
    "Obstacle",
    "Path",
    "Pose",
    "Redundancy",
    "Samples",
    "Scenario",
    "Sensor",
    "Servos",
    "SimIiwa",
    "SupervisedDrake",
    "TorqueDriven",
    "TrackingScenario",
    "build_scenario",
    "load_scenario",
]
