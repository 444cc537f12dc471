"""Shapes of memberships as data: triangle, trapezoid, Gaussian."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from math import nan

import numpy as np
from numpy.typing import ArrayLike

from fikm_drake.arrays import Array
from fikm_drake.checks import check_finite


@dataclass
class _Shape:
    """What the shapes share: finite numbers, in the unit of the variable."""

    def __post_init__(self) -> None:
        if any(value == value for value in astuple(self)):  # else a blank that YAML fills in
            self.validate()

    def validate(self) -> None:
        """Raise ValueError, naming the bad number, unless all are finite."""
        for field in fields(self):
            name = f"{type(self).__name__}: {field.name}"
            setattr(self, field.name, check_finite(name, getattr(self, field.name)))


class _Cornered(_Shape):
    """A trapezoid or what is one with corners in one place."""

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Left, top left, top right, right."""
        raise NotImplementedError

    @property
    def core(self) -> tuple[float, float]:
        """Where the grade is one: from, to."""
        return self.corners[1], self.corners[2]

    @property
    def support(self) -> tuple[float, float]:
        """Where the grade is not zero: from, to."""
        return self.corners[0], self.corners[3]

    def validate(self) -> None:
        """Raise ValueError, naming the bad numbers, unless the corners are in order."""
        super().validate()
        left, top_left, top_right, right = self.corners
        if not (left <= top_left <= top_right <= right and left < right):
            raise ValueError(f"{type(self).__name__}: corners must increase, got {astuple(self)}")

    def __call__(self, x: ArrayLike) -> Array:
        """Grades in [0, 1] of values of any shape; NaN where a value is NaN."""
        return trapezoid_grades(np.asarray(x, dtype=float)[None], trapezoid_edges(self.corners))[0]


@dataclass
class Triangle(_Cornered):
    """Zero up to `left`, one at `peak`, zero from `right`, linear between.

    The peak may be in the place of one end; the edge there is vertical.

    Raises:
        ValueError: the corners are not finite or not in order, or all are in one place.
    """

    left: float = nan
    """Where it begins to rise."""
    peak: float = nan
    """Where the grade is one."""
    right: float = nan
    """Where it has fallen to zero."""

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Those of the trapezoid that it is: the top is one point."""
        return self.left, self.peak, self.peak, self.right


@dataclass
class Trapezoid(_Cornered):
    """Zero up to `left`, one from `top_left` to `top_right`, zero from `right`, linear between.

    Two corners in one place make a vertical edge; there the grade is one.

    Raises:
        ValueError: the corners are not finite or not in order, or all are in one place.
    """

    left: float = nan
    """Where it begins to rise."""
    top_left: float = nan
    """Where the top begins."""
    top_right: float = nan
    """Where the top ends."""
    right: float = nan
    """Where it has fallen to zero."""

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Left, top left, top right, right."""
        return self.left, self.top_left, self.top_right, self.right


@dataclass
class Gaussian(_Shape):
    """exp(-½ ((x - mean) / sigma)²), nowhere zero: a rule about it fires a little everywhere.

    Raises:
        ValueError: a number is not finite, or sigma is not positive.
    """

    mean: float = nan
    """Where the grade is one."""
    sigma: float = nan
    """Standard deviation: at this distance from the mean the grade is 0.607."""

    @property
    def core(self) -> tuple[float, float]:
        """Where the grade is one: from, to."""
        return self.mean, self.mean

    @property
    def support(self) -> tuple[float, float]:
        """Where the grade is over 1.5e-8: from, to."""
        return self.mean - 6.0 * self.sigma, self.mean + 6.0 * self.sigma

    def validate(self) -> None:
        """Raise ValueError, naming the bad number, unless sigma is positive."""
        super().validate()
        if not self.sigma > 0.0:
            raise ValueError(f"Gaussian: sigma must be positive, got {self.sigma!r}")

    def __call__(self, x: ArrayLike) -> Array:
        """Grades in [0, 1] of values of any shape; NaN where a value is NaN."""
        return gaussian_grades(np.asarray(x, dtype=float), np.array([self.mean, self.sigma]))


Membership = Triangle | Trapezoid | Gaussian
"""A shape; in YAML `!Triangle` (which may be left out), `!Trapezoid` or `!Gaussian`."""


def trapezoid_edges(corners: ArrayLike) -> Array:
    """Edges of trapezoids: left end, width of the rise, right end, width of the fall.

    A vertical edge becomes a slope as wide as the spacing of doubles, so that it needs no case of
    its own; the grade is one where the edge was.

    Args:
        corners: shape (4, ...): left, top left, top right, right.

    Returns:
        Shape (4, ...), widths positive.
    """
    left, top_left, top_right, right = np.asarray(corners, dtype=float)
    spacing = np.spacing(np.maximum(np.abs(left), np.abs(right)))
    left = np.where(left == top_left, left - spacing, left)
    right = np.where(right == top_right, right + spacing, right)
    return np.stack([left, top_left - left, right, right - top_right])


def trapezoid_grades(x: Array, edges: Iterable[Array]) -> Array:
    """Grades of x by trapezoids with four `edges`, each of which x broadcasts with."""
    left, rise, right, fall = edges
    grades, falling = x - left, right - x
    grades /= rise
    falling /= fall
    np.minimum(grades, falling, out=grades)
    np.minimum(grades, 1.0, out=grades)
    return np.maximum(grades, 0.0, out=grades)


def gaussian_grades(x: Array, parameters: Iterable[Array]) -> Array:
    """Grades of x by Gaussians of mean and sigma, each of which x broadcasts with."""
    mean, sigma = parameters
    return np.exp(-0.5 * ((x - mean) / sigma) ** 2)
