"""The fastest way along a joint path inside limits of speed and acceleration, by Drake's Toppra."""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from pydrake.multibody.optimization import Toppra
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.trajectories import PathParameterizedTrajectory, PiecewisePolynomial

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain

NEAR = 1e-9
"""Rows of a path that differ by less are one [rad or m]."""
ACCELERATION_TIME = 0.1
"""A joint without limit of acceleration takes this long to its limit of speed [s]."""
PARTS = 4
"""Parts of each row's way, between which Toppra's limits hold [-]."""
SAMPLES = 1000
"""At which the limits are looked at once more; a little time is added where they need it (-)."""
SPEED = 1.0
"""Speed of a joint without limit of speed [rad/s or m/s]."""


def path_trajectory(
    chain: SerialChain,
    q: Array,
    *,
    velocity_limits: ArrayLike | None = None,
    acceleration_limits: ArrayLike | None = None,
) -> PathParameterizedTrajectory:
    """Joint positions as a trajectory in time, from rest to rest, as fast as the limits allow.

    Between the path's rows the joints follow a cubic spline.

    Args:
        chain: the arm.
        q: joint positions (N,n) one after the other [rad or m].
        velocity_limits: of each joint, one number or (n,) [rad/s or m/s]; None: the chain's, and 1 for
            joints that have none.
        acceleration_limits: of each joint, one number or (n,) [rad/s² or m/s²]; None: the chain's,
            and for joints that have none, what reaches the limit of speed in 0.1 s.

    Raises:
        ValueError: there are fewer than two different rows, or a limit is not positive and finite.
        RuntimeError: Toppra finds no solution.
    """
    n = chain.num_joints
    speeds = np.where(np.isfinite(chain.velocity_limits), chain.velocity_limits, SPEED)
    speeds = _limits("velocity_limits", velocity_limits, speeds)
    own = np.where(
        np.isfinite(chain.acceleration_limits),
        chain.acceleration_limits,
        speeds / ACCELERATION_TIME,
    )
    accelerations = _limits("acceleration_limits", acceleration_limits, own)
    moves = np.abs(np.diff(q, axis=0)).max(axis=1) > NEAR
    rows = q[np.r_[True, moves]]
    if len(rows) < 2:
        raise ValueError("the path must have at least two rows that differ")
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(rows, axis=0) / speeds, axis=1))]
    if len(rows) > 2:
        spline = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(along, rows.T)
    else:
        spline = PiecewisePolynomial.FirstOrderHold(along, rows.T)
    grid = np.unique(np.linspace(along[:-1], along[1:], PARTS + 1).ravel())
    toppra = Toppra(spline, _sliders(n), grid)
    toppra.AddJointVelocityLimit(-speeds, speeds)
    toppra.AddJointAccelerationLimit(-accelerations, accelerations)
    times = toppra.SolvePathParameterization()
    if times is None:
        raise RuntimeError("Toppra finds no timing of the path inside the limits")
    trajectory = PathParameterizedTrajectory(spline, times)
    excess = _excess(trajectory, speeds, accelerations)
    if excess > 1.0:  # between the grid's points
        times.ScaleTime(excess)
        trajectory = PathParameterizedTrajectory(spline, times)
    return trajectory


def _excess(trajectory: PathParameterizedTrajectory, speeds: Array, accelerations: Array) -> float:
    """By how much the trajectory's time must be stretched to be inside the limits at many samples."""
    times = np.linspace(trajectory.start_time(), trajectory.end_time(), SAMPLES)
    most = 0.0
    for t in times:
        v, a = (trajectory.EvalDerivative(t, k)[:, 0] for k in (1, 2))
        most = max(most, np.abs(v / speeds).max(), np.sqrt(np.abs(a / accelerations).max()))
    return float(most)


def _limits(name: str, given: ArrayLike | None, own: Array) -> Array:
    values = np.array(own if given is None else given, dtype=float)
    if (
        values.shape not in ((), own.shape)
        or not (values > 0.0).all()
        or not np.isfinite(values).all()
    ):
        raise ValueError(
            f"{name} must be positive and finite, one number or {len(own)}, got {values.tolist()}"
        )
    return np.broadcast_to(values, own.shape).copy()


@cache
def _sliders(n: int) -> MultibodyPlant:
    """A plant of n joints, which is all that Toppra asks of it for limits of joints."""
    plant = MultibodyPlant(0.0)
    for i in range(n):
        body = plant.AddRigidBody(f"body{i}", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
        plant.AddJoint(
            PrismaticJoint(f"joint{i}", plant.world_frame(), body.body_frame(), [1.0, 0.0, 0.0])
        )
    plant.Finalize()
    return plant
