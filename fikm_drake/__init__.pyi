from fikm_drake.control.clearance import Clearance, ClearanceInfo
from fikm_drake.control.clearance_config import ClearanceConfig, load_clearance_rules
from fikm_drake.control.command_supervision import CommandSupervision, CommandSupervisorConfig
from fikm_drake.control.cycle import ControlCycle, CycleState, Tick
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.jerk_limit import JerkLimit
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.restart_state import RestartState
from fikm_drake.control.rollout import Rollout, rollout
from fikm_drake.control.status import ControllerStatus
from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController, MakeFuzzyIkController
from fikm_drake.diagrams.drakes_ports import DrakesPorts
from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.diagrams.fuzzy_ik_torque_controller import (
    AddFuzzyIkTorqueController,
    FuzzyIkTorqueController,
)
from fikm_drake.diagrams.supervised_differential_ik import (
    AddSupervisedDifferentialIk,
    SupervisedDifferentialIk,
)
from fikm_drake.fuzzy import RuleBase, TriangularPartition
from fikm_drake.fuzzy.anfis import Anfis
from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani import (
    FuzzyRule,
    Inference,
    MamdaniConfig,
    MamdaniSystem,
    load_mamdani,
    parse_rules,
)
from fikm_drake.fuzzy.memberships import Gaussian, Trapezoid, Triangle
from fikm_drake.fuzzy.teaching import (
    Explanation,
    fuzzy_view,
    plot_memberships,
    plot_rules,
    plot_surface,
    write_rules_page,
)
from fikm_drake.kinematics.add_dh_arm import AddDhArm, MakeDhArmPlant
from fikm_drake.kinematics.arm_drawing import arm_drawing
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform, DhUnit
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.make_collision_checker import MakeCollisionChecker
from fikm_drake.kinematics.planar_3r import Planar3R
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.robot_file import AddRobot, MakeRobotPlant, check_robot_file
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task_kinematics import PlantTask, PoseTargetTask, TaskKinematics
from fikm_drake.kinematics.tasks import OrientationTask, PointingTask, PoseTask, PositionTask
from fikm_drake.laws import LAWS, named_law
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.jacobian_transpose import JacobianTranspose
from fikm_drake.laws.law import Law
from fikm_drake.laws.pseudo_inverse import PseudoInverse
from fikm_drake.laws.rule_generation import generate_rule_base
from fikm_drake.resources import ConfigureParser
from fikm_drake.simulation import scenario
from fikm_drake.simulation.compare import Comparison, compare
from fikm_drake.simulation.plot_log import plot_log
from fikm_drake.simulation.plot_sweep import plot_sweep
from fikm_drake.simulation.recorder import Recorder, record
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import (
    BuiltScenario,
    Scenario,
    TrackingScenario,
    build_scenario,
    load_scenario,
)
from fikm_drake.simulation.simulate import SimulationStopped, simulate
from fikm_drake.simulation.sweep_runs import Grid, Sweep, SweepRow, load_grid, sweep
from fikm_drake.simulation.teleoperation import Teleop
from fikm_drake.simulation.tracking_metrics import TrackingMetrics
from fikm_drake.simulation.write_html import write_html
from fikm_drake.solvers import labvolt
from fikm_drake.solvers.batch.batch_solution import BatchSolution, SolverStatus
from fikm_drake.solvers.paths.joint_path import JointPath, joint_path
from fikm_drake.solvers.paths.path_follower import PathStatus
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import Resolution, ResolutionStatus
from fikm_drake.solvers.redundancy.train_bounds import train_bounds
from fikm_drake.solvers.redundancy.train_traced_bounds import train_traced_bounds
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasibility_data import FeasibilityData
from fikm_drake.solvers.self_motion.feasible_intervals import (
    feasible_interval_table,
    feasible_intervals,
)
from fikm_drake.solvers.self_motion.generate_feasibility_data import generate_feasibility_data
from fikm_drake.solvers.self_motion.interval_table import FeasibleInterval, IntervalTable
from fikm_drake.solvers.self_motion.minimum_norm_path import minimum_norm_path
from fikm_drake.solvers.self_motion.nearest_reachable import NearestReachable, nearest_reachable
from fikm_drake.solvers.self_motion.self_motion import (
    SelfMotion,
    SelfMotionComponent,
    SelfMotionStatus,
)
from fikm_drake.solvers.self_motion.trace_self_motion import SelfMotionTracer, trace_self_motion
from fikm_drake.solvers.solver import Solution, Solver, solve, solve_batch
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk
from fikm_drake.solvers.workplane.workplane import Workplane, load_workplane
from fikm_drake.solvers.workplane.workplane_data import WorkplaneData, load_workplane_data
from fikm_drake.solvers.workplane.workplane_inverse import TiltedPlaneInverse, WorkplaneInverse
from fikm_drake.systems.chain_inverse_dynamics import ChainInverseDynamics
from fikm_drake.systems.clearance_filter import ClearanceFilter
from fikm_drake.systems.command_smoother import CommandSmoother
from fikm_drake.systems.command_supervisor import CommandSupervisor
from fikm_drake.systems.differential_ik import DifferentialIk
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk
from fikm_drake.systems.gain_supervisor import GainSupervisor
from fikm_drake.systems.guard_block import GuardBlock
from fikm_drake.systems.integer_fuzzy_ik_system import IntegerFuzzyIkStatus, IntegerFuzzyIkSystem
from fikm_drake.systems.joint_integrator import JointIntegrator
from fikm_drake.systems.joint_reference import JointReference
from fikm_drake.systems.joint_sensor import JointSensor
from fikm_drake.systems.labvolt_ik import LabVoltIk
from fikm_drake.systems.last_finite import LastFinite
from fikm_drake.systems.low_pass_filter import LowPassFilter
from fikm_drake.systems.null_space_filter import NullSpaceFilter
from fikm_drake.systems.null_space_motion import NullSpaceMotion
from fikm_drake.systems.redundancy_ik import RedundancyIk
from fikm_drake.systems.restart_planner import RestartPlanner
from fikm_drake.systems.slow_feedback import SlowFeedback
from fikm_drake.systems.speed_limiter import SpeedLimiter
from fikm_drake.systems.status_monitor import StatusMonitor
from fikm_drake.systems.target_in_frame import TargetInFrame
from fikm_drake.systems.target_source import TargetSource
from fikm_drake.systems.task_error import TaskError
from fikm_drake.systems.variable_gain import VariableGain

__version__: str

__all__ = [
    "AddDhArm",
    "AddFuzzyIkController",
    "AddFuzzyIkTorqueController",
    "AddRobot",
    "AddSupervisedDifferentialIk",
    "Anfis",
    "BatchSolution",
    "BuiltScenario",
    "ChainInverseDynamics",
    "Clearance",
    "ClearanceConfig",
    "ClearanceFilter",
    "ClearanceInfo",
    "CommandSupervision",
    "CommandSmoother",
    "CommandSupervisor",
    "CommandSupervisorConfig",
    "Comparison",
    "ConfigureParser",
    "ControlCycle",
    "ControllerStatus",
    "CycleState",
    "DampedLeastSquares",
    "DhArm",
    "DhJoint",
    "DhTable",
    "DhTransform",
    "DhUnit",
    "DifferentialIk",
    "DrakesPorts",
    "Explanation",
    "FeasibilityData",
    "FeasibleInterval",
    "FusedFuzzyIk",
    "FuzzyIkConfig",
    "FuzzyIkController",
    "FuzzyIkTorqueController",
    "FuzzyMapping",
    "FuzzyRateControl",
    "FuzzyRule",
    "FuzzyVariable",
    "GainSupervision",
    "GainSupervisor",
    "GainSupervisorConfig",
    "Gaussian",
    "Grid",
    "GuardBlock",
    "Inference",
    "IntegerFuzzyIk",
    "IntegerFuzzyIkStatus",
    "IntegerFuzzyIkSystem",
    "IntervalTable",
    "JacobianTranspose",
    "JerkLimit",
    "JointIntegrator",
    "JointLimits",
    "JointPath",
    "JointReference",
    "JointSensor",
    "LAWS",
    "LabVoltIk",
    "LastFinite",
    "Law",
    "LearnedBounds",
    "LowPassFilter",
    "MakeCollisionChecker",
    "MakeDhArmPlant",
    "MakeFuzzyIkController",
    "MakeRobotPlant",
    "MamdaniConfig",
    "MamdaniSystem",
    "NearestReachable",
    "NullSpaceFilter",
    "NullSpaceMotion",
    "OrientationTask",
    "PathStatus",
    "Planar3R",
    "PlantArm",
    "PlantTask",
    "PointingTask",
    "PoseTargetTask",
    "PoseTask",
    "PositionTask",
    "PseudoInverse",
    "Recorder",
    "RedundancyIk",
    "RedundancyResolver",
    "Resolution",
    "ResolutionStatus",
    "RestartPlanner",
    "RestartState",
    "Rollout",
    "RuleBase",
    "RunLog",
    "Scenario",
    "SelfMotion",
    "SelfMotionComponent",
    "SelfMotionStatus",
    "SelfMotionTracer",
    "SerialChain",
    "SimulationStopped",
    "SlowFeedback",
    "SpeedLimiter",
    "Solution",
    "Solver",
    "SolverStatus",
    "StatusMonitor",
    "SupervisedDifferentialIk",
    "Sweep",
    "SweepRow",
    "TargetInFrame",
    "TargetSource",
    "TaskError",
    "TaskKinematics",
    "Teleop",
    "Tick",
    "TiltedPlaneInverse",
    "TrackingMetrics",
    "TrackingScenario",
    "Trapezoid",
    "Triangle",
    "TriangularPartition",
    "VariableGain",
    "Workplane",
    "WorkplaneData",
    "WorkplaneInverse",
    "arm_drawing",
    "build_scenario",
    "check_robot_file",
    "closest_to_mid_range",
    "compare",
    "feasible_interval_table",
    "feasible_intervals",
    "fuzzy_view",
    "generate_feasibility_data",
    "generate_rule_base",
    "joint_path",
    "labvolt",
    "load_arm",
    "load_clearance_rules",
    "load_grid",
    "load_mamdani",
    "load_scenario",
    "load_workplane",
    "load_workplane_data",
    "minimum_norm_path",
    "named_law",
    "nearest_reachable",
    "parse_rules",
    "plot_log",
    "plot_memberships",
    "plot_rules",
    "plot_surface",
    "plot_sweep",
    "record",
    "rollout",
    "scenario",
    "simulate",
    "solve",
    "solve_batch",
    "sweep",
    "trace_self_motion",
    "train_bounds",
    "train_traced_bounds",
    "write_html",
    "write_rules_page",
]
