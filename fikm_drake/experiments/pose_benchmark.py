"""Poses of an arm with limits, reached in the loop, law beside law (`fikm-drake benchmark poses`)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.analysis import Simulator

from fikm_drake.diagrams.add_fuzzy_ik_controller import MakeFuzzyIkController
from fikm_drake.diagrams.fuzzy_ik_controller import FuzzyIkController
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.damped_least_squares import DampedLeastSquares
from fikm_drake.laws.fuzzy_rate_control import FuzzyRateControl
from fikm_drake.laws.law import Law
from fikm_drake.systems.fused_fuzzy_ik import FusedFuzzyIk
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig

ARM, HOME = "iiwa14", (0.0, 0.6, 0.0, -1.4, 0.0, 1.0, 0.0)
TOLERANCE = (1e-3, 0.01)
"""Of position [m] and rotation [rad]."""
SECONDS, RATE = 6.0, 100.0
BEYOND = 0.4
"""How far outside its reach the arm is asked to go, straight on from its home posture [m]."""
SHOULDER = np.array([0.0, 0.0, 0.36])
"""Of the iiwa14 in its base frame [m]."""
REACH = 0.42 + 0.40 + 0.126
"""Of the iiwa14's tool from its shoulder [m]."""

Array = NDArray[np.float64]


def variants() -> dict[str, tuple[FuzzyIkConfig, Law | None]]:
    """What is compared: a config, and a law in place of its fuzzy mapping."""
    common: dict[str, Any] = dict(task="pose", control_rate=RATE, fused=True, error_limit=0.1)

    def config(**changes: Any) -> FuzzyIkConfig:
        return FuzzyIkConfig(**common, **changes)

    return {
        "fuzzy, paper's law": (config(), None),
        "fuzzy, 3 iterations": (config(iterations=3, damping=0.1, row_floor=0.05), None),
        "fuzzy, 6 iterations": (config(iterations=6, damping=0.1, row_floor=0.05), None),
        "rate control, 3 sweeps": (
            FuzzyIkConfig.resolved_rate(**common),
            FuzzyRateControl(sweeps=3),
        ),
        "damped least squares 0.05": (config(), DampedLeastSquares(0.05)),
    }


@dataclass(frozen=True)
class PoseResult:
    """What a law does in the controller."""

    name: str
    reached: int
    """Random reachable poses reached within the tolerance, inside the joint limits."""
    poses: int
    """Poses tried."""
    unrest: float
    """Joint speed, rms, 10 s after the arm was sent out of its reach [rad/s]."""


def pose_benchmark(
    *, poses: int = 60, seed: int = 0, progress: Callable[[float], None] | None = None
) -> list[PoseResult]:
    """Send an iiwa14 from its home posture to random poses, and to one out of its reach.

    Args:
        poses: how many; of postures uniform inside the joint limits, 6 s each at 100 Hz.
        seed: of the poses.
        progress: called after each law with the fraction done.

    Raises:
        ValueError: poses is not positive.
    """
    if poses < 1:
        raise ValueError(f"poses must be positive, got {poses}")
    arm = load_arm(ARM)
    postures = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (poses, arm.num_joints))
    targets = [_pose(T) for T in arm.forward_kinematics(postures)]
    home = _pose(arm.forward_kinematics(HOME))
    ray = home.translation() - SHOULDER
    far = SHOULDER + (REACH + BEYOND) * ray / np.linalg.norm(ray)
    plant = MakeDhArmPlant(arm)
    results = []
    for name, (config, law) in variants().items():
        controller = MakeFuzzyIkController(plant, config=config, law=law)
        ends = [_run(controller, target, SECONDS)[-1] for target in targets]
        reached = sum(_near(_pose(arm.forward_kinematics(q)), X) for q, X in zip(ends, targets))
        out = _run(controller, RigidTransform(home.rotation(), far), 11.0)
        last = RATE * np.diff(out, axis=0)[-round(RATE) :]
        results.append(PoseResult(name, reached, poses, float(np.sqrt((last**2).mean()))))
        if progress:
            progress(len(results) / len(variants()))
    return results


def table(poses: int, progress: Callable[[float], None]) -> str:
    """The benchmark's text."""
    results = pose_benchmark(poses=poses, progress=progress)
    lines = [
        "iiwa14 in the loop, 6 s a pose at 100 Hz, 1 mm and 0.01 rad; then a pose out of reach"
    ]
    lines += [
        f"  {result.name:26s} {result.reached:3d} of {result.poses} poses,"
        f" out of reach {result.unrest:.2g} rad/s rms"
        for result in results
    ]
    return "\n".join(lines)


def _run(
    controller: FuzzyIkController | FusedFuzzyIk, desired: RigidTransform, seconds: float
) -> Array:
    """Joint positions after each cycle (N,n), from the home posture."""
    simulator = Simulator(controller)
    context = simulator.get_mutable_context()
    controller.SetPositions(context, HOME)
    controller.GetInputPort("desired_pose").FixValue(context, Value(desired))
    command = controller.GetOutputPort("commanded_position")
    positions = []
    for k in range(round(seconds * RATE)):
        simulator.AdvanceTo((k + 0.5) / RATE)
        positions.append(command.Eval(context))
    return np.array(positions)


def _pose(T: Array) -> RigidTransform:
    return RigidTransform(RotationMatrix(T[:3, :3]), T[:3, 3])


def _near(X: RigidTransform, Y: RigidTransform) -> bool:
    distance = np.linalg.norm(X.translation() - Y.translation())
    turn = (X.rotation().inverse() @ Y.rotation()).ToAngleAxis().angle()
    return bool(distance < TOLERANCE[0] and turn < TOLERANCE[1])
