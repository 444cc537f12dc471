"""Drake's differential IK as it is and supervised (`fikm-drake benchmark supervise`)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import DifferentialInverseKinematicsController
from pydrake.systems.analysis import Simulator

from fikm_drake.arrays import Array
from fikm_drake.diagrams.drake_differential_ik import (
    desired_pose,
    drake_differential_ik,
)
from fikm_drake.diagrams.supervised_differential_ik import SupervisedDifferentialIk
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.pose_checks import as_pose, is_near
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm

HOME = {
    "iiwa14": (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0),
    "panda": (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
}
"""Ready postures [rad]."""
REACH = {"iiwa14": (0.36, 0.946), "panda": (0.333, 1.07)}
"""Height of the shoulder and reach of the tool from there, or somewhat more [m]."""
BEYOND = 0.4
"""How far outside the reach the far pose is [m]."""
RATE = 100.0
"""[Hz]"""
FAR_SECONDS, POSE_SECONDS, PATH_SECONDS = 11.0, 7.0, 5.0
MOVING = 1e-6
"""A reversal is of a joint that is about this fast or faster [rad/s]."""
BEFORE, AFTER = "Drake's controller", "supervised"

Poses = list[RigidTransform]
Run = Callable[[Poses], Array]


@dataclass(frozen=True)
class SupervisionResult:
    """What one arm does, as Drake's controller has it or supervised."""

    arm: str
    """Name of the arm."""
    name: str
    """`BEFORE` or `AFTER`."""
    unrest: float
    """Joint speed in the eleventh second of a far pose, rms over joints and time [rad/s]."""
    reversals: int
    """Changes of sign of the joint that has most of them, in that second."""
    far_unrest: float
    """Median of the unrest over the random far poses [rad/s]."""
    e_max: float
    """Largest error of position on the path [m]."""
    e_mean: float
    """Mean error of position on the path [m]."""
    reached: int
    """Random reachable poses within the tolerance after 7 s."""
    poses: int
    """Random poses tried, reachable and as many far ones."""


def supervise_benchmark(
    *,
    arms: Sequence[str] = ("iiwa14", "panda"),
    poses: int = 20,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> list[SupervisionResult]:
    """Run Drake's `DifferentialInverseKinematicsController` and the same, supervised, at 100 Hz.

    Each arm goes from its home posture, with its joint and speed limits: to the pose `BEYOND` its
    reach, straight on from where the tool is; to random poses that far out; along a figure of eight
    of 0.3 m; and to random reachable poses.

    Args:
        arms: of `HOME`.
        poses: how many random poses, of postures uniform inside the joint limits.
        seed: of the poses.
        progress: called now and then with the fraction done.

    Raises:
        ValueError: poses is not positive, or an arm is none of `HOME`.
    """
    if poses < 1:
        raise ValueError(f"poses must be positive, got {poses}")
    for name in arms:
        if name not in HOME:
            raise ValueError(f"arms must be of {tuple(HOME)}, got {name!r}")
    results: list[SupervisionResult] = []
    with quiet_drake():
        for name in arms:
            arm = load_arm(name)
            for make in (_drake, _supervised):
                results.append(_measure(arm, make(arm), poses, seed))
                if progress:
                    progress(len(results) / (2 * len(arms)))
    return results


def table(poses: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = supervise_benchmark(poses=poses, progress=progress)
    lines = [
        "100 Hz, a pose 0.4 m out of reach: joint speed (rms) and reversals a second after 10 s;",
        f"the same for {poses} random poses as far out (median); a path; {poses} reachable poses in 7 s",
    ]
    lines += [
        f"  {r.arm:7s} {r.name:19s} {r.unrest:8.2g} rad/s {r.reversals:3d}/s | {r.far_unrest:8.2g} rad/s"
        f" | e_max {1e3 * r.e_max:.3f} e_mean {1e3 * r.e_mean:.3f} mm | {r.reached} of {r.poses}"
        for r in results
    ]
    return BenchmarkTable(lines, results)


def far_pose(arm: DhArm, T: Array) -> RigidTransform:
    """The tool's pose `T` (4,4) moved `BEYOND` the reach, straight out from the shoulder."""
    height, reach = REACH[arm.name]
    shoulder = np.array([0.0, 0.0, height])
    ray = T[:3, 3] - shoulder
    return RigidTransform(
        RotationMatrix(T[:3, :3]), shoulder + (reach + BEYOND) * ray / np.linalg.norm(ray)
    )


def _measure(arm: DhArm, run: tuple[str, Run], poses: int, seed: int) -> SupervisionResult:
    name, positions = run
    home = arm.forward_kinematics(HOME[arm.name])
    rng = np.random.default_rng(seed)
    targets, far = (
        arm.forward_kinematics(rng.uniform(arm.lower, arm.upper, (poses, arm.num_joints)))
        for _ in range(2)
    )

    def last_second(T: Array) -> Array:
        q = positions(_stay(far_pose(arm, T), FAR_SECONDS))
        return RATE * np.diff(q, axis=0)[-round(RATE) :]

    v = last_second(home)
    path = _path(home)
    goal = np.array([X.translation() for X in path])
    error = np.linalg.norm(arm.forward_kinematics(positions(path))[:, :3, 3] - goal, axis=1)
    ends = (arm.forward_kinematics(positions(_stay(as_pose(T), POSE_SECONDS))[-1]) for T in targets)
    return SupervisionResult(
        arm=arm.name,
        name=name,
        unrest=_rms(v),
        reversals=int((v[1:] * v[:-1] < -(MOVING**2)).sum(axis=0).max()),
        far_unrest=float(np.median([_rms(last_second(T)) for T in far])),
        e_max=float(error.max()),
        e_mean=float(error.mean()),
        reached=sum(is_near(as_pose(T), as_pose(Y)) for T, Y in zip(targets, ends)),
        poses=poses,
    )


def _drake(arm: DhArm) -> tuple[str, Run]:
    system = DifferentialInverseKinematicsController(
        drake_differential_ik(arm, period=1.0 / RATE), []
    )

    def run(desired: Poses) -> Array:
        simulator = Simulator(system)
        context = simulator.get_mutable_context()
        system.set_initial_position(context, HOME[arm.name])
        system.GetInputPort("estimated_state").FixValue(context, np.zeros(2 * arm.num_joints))
        return _follow(simulator, "desired_poses", arm, desired)

    return BEFORE, run


def _supervised(arm: DhArm) -> tuple[str, Run]:
    ik = drake_differential_ik(arm, period=1.0 / RATE)
    system = SupervisedDifferentialIk(ik, ik.plant(), period=ik.time_step())

    def run(desired: Poses) -> Array:
        simulator = Simulator(system)
        system.SetPositions(simulator.get_mutable_context(), HOME[arm.name])
        return _follow(simulator, "desired_cartesian_poses", arm, desired)

    return AFTER, run


def _follow(simulator: Simulator, name: str, arm: DhArm, desired: Poses) -> Array:
    """Joint positions (N,n) after each cycle; `desired` are the poses of the cycles."""
    system, context = simulator.get_system(), simulator.get_mutable_context()
    system.GetInputPort("nominal_posture").FixValue(context, HOME[arm.name])
    port, command = system.GetInputPort(name), system.GetOutputPort("commanded_position")
    positions, fixed = [], None
    for k, X in enumerate(desired):
        if X is not fixed:
            port.FixValue(context, desired_pose(arm, X))
            fixed = X
        simulator.AdvanceTo((k + 0.5) / RATE)
        positions.append(command.Eval(context))
    return np.array(positions)


def _stay(X: RigidTransform, seconds: float) -> Poses:
    return [X] * round(seconds * RATE)


def _path(home: Array) -> Poses:
    """A figure of eight, 0.3 m wide and 0.1 m deep, from the home pose and back to it."""
    phase = 2 * np.pi * np.arange(round(PATH_SECONDS * RATE)) / (PATH_SECONDS * RATE)
    way = np.stack(
        [0.05 * (np.cos(phase) - 1.0), 0.15 * np.sin(phase), 0.1 * np.sin(2 * phase)], axis=1
    )
    return [RigidTransform(RotationMatrix(home[:3, :3]), home[:3, 3] + p) for p in way]


def _rms(v: Array) -> float:
    return float(np.sqrt((v**2).mean()))
