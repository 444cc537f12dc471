"""Paper 1, section 2.7: for which gains the loop is stable, on random arms."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.loop_stability import largest_stable_gain, loop_matrix, task_matrix
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

ARMS = 300
SMOOTHING = 2.0 / 3.0
"""Smoothing of equation 31."""
NEAR = 1e-3
"""How far below and above the bound the loop is tried, as a fraction of it."""


def random_arm(rng: np.random.Generator) -> DhArm:
    """An arm of 3 to 9 revolute joints with random twists, lengths and offsets."""
    rows = [_random_row(rng) for _ in range(rng.integers(4, 11))]
    joints = [DhJoint(*row) for row in rows[:-1]]
    return DhArm(DhTable(name="random", joints=joints, tool=DhTransform(*rows[-1])))


def random_task_matrices(arms: int, *, rows: int, seed: int = 0) -> list[Array]:
    """J C⁻¹ Jᵀ R⁻¹ (rows,rows) of random arms in random postures: 3 rows of position, or 6."""
    rng = np.random.default_rng(seed)
    law = FuzzyMapping()
    matrices = []
    for _ in range(arms):
        arm = random_arm(rng)
        J = arm.jacobian(rng.uniform(-np.pi, np.pi, arm.num_joints))
        matrices.append(task_matrix(law, J[-rows:]))
    return matrices


def stability() -> Section:
    """The bounds K < 2 without the filter and λK < 10 with it, against eigenvalues of the loop."""
    matrices = [A for rows in (3, 6) for A in random_task_matrices(ARMS, rows=rows)]
    largest = np.array([_largest_eigenvalue(A) for A in matrices])
    smallest = np.array([np.linalg.eigvals(A).real.min() for A in matrices])
    cells = [
        Cell("largest λ of all", "<= 1", float(largest.max()), bool(largest.max() < 1 + 1e-12)),
        Cell("smallest λ of all", ">= 0", float(smallest.min()), bool(smallest.min() > -1e-12)),
    ]
    for name, smoothing in (("without the filter", 0.0), ("with the filter", SMOOTHING)):
        bound = largest_stable_gain(smoothing)
        below, above = (
            np.array([_radius(A, x * bound / s, smoothing) for A, s in zip(matrices, largest)])
            for x in (1.0 - NEAR, 1.0 + NEAR)
        )
        stable = int((below <= 1.0 + 1e-12).sum())
        unstable = int((above > 1.0).sum())
        cells += [
            Cell(
                f"{name}, λK just below {bound:g}: stable",
                len(matrices),
                stable,
                stable == len(matrices),
            ),
            Cell(
                f"{name}, λK just above {bound:g}: unstable",
                len(matrices),
                unstable,
                unstable == len(matrices),
            ),
        ]
    return Section(
        "stability",
        f"bounds of the gain with a frozen Jacobian, {len(matrices)} random arms",
        cells,
        beside="theory",
        notes=[
            "3 to 9 joints, tasks of position and of pose.",
            "A direction that an arm cannot move, λ = 0, keeps its error and counts as stable.",
            "The derivation is in notebooks/stability.ipynb.",
        ],
    )


def _random_row(rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Twist [rad], length and offset [m], angle [rad]; right angles as often as not."""
    alpha = rng.choice([0.0, np.pi / 2, -np.pi / 2, rng.uniform(-np.pi, np.pi)])
    a, d = rng.uniform(0.0, 0.5, 2)
    return float(alpha), float(a), float(d), float(rng.uniform(-np.pi, np.pi))


def _largest_eigenvalue(A: Array) -> float:
    return float(np.linalg.eigvals(A).real.max())


def _radius(A: Array, gain: float, smoothing: float) -> float:
    return float(np.abs(np.linalg.eigvals(loop_matrix(A, gain, smoothing))).max())
