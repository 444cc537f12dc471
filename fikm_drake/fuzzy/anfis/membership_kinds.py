"""Shapes of memberships with parameters that can be learned."""

from typing import Protocol

import numpy as np

from fikm_drake.arrays import Array


class MembershipKind(Protocol):
    """A shape of membership, vectorised over m memberships and N values of one scaled input.

    Only logarithms of grades are computed: a grade far from every center underflows, its share of
    all grades does not. Parameters that must be positive are stored as their logarithms.
    """

    names: tuple[str, ...]
    """Names of the p parameters, as a reader knows them."""

    def start(self, count: int) -> Array:
        """Parameters (p,m) that divide [−1, 1] evenly; neighbours cross at a grade of one half."""

    def log_grades(self, x: Array, parameters: Array) -> Array:
        """Logarithms of the grades (m,N) of the values x (N,)."""

    def log_slopes(self, x: Array, parameters: Array) -> Array:
        """Derivatives (p,m,N) of `log_grades` by the parameters."""


class Gaussian:
    """Grade exp(−½ ((x − c) / σ)²), equation 4.2 of Hassantabar (2021)."""

    names: tuple[str, ...] = ("center", "width")

    def start(self, count: int) -> Array:
        """See `MembershipKind`."""
        centers, half_spacing = _spread(count)
        width = half_spacing / np.sqrt(2.0 * np.log(2.0))
        return np.array([centers, np.full(count, np.log(width))])

    def log_grades(self, x: Array, parameters: Array) -> Array:
        """See `MembershipKind`."""
        z = self._distance(x, parameters)
        return -0.5 * z * z

    def log_slopes(self, x: Array, parameters: Array) -> Array:
        """See `MembershipKind`."""
        z = self._distance(x, parameters)
        return np.array([z * np.exp(-parameters[1])[:, None], z * z])

    @staticmethod
    def _distance(x: Array, parameters: Array) -> Array:
        centers, log_widths = parameters[:, :, None]
        return (x - centers) * np.exp(-log_widths)


class Bell:
    """Grade 1 / (1 + |(x − c) / a|^(2b)), Jang's generalised bell."""

    names: tuple[str, ...] = ("center", "width", "slope")

    def start(self, count: int) -> Array:
        """See `MembershipKind`."""
        centers, half_spacing = _spread(count)
        return np.array(
            [centers, np.full(count, np.log(half_spacing)), np.full(count, np.log(2.0))]
        )

    def log_grades(self, x: Array, parameters: Array) -> Array:
        """See `MembershipKind`."""
        return -np.logaddexp(0.0, self._log_power(x, parameters))

    def log_slopes(self, x: Array, parameters: Array) -> Array:
        """See `MembershipKind`."""
        log_power = self._log_power(x, parameters)
        share = 2.0 * np.exp(parameters[2])[:, None] * np.exp(-np.logaddexp(0.0, -log_power))
        away = x - parameters[0][:, None]
        center = np.divide(share, away, out=np.zeros_like(away), where=away != 0.0)
        return np.array([center, share, -share * self._log_distance(x, parameters)])

    def _log_power(self, x: Array, parameters: Array) -> Array:
        return 2.0 * np.exp(parameters[2])[:, None] * self._log_distance(x, parameters)

    @staticmethod
    def _log_distance(x: Array, parameters: Array) -> Array:
        """Log |(x − c) / a|, held above that of the smallest double, so that it is finite at c."""
        centers, log_widths, _ = parameters[:, :, None]
        return np.log(np.maximum(np.abs(x - centers), np.finfo(float).tiny)) - log_widths


KINDS: dict[str, MembershipKind] = {"gaussian": Gaussian(), "bell": Bell()}
"""Kinds of memberships by name."""


def _spread(count: int) -> tuple[Array, float]:
    """Evenly spaced centers on [−1, 1] and half their spacing."""
    if count == 1:
        return np.zeros(1), 1.0
    return np.linspace(-1.0, 1.0, count), 1.0 / (count - 1)
