"""The nearest vector that keeps inequalities, row by row.

Kaczmarz's method for equations walks from row to row and moves onto each; for inequalities (Hildreth's
method) a row is moved onto only while it is violated, and let go once it pulls. Here the rows that push
at the same time are solved together, which ends after as many steps as there are such rows.

What is near is a matter of the metric. In that of `task_metric` a motion that the task feels is dear and one
that it leaves free is cheap: a redundant arm gives way with its elbow and not with its tool.
"""

import numpy as np

from fikm_drake.arrays import Array

ROUNDS = 24
"""Rows that are taken up at most, one a round [-]."""
SOFT = 1e-7
"""Rows whose squares differ by less than this fraction count as one, so that duplicates do no harm [-]."""
TINY = 1e-12
"""Rows shorter than this fraction of the longest one say nothing [-]."""
FREE = 0.05
"""What a motion that the task leaves free costs, over the mean square of the rows of the Jacobian [-]."""


def project(
    step: Array,
    rows: Array,
    bounds: Array,
    tolerance: float = 0.0,
    metric: Array | None = None,
) -> tuple[Array, Array]:
    """The vector nearest to `step` that keeps rows · x ≥ bounds, and how each row pushes.

    The work is bounded: rows that contradict one another leave a compromise, so look at what is kept.

    Args:
        step: (n,).
        rows: (k,n), finite.
        bounds: (k,); −inf for a row that does not count.
        tolerance: a row that is violated by less is kept, in the unit of the bounds.
        metric: M (n,n), symmetric and positive: near is what has a small (x − step)ᵀ M⁻¹ (x − step); None: I.

    Returns:
        x (n,), equal to `step` where that keeps all rows; multipliers μ ≥ 0 (k,), zero for rows that
        do not push: x = step + M rowsᵀ μ.
    """
    multipliers = np.zeros(len(bounds))
    asked = rows.dot(step) - bounds
    if not len(bounds) or asked.min() >= -tolerance:
        return step, multipliers
    ways = rows if metric is None else rows.dot(metric)
    sizes = np.sqrt(np.einsum("ij,ij->i", rows, ways))
    sizes[sizes <= TINY * sizes.max()] = np.inf
    tolerance = max(tolerance, 1e-12 * float(np.abs(asked).max()))
    x, active, pushes = step, [], np.zeros(0)
    slack = asked
    for _ in range(ROUNDS):
        depth = (slack + tolerance) / sizes
        worst = int(depth.argmin())
        if depth[worst] >= 0.0 or worst in active:
            break
        active.append(worst)
        active, pushes = _solve(active, rows, ways, asked)
        x = step + pushes.dot(ways[active])
        slack = rows.dot(x) - bounds
    multipliers[active] = pushes
    return x, multipliers


def _solve(active: list[int], rows: Array, ways: Array, asked: Array) -> tuple[list[int], Array]:
    """The active rows that push, and their multipliers, so that their slack is zero."""
    while True:
        gram = rows[active].dot(ways[active].T)
        soft = gram.copy()
        soft.flat[:: len(active) + 1] *= 1.0 + SOFT
        pushes = np.linalg.solve(soft, -asked[active])
        pushes += np.linalg.solve(soft, -asked[active] - gram.dot(pushes))  # what softness took
        least = int(pushes.argmin())
        if pushes[least] >= 0.0:
            return active, pushes
        active = active[:least] + active[least + 1 :]


def task_metric(J: Array) -> Array:
    """M (n,n) of `project`: M⁻¹ = I + Jᵀ J / λ, λ being `FREE` of the mean square of J's rows (m,n)."""
    square = J.dot(J.T)
    m = len(square)
    square.flat[:: m + 1] += FREE * max(float(np.trace(square)), 1e-300) / m
    return np.eye(J.shape[1]) - J.T.dot(np.linalg.solve(square, J))


def shortened(step: Array, low: Array | None, high: Array | None) -> Array:
    """The step, shortened as a whole to the larger of what each joint may do to the two sides.

    That is its speed; a limit of position that is ahead is left to the rows of `with_box`.
    """
    if low is None or high is None:
        return step
    most = np.maximum(np.abs(low), np.abs(high))
    moves = most > 0.0
    excess = float((np.abs(step[moves]) / most[moves]).max(initial=0.0))
    return step / excess if excess > 1.0 else step


def with_box(
    rows: Array, bounds: Array, low: Array | None, high: Array | None
) -> tuple[Array, Array]:
    """The rows and bounds with those of each joint's own step, where it is bounded."""
    for sign, limit in ((1.0, low), (-1.0, high)):
        if limit is not None:
            finite = np.isfinite(limit)
            rows = np.vstack([rows, sign * np.eye(len(limit))[finite]])
            bounds = np.concatenate([bounds, sign * limit[finite]])
    return rows, bounds


def kept(step: Array, rows: Array, bounds: Array, tolerance: float) -> Array:
    """The step, shortened where rows that rest would keep are not kept."""
    change = rows.dot(step)
    broken = (bounds <= 0.0) & (change < bounds - 2.0 * tolerance)
    if not broken.any():
        return step
    return step * float((bounds[broken] / change[broken]).min())
