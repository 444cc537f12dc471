"""Poses of an arm with limits, reached in the loop, law beside law (`fikm-drake benchmark poses`)."""

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import MakeFuzzyIkController
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.pose_checks import as_pose, is_near
from fikm_drake.experiments.benchmarks.pose_peers import Run, advance, pose_peers
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import Law

ARM, HOME = "iiwa14", (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0)
INSIDE = 1e-6
"""A limit that is crossed by less is not crossed: solvers of QPs stop there [rad]."""
SECONDS, RATE = 6.0, 100.0
BEYOND = 0.4
"""How far outside its reach the arm is asked to go, straight on from its home posture [m]."""
SHOULDER = np.array([0.0, 0.0, 0.36])
"""Shoulder of the iiwa14 in its base frame [m]."""
REACH = 0.42 + 0.40 + 0.126
"""Reach of the iiwa14's tool from its shoulder [m]."""


@dataclass(frozen=True)
class PoseResult:
    """What a method does."""

    name: str
    reached: int
    """Random reachable poses reached within the tolerance, inside the joint limits."""
    poses: int
    """Poses tried."""
    unrest: float
    """Joint speed, rms, 10 s after the arm was sent out of its reach [rad/s]."""
    reversals: float
    """Changes of sign of the joint steps in that second, mean over the joints [-]."""
    microseconds: float
    """CPU time of a cycle, all of the loop included [µs]."""


def pose_benchmark(
    *, poses: int = 60, seed: int = 0, progress: Callable[[float], None] | None = None
) -> list[PoseResult]:
    """Send an iiwa14 from its home posture to random poses, and to one out of its reach.

    Args:
        poses: how many; of postures uniform inside the joint limits, 6 s each at 100 Hz.
        seed: of the poses.
        progress: called after each method with the fraction done.

    Raises:
        ValueError: poses is not positive.
    """
    if poses < 1:
        raise ValueError(f"poses must be positive, got {poses}")
    arm = load_arm(ARM)
    postures = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (poses, arm.num_joints))
    targets = [as_pose(T) for T in arm.forward_kinematics(postures)]
    home = as_pose(arm.forward_kinematics(HOME))
    ray = home.translation() - SHOULDER
    far = SHOULDER + (REACH + BEYOND) * ray / np.linalg.norm(ray)
    methods = _ours(arm) | pose_peers(arm, np.array(HOME), RATE)
    results = []
    for name, run in methods.items():
        with quiet_drake():
            start = time.process_time()
            ends = [run(target, SECONDS)[-1] for target in targets]
            spent = time.process_time() - start
            out = run(RigidTransform(home.rotation(), far), 11.0)
        reached = sum(_reaches(arm, q, X) for q, X in zip(ends, targets))
        last = RATE * np.diff(out, axis=0)[-round(RATE) :]
        moving = np.where(np.abs(last) > 1e-6, last, 0.0)
        results.append(
            PoseResult(
                name,
                reached,
                poses,
                float(np.sqrt((last**2).mean())),
                float((moving[1:] * moving[:-1] < 0.0).sum(axis=0).mean()),
                1e6 * spent / (poses * SECONDS * RATE),
            )
        )
        if progress:
            progress(len(results) / len(methods))
    return results


def table(poses: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = pose_benchmark(poses=poses, progress=progress)
    lines = [
        "iiwa14 in the loop at 100 Hz, 6 s a pose, within 1 mm and 0.01 rad, limits of position and speed;",
        "then a pose 0.4 m out of reach after 10 s: joint speed, rms, and reversals of a joint a second",
    ]
    lines += [
        f"  {r.name:45s} {r.reached:3d} of {r.poses} poses | {r.unrest:8.2g} rad/s {r.reversals:5.1f} / s"
        f" | {r.microseconds:5.0f} µs a cycle"
        for r in results
    ]
    return BenchmarkTable(lines, results)


def variants() -> dict[str, tuple[FuzzyIkConfig, Law | None]]:
    """Ours: a config, and a law in place of its fuzzy mapping."""
    config = FuzzyIkConfig(task="pose", control_rate=RATE, fused=True)
    sharp = dataclasses.replace(config, law=FuzzyMapping.iterated())
    return {
        "fuzzy, the paper's law": (config, None),
        "fuzzy, 6 iterations": (sharp, None),
        "fuzzy, 6 iterations, restart_search": (
            dataclasses.replace(sharp, restart_search=True, restart_speed=3.0),
            None,
        ),
        "rate control, 3 sweeps": (
            config.resolved_rate(),
            FuzzyRateControl(sweeps=3),
        ),
        "damped least squares 0.05 in our controller": (config, DampedLeastSquares(0.05)),
    }


def _ours(arm: DhArm) -> dict[str, Run]:
    plant = MakeDhArmPlant(arm)

    def method(config: FuzzyIkConfig, law: Law | None) -> Run:
        controller = MakeFuzzyIkController(plant, config=config, law=law)

        def run(desired: RigidTransform, seconds: float) -> Array:
            simulator = Simulator(controller)
            context = simulator.get_mutable_context()
            controller.SetPositions(context, HOME)
            controller.GetInputPort("desired_pose").FixValue(context, Value(desired))
            return advance(simulator, "commanded_position", seconds, RATE)

        return run

    return {name: method(*variant) for name, variant in variants().items()}


def _reaches(arm: DhArm, q: Array, X: RigidTransform) -> bool:
    """True if the tool at q (n,) is at X within the tolerance, and q inside the limits."""
    inside = (q >= arm.lower - INSIDE).all() and (q <= arm.upper + INSIDE).all()
    return bool(inside and is_near(as_pose(arm.forward_kinematics(q)), X))
