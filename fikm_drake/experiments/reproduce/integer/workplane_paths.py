"""The paths of figures 7-12, as points of the workplane [mm]."""

import numpy as np

from fikm_drake.arrays import Array

CORNERS = [(0, 0), (400, 0), (400, 300), (0, 300), (0, 0)]
"""Of the rectangle of 400 mm x 300 mm."""
CENTRE, RADIUS = (200, 150), 150
"""Of the circle: the largest inside the rectangle; the paper gives neither."""
STEP = 5.0
"""Between neighbouring points of the rectangle and of the line [mm]."""


def rectangle() -> Array:
    """Figures 7 and 8: the edges of the workplane's rectangle every 5 mm (k,2)."""
    sides = [line(start, end)[:-1] for start, end in zip(CORNERS, CORNERS[1:])]
    return np.concatenate([*sides, np.array(CORNERS[:1], dtype=float)])


def circle() -> Array:
    """Figures 9 and 10: a circle every 1° (361,2)."""
    angle = np.deg2rad(np.arange(361))
    return CENTRE + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def inclined_line() -> Array:
    """Figures 11 and 12: from the near left corner to the far right one every 5 mm (k,2)."""
    return line(CORNERS[0], CORNERS[2])


def line(start: tuple[float, float], end: tuple[float, float]) -> Array:
    """Points every 5 mm from start to end, both included (k,2)."""
    steps = round(float(np.hypot(end[0] - start[0], end[1] - start[1])) / STEP)
    return np.linspace(start, end, steps + 1)
