"""Two trees of postures that grow toward each other (RRT-Connect, Kuffner & LaValle 2000)."""

import numpy as np

from fikm_drake.arrays import Array

NODES = 96
"""Postures of a tree [-]."""
STEP = 0.6
"""Longest leg of a tree by its fastest joint [units of the joints]."""
LOCAL, SPREAD = 0.6, 0.4
"""This fraction of the samples is about a posture of the trees, each joint by this deviation [-, units]."""
UNITS = 4.0
"""A joint's unit is 1 rad or 1 m, but at most its range over this [-]."""
SAMPLES = 512
"""Random numbers of as many samples; then they come again [-]."""
START, GOAL = 0, 1
"""The tree that grows from where the joints are, and the one from where they may go, with several roots."""


class JointTrees:
    """The trees, where they may grow next, and the way through them.

    Samples are the same each time. Most of them are about a posture that a tree has, so that trees come
    out of narrow places; the others are anywhere within half a turn of the start and the limits.

    What they remember is a record that the caller keeps, with `fields`.

    Args:
        lower: lower joint limits (n,) [rad or m]; −inf for none.
        upper: upper joint limits (n,) [rad or m]; inf for none.
    """

    def __init__(self, lower: Array, upper: Array) -> None:
        n = len(lower)
        self._lower, self._upper = lower, upper
        self._units = np.minimum(1.0, (upper - lower) / UNITS)
        self._units[self._units == 0.0] = 1.0
        rng = np.random.default_rng(0)
        self._uniform = rng.random((SAMPLES, n + 2))
        self._normal = rng.normal(0.0, SPREAD, (SAMPLES, n)) * self._units
        self.fields: list[tuple] = [
            ("sizes", "f8", (2,)),
            ("parents", "f8", (2, NODES)),  # −1: a root
            ("nodes", "f8", (2, NODES, n)),
        ]

    def add(self, memory: np.void, tree: int, q: Array, parent: int = -1) -> int:
        """Add a posture (n,) to a tree that is not full, and tell its number."""
        node = int(memory["sizes"][tree])
        memory["nodes"][tree, node], memory["parents"][tree, node] = q, parent
        memory["sizes"][tree] = node + 1
        return node

    def full(self, memory: np.void) -> bool:
        """True if a tree is full."""
        return bool(memory["sizes"].max() >= NODES - 1)

    def cut(self, memory: np.void, goal: Array) -> None:
        """Leave the first root, and of those of the other tree one (n,)."""
        memory["sizes"] = 1.0, 0.0
        self.add(memory, GOAL, goal)

    def node(self, memory: np.void, tree: int, node: int) -> Array:
        """A posture (n,)."""
        q: Array = memory["nodes"][tree, node].copy()
        return q

    def nearest(self, memory: np.void, tree: int, q: Array) -> int:
        """The number of the posture nearest to q (n,)."""
        ways = (memory["nodes"][tree, : int(memory["sizes"][tree])] - q) / self._units
        return int(np.einsum("ij,ij->i", ways, ways).argmin())

    def toward(self, a: Array, b: Array) -> Array:
        """From a (n,) as far toward b (n,) as a leg goes; b itself if it is no farther."""
        size = float((np.abs(b - a) / self._units).max())
        return b if size <= STEP else a + (STEP / size) * (b - a)

    def sample(self, memory: np.void, number: int) -> Array:
        """A posture (n,) that a tree shall grow toward."""
        uniform, normal = self._uniform[number % SAMPLES], self._normal[number % SAMPLES]
        if uniform[0] < LOCAL:
            tree, place = divmod(2.0 * float(uniform[1]), 1.0)
            node = int(place * float(memory["sizes"][int(tree)]))
            q = memory["nodes"][int(tree), node] + normal
            return np.clip(q, self._lower, self._upper)
        start = memory["nodes"][START, 0]
        low, high = np.maximum(self._lower, start - np.pi), np.minimum(self._upper, start + np.pi)
        q = low + uniform[2:] * (high - low)
        return q

    def way(self, memory: np.void, nodes: tuple[int, int]) -> Array:
        """The postures (k,n) from the start to a root of the other tree, by a posture of each."""
        first, second = (self._up(memory, tree, node) for tree, node in enumerate(nodes))
        return np.array([*reversed(first), *second])

    def _up(self, memory: np.void, tree: int, node: int) -> list[Array]:
        """From a posture to its root."""
        postures = []
        while node >= 0:
            postures.append(memory["nodes"][tree, node])
            node = int(memory["parents"][tree, node])
        return postures
