"""Public arms, driven to random poses: ours, ours with restart search, Drake's integrator, Pink.

All have the same chain, limits, start (the default posture), rate and time; a model without a limit of a
position or speed gets one. Where the packages of the extra `peers` are not installed, our own models
stand in.
"""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.systems.analysis import Simulator

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.public_arms import ARMS, public_chain, public_plant
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.experiments.reach_targets import MET, Drive, drive, errors, random_targets
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.tasks import make_task
from fikm_drake.kinematics.urdf import urdf
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

RATE, SECONDS = 100.0, 6.0
CYCLES = round(RATE * SECONDS)
OURS = ("arm7", "iiwa14", "panda", "puma560")
SHARP = FuzzyMapping.iterated()
POSITION = FuzzyIkConfig(control_rate=RATE)
POSE = FuzzyIkConfig(control_rate=RATE, task="pose", law=SHARP)


@dataclass(frozen=True)
class ArmRow:
    """Targets reached, out of `targets`, for one arm."""

    arm: str
    joints: int
    targets: int
    position: int
    """By the default controller, position only."""
    position_searched: int
    """The same with restart search."""
    pose: int
    pose_searched: int
    drake: int
    pink: int | None
    """None where it is not installed."""
    false_converged: int
    """False converged of all of our drives: CONVERGED, but not there."""
    largest_speed: float
    """Largest speed of all of our drives, over the limits [-]."""
    outside: float
    """How far beyond the limits of position [rad or m]."""


def table(targets: int, progress: Callable[[float], None]) -> str:
    """The table for `targets` targets an arm."""
    chains = dict(_chains())
    rows = []
    with quiet_drake():
        for i, (name, chain) in enumerate(chains.items()):
            rows.append(_row(name, chain, targets))
            progress((i + 1) / len(chains))
    return BenchmarkTable(_lines(rows), rows)


def _chains() -> Iterator[tuple[str, SerialChain]]:
    with quiet_drake():
        found = []
        for arm in ARMS:
            plant = public_plant(arm)
            if plant is not None:
                found.append((arm.name, public_chain(arm, plant)))
    yield from found or [(name, load_arm(name).chain) for name in OURS]


def _row(name: str, chain: SerialChain, count: int) -> ArmRow:
    plant, start = MakeChainPlant(chain), np.array(chain.default_position)
    arm = PlantArm(plant, "tool")
    targets = random_targets(chain, count, seed=7)
    drives: dict[str, list[Drive]] = {}
    for label, config in (("position", POSITION), ("pose", POSE)):
        for searched in (False, True):
            config = dataclasses.replace(config, restart_search=searched)
            cycle = ControlCycle(make_task(arm, config.task), config)
            drives[f"{label} {searched}"] = [
                drive(cycle, chain, target, start, CYCLES) for target in targets
            ]
    every = [one for several in drives.values() for one in several]
    reached = {label: sum(one.reached for one in several) for label, several in drives.items()}
    pink = _pink(chain, start) if find_spec("pink") else None
    drake = _drake(chain, start)
    return ArmRow(
        name,
        chain.num_joints,
        count,
        reached["position False"],
        reached["position True"],
        reached["pose False"],
        reached["pose True"],
        sum(_met(chain, drake(target), target) for target in targets),
        None if pink is None else sum(_met(chain, pink(target), target) for target in targets),
        sum(not one.honest for one in every),
        max(one.largest_speed for one in every),
        max(one.outside for one in every),
    )


def _met(chain: SerialChain, q: Array, target: RigidTransform) -> bool:
    inside = (q >= chain.lower - 1e-6) & (q <= chain.upper + 1e-6)
    distance, angle = errors(chain.forward_kinematics(q), target)
    return bool(inside.all() and distance <= MET[0] and angle <= MET[1])


def _drake(chain: SerialChain, start: Array) -> Callable[[RigidTransform], Array]:
    plant, n = MakeChainPlant(chain), chain.num_joints
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(1.0 / RATE)
    parameters.set_nominal_joint_position(start)
    parameters.set_joint_position_limits((chain.lower, chain.upper))
    parameters.set_joint_velocity_limits((-chain.velocity_limits, chain.velocity_limits))
    tool = plant.GetFrameByName("tool")
    system = DifferentialInverseKinematicsIntegrator(plant, tool, 1.0 / RATE, parameters)

    def run(target: RigidTransform) -> Array:
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        system.SetPositions(context, start)
        system.GetInputPort("X_AE_desired").FixValue(context, Value(target))
        simulator.AdvanceTo(SECONDS)
        return np.array(system.GetOutputPort("joint_positions").Eval(context))

    return run


def _pink(chain: SerialChain, start: Array) -> Callable[[RigidTransform], Array]:
    """Pink's usual set-up: a frame task and a weak posture task."""
    pink, pinocchio = import_module("pink"), import_module("pinocchio")
    tasks = import_module("pink.tasks")
    names = tuple(f"joint{i}" for i in range(1, chain.num_joints + 1))
    plain = dataclasses.replace(chain, name="chain", joint_names=names)
    model = pinocchio.buildModelFromXML(urdf(plain, capsules=False))
    data = model.createData()

    def run(target: RigidTransform) -> Array:
        configuration = pink.Configuration(model, data, np.array(start))
        frame = tasks.FrameTask("tool", position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
        point = np.array(target.translation())
        frame.set_target(pinocchio.SE3(target.rotation().matrix(), point))
        posture = tasks.PostureTask(cost=1e-3)
        posture.set_target_from_configuration(configuration)
        for _ in range(CYCLES):
            velocity = pink.solve_ik(
                configuration, [frame, posture], 1.0 / RATE, solver="quadprog", safety_break=False
            )
            configuration.integrate_inplace(velocity, 1.0 / RATE)
        return np.array(configuration.q)

    return run


def _lines(rows: list[ArmRow]) -> Iterator[str]:
    heads = ("position", "searched", "pose", "searched", "Drake", "Pink", "false", "speed")
    yield f"{'arm':34s}{'n':>3s}" + "".join(f"{head:>9s}" for head in heads)
    for row in rows:
        numbers = (row.position, row.position_searched, row.pose, row.pose_searched, row.drake)
        cells = "".join(f"{number:9d}" for number in numbers)
        pink = "-" if row.pink is None else str(row.pink)
        yield (
            f"{row.arm:34s}{row.joints:3d}{cells}{pink:>9s}{row.false_converged:9d}"
            f"{row.largest_speed:9.3f}"
        )
    total = sum(row.targets for row in rows)
    position = sum(row.position for row in rows), sum(row.position_searched for row in rows)
    yield f"{len(rows)} arms, {total} targets, from the default posture, {SECONDS:g} s at {RATE:g} Hz"
    yield f"position: default {position[0]}, with restart search {position[1]}"
    peers = [row for row in rows if row.pink is not None]
    if peers:
        least = sum(row.pose_searched >= (row.pink or 0) for row in peers)
        plain = sum(row.pose >= (row.pink or 0) for row in peers)
        yield f"pose: at least as many as Pink on {least} arms with restart search, on {plain} without"
    yield f"false CONVERGED: {sum(row.false_converged for row in rows)}"
    speed, outside = max(row.largest_speed for row in rows), max(row.outside for row in rows)
    yield f"largest speed over its limit: {speed:.4f}; farthest outside limits: {outside:.1e}"
