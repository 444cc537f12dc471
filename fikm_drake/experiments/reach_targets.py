"""Drive a controller's cycle to targets, one after the other from one start, without a Simulator."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.status import ControllerStatus
from fikm_drake.kinematics.serial_chain import SerialChain

SETTLED = 10
"""Cycles in a row with the same final status that end a drive [-]."""
MET = (1.2e-3, float(np.deg2rad(0.6)))
"""Errors of position [m] and rotation [rad] up to which a target is reached, by the chain itself."""


@dataclass(frozen=True)
class Drive:
    """How a drive to one target ended."""

    position_error: float
    """[m]"""
    rotation_error: float
    """[rad]; zero for tasks of position."""
    status: ControllerStatus
    """Status of the last cycle."""
    largest_speed: float
    """Over the joints' limits of speed [-]."""
    outside: float
    """How far a joint was beyond its limits at most [rad or m]."""
    cycles: int
    """Driven."""
    seconds: float
    """Seconds of CPU, for all of them [s]."""

    @property
    def reached(self) -> bool:
        """Whether the tool is there, whatever the status says."""
        return self.position_error <= MET[0] and self.rotation_error <= MET[1]

    @property
    def honest(self) -> bool:
        """Whether a status CONVERGED is true."""
        return self.reached or self.status != ControllerStatus.CONVERGED


def drive(
    cycle: ControlCycle, chain: SerialChain, target: RigidTransform, start: Array, cycles: int
) -> Drive:
    """Run the cycle to a pose, or to its position, from joint positions (n,) until it settles.

    Args:
        cycle: of a task with a pose or a position (3) as target.
        chain: the arm, by whose kinematics the end is judged.
        target: X_WE.
        start: (n,) [rad or m].
        cycles: at most.
    """
    pose = cycle.task.size != 3
    wanted = target if pose else target.translation()
    state, q = cycle.start(start), np.array(start)
    speed = outside = 0.0
    settled, driven, status = 0, 0, ControllerStatus.INVALID_INPUT
    began = time.process_time()
    while driven < cycles and settled < SETTLED:
        driven += 1
        tick = cycle.tick(state, wanted, q)
        last, status = status, cycle.status(state, tick)
        cycle.advance(state, wanted, q, tick)
        q = state.command.copy()
        speed = max(speed, float(np.max(np.abs(state.velocity) / chain.velocity_limits)))
        outside = max(outside, float(np.max(np.maximum(chain.lower - q, q - chain.upper))))
        final = status in (ControllerStatus.CONVERGED, ControllerStatus.STUCK)
        settled = settled + 1 if final and status == last else 0
    seconds = time.process_time() - began
    X = chain.forward_kinematics(q)
    position, rotation = errors(X, target)
    return Drive(position, rotation if pose else 0.0, status, speed, outside, driven, seconds)


def errors(X: Array, target: RigidTransform) -> tuple[float, float]:
    """Distance [m] and angle [rad] between a pose (4,4) and a target."""
    relative = X[:3, :3].T @ target.rotation().matrix()
    sine = np.linalg.norm(relative - np.eye(3)) / np.sqrt(8.0)
    distance = np.linalg.norm(X[:3, 3] - target.translation())
    return float(distance), float(2.0 * np.arcsin(min(1.0, sine)))


def random_targets(chain: SerialChain, count: int, seed: int) -> Sequence[RigidTransform]:
    """Poses of random postures inside the limits, half a turn from their middle at most."""
    low = np.maximum(chain.lower, np.minimum(chain.upper, 0.0) - np.pi)
    high = np.minimum(chain.upper, np.maximum(chain.lower, 0.0) + np.pi)
    q = np.random.default_rng(seed).uniform(low, high, (count, chain.num_joints))
    return [RigidTransform(X) for X in chain.forward_kinematics(q)]
