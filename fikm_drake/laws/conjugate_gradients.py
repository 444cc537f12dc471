"""Conjugate gradients for damped least squares, vectorised over leading axes."""

import numpy as np

from fikm_drake.arrays import Array

TINY = 1e-200
"""Squares below this are zero: their quotients would be noise or infinite."""


def conjugate_gradients(S: Array, b: Array, iterations: int, damping: Array | float = 0.0) -> Array:
    """Minimise |S x − b|² + damping² |x|² by `iterations` steps of conjugate gradients from x = 0.

    Each step is the best in the Krylov space so far: m steps, the number of rows, reach the
    minimum in exact arithmetic, fewer give a regularised solution.

    Args:
        S: (…,m,n).
        b: (…,m).
        iterations: at least 1.
        damping: in the unit of S, one or (…,1); dimensionless for a scaled Jacobian, whose norm is at
            most 1.

    Returns:
        x, (…,n); zeros where the gradient Sᵀ b is zero.
    """
    ST = np.swapaxes(S, -1, -2)
    damping = np.square(damping)
    residual = b
    gradient = _apply(ST, b)
    x = np.zeros_like(gradient)
    direction = gradient
    size = _dot(gradient, gradient)
    for k in range(iterations):
        image = _apply(S, direction)
        curvature = _dot(image, image) + damping * _dot(direction, direction)
        # A gradient of rounding errors only leaves a curvature of zero: the minimum is reached.
        # The least along the direction; |gradient|² is the same until the rounding errors are alone.
        slope = _dot(gradient, direction)
        step = np.divide(slope, curvature, out=np.zeros_like(size), where=curvature > TINY)
        x = x + step * direction
        if k + 1 == iterations:
            break
        residual = residual - step * image
        gradient = _apply(ST, residual) - damping * x
        before, size = size, _dot(gradient, gradient)
        ratio = np.divide(size, before, out=np.zeros_like(size), where=before > TINY)
        direction = gradient + ratio * direction
    return x


def conjugate_gradients_of_one(S: Array, b: Array, iterations: int, damping: float) -> Array:
    """The same for one S (m,n) and one b (m,), in a third of the time."""
    damping *= damping
    residual, gradient = b, b.dot(S)
    x, direction, size = np.zeros(len(gradient)), gradient, gradient.dot(gradient)
    for _ in range(iterations):
        image = S.dot(direction)
        curvature = image.dot(image) + damping * direction.dot(direction)
        if not curvature > TINY:
            break
        step = gradient.dot(direction) / curvature
        x += step * direction
        residual = residual - step * image
        gradient = residual.dot(S) - damping * x
        before, size = size, gradient.dot(gradient)
        direction = gradient + (size / before if before > TINY else 0.0) * direction
    return x


def _apply(A: Array, x: Array) -> Array:
    return (A @ x[..., None])[..., 0]


def _dot(x: Array, y: Array) -> Array:
    """Scalar products along the last axis, which is kept with length 1."""
    return np.einsum("...i,...i->...", x, y)[..., None]
