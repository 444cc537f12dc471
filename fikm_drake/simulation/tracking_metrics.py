"""How well a run followed its path."""

from dataclasses import dataclass

import numpy as np

from fikm_drake.arrays import Array


@dataclass(frozen=True)
class TrackingMetrics:
    """Errors of a run [m]; `e_…` are to the target of the moment, `path_…` to the path itself."""

    e_max: float
    """Largest error over path and hold [m]."""
    e_mean: float
    """Mean error over path and hold [m]."""
    e_ss: float
    """Error after the last cycle [m]."""
    path_max: float
    """Largest distance from the path [m]."""
    path_mean: float
    """Mean distance from the path [m]."""
    turn_max: float | None = None
    """Largest angle to the target's orientation [rad]; None: it does not count."""
    turn_mean: float | None = None
    """Mean angle to the target's orientation [rad]."""
    turn_ss: float | None = None
    """Angle to the target's orientation after the last cycle [rad]."""
    clearance: float | None = None
    """Least distance of the robot to anything [m]; None: nothing stands about it."""

    def __str__(self) -> str:
        turns = (
            ""
            if self.turn_max is None or self.turn_mean is None or self.turn_ss is None
            else f", turned off by max {np.rad2deg(self.turn_max):.3f}°, mean "
            f"{np.rad2deg(self.turn_mean):.3f}°, at the end {np.rad2deg(self.turn_ss):.4f}°"
        )
        clear = "" if self.clearance is None else f", clearance {1000 * self.clearance:.1f} mm"
        return (
            f"e_max {100 * self.e_max:.3f} cm, e_mean {100 * self.e_mean:.3f} cm, "
            f"e_ss {100 * self.e_ss:.4f} cm, distance from the path max "
            f"{100 * self.path_max:.3f} cm, mean {100 * self.path_mean:.3f} cm{turns}{clear}"
        )


def tracking_metrics(
    error: Array, actual: Array, waypoints: Array, *, clearance: float | None = None
) -> TrackingMetrics:
    """Metrics of a run.

    Args:
        error: desired minus actual after each cycle (N,m) [m], or (N,6) [rad; m].
        actual: tool positions after each cycle (N,m) [m], or poses (N,7), the position last.
        waypoints: corners of the path (k,m) [m].
        clearance: least distance of the robot to anything [m].
    """
    turns = {}
    if error.shape[1] == 6:
        angle = np.linalg.norm(error[:, :3], axis=1)
        error, actual = error[:, 3:], actual[:, 4:]
        turns = {
            "turn_max": float(angle.max()),
            "turn_mean": float(angle.mean()),
            "turn_ss": float(angle[-1]),
        }
    length = np.linalg.norm(error, axis=1)
    distance = distance_from_path(actual, waypoints)
    return TrackingMetrics(
        e_max=float(length.max()),
        e_mean=float(length.mean()),
        e_ss=float(length[-1]),
        path_max=float(distance.max()),
        path_mean=float(distance.mean()),
        clearance=clearance,
        **turns,
    )


def distance_from_path(points: Array, waypoints: Array) -> Array:
    """Distance (N,) of points (N,m) from the polyline through waypoints (k,m)."""
    if len(waypoints) == 1:
        return np.linalg.norm(points - waypoints[0], axis=1)
    starts, edges = waypoints[:-1], np.diff(waypoints, axis=0)
    squared = np.maximum((edges**2).sum(-1), np.finfo(float).tiny)
    offsets = points[:, None, :] - starts
    along = np.clip((offsets * edges).sum(-1) / squared, 0.0, 1.0)
    return np.linalg.norm(offsets - along[..., None] * edges, axis=-1).min(axis=1)
