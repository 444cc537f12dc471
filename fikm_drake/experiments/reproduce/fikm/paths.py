"""The paths of paper 1. Its curves are lost but for their length and time: these are our own."""

from math import cos, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.simulation.scenario import Scenario, TrackingScenario


def curve_2_joints() -> Scenario:
    """Figures 13-15: 3.99 m in 6 s. r = 0.9 + 0.2 sin 3φ [m] about the base, from φ = 0."""
    return _around_base("planar2", [-0.522, 2.026], length=3.99, duration=6.0, wave=0.2, waves=3)


def curve_4_joints() -> Scenario:
    """Figures 16-18: 3.63 m in 3 s. r = 0.668 + 0.05 sin 3(φ − φ0) [m] about the base."""
    return _around_base(
        "planar4", [-0.9, -1.4, -1.4, 0.2], length=3.63, duration=3.0, wave=0.05, waves=3
    )


def complex_path_7_joints() -> Scenario:
    """Figures 19, 20: 5.28 m in 12.6 s. An upright five-pointed star, drawn twice: ten sharp turns."""
    angles = [pi / 2 + 4 * pi / 5 * k for k in range(11)]
    return _from_start(
        "arm7",
        [-0.4, 0.5, -0.4, 0.5, 0.1, 0.9, 0.6],
        np.array([[0.0, cos(a), sin(a)] for a in angles]),
        length=5.28,
        duration=12.6,
    )


def curve_7_joints() -> Scenario:
    """Figures 21, 22: 31.55 cm in 4 s. A rising wave: (u, 0.3 sin 2πu, 0.3 u²), scaled."""
    u = np.linspace(0.0, 1.0, 101)
    shape = np.stack([u, 0.3 * np.sin(2 * pi * u), 0.3 * u**2], axis=1)
    return _from_start(
        "arm7", [-0.4, 0.5, -0.4, 0.5, 0.1, 0.9, 0.6], shape, length=0.3155, duration=4.0
    )


def path_length(points: ArrayLike) -> float:
    """Length of the polyline through points (k,m) [m]."""
    return float(np.linalg.norm(np.diff(np.asarray(points), axis=0), axis=1).sum())


def _from_start(
    arm: str, q: list[float], shape: Array, *, length: float, duration: float
) -> Scenario:
    """`shape` scaled to `length`, its first point at the tool at q."""
    start = load_arm(arm).forward_kinematics(q)[: shape.shape[1], 3]
    points = start + (shape - shape[0]) * length / path_length(shape)
    return TrackingScenario(arm, points.tolist(), duration=duration, initial_position=q)


def _around_base(
    arm: str, q: list[float], *, length: float, duration: float, wave: float, waves: int
) -> Scenario:
    """A wavy arc about the base from the tool at q, as far round as its length takes it."""
    x, y = load_arm(arm).forward_kinematics(q)[:2, 3]
    radius, start = np.hypot(x, y), np.arctan2(y, x)

    def points(sweep: float) -> Array:
        angle = np.linspace(0.0, sweep, 201)
        r = radius + wave * np.sin(waves * angle)
        return np.stack([r * np.cos(start + angle), r * np.sin(start + angle)], axis=1)

    low, high = 0.0, 4 * pi
    for _ in range(60):  # bisection: the length grows with the sweep
        middle = (low + high) / 2
        low, high = (middle, high) if path_length(points(middle)) < length else (low, middle)
    return TrackingScenario(arm, points(high).tolist(), duration=duration, initial_position=q)
