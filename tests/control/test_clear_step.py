"""The step that keeps clear by the native kernel equals that of numpy."""

import ctypes
from typing import NamedTuple

import numpy as np
import pytest

from fikm_drake.control.clear_step import LOOKS, ClearStep
from fikm_drake.control.clearance_config import (
    ClearanceConfig,
    clearance_table,
    load_clearance_rules,
)
from fikm_drake.control.near_pairs import UNFELT, Near
from fikm_drake.kinematics.native.native_clearance import ClearFields

RATES = clearance_table(load_clearance_rules("clearance"))


class Found(NamedTuple):
    """What a checker says."""

    at: np.ndarray
    derivatives: np.ndarray

    def size(self):
        return len(self.at)

    def distances(self):
        return self.at

    def jacobians(self):
        return np.asfortranarray(self.derivatives)

    def near(self, columns):
        rows = self.derivatives[:, columns]
        felt = np.flatnonzero((rows**2).sum(axis=1) > UNFELT)
        return Near(self.at[felt], rows[felt], felt)


def case(rng, near_too_near):
    """A step among pairs, one of which the joints do not move, with ends that are looked at."""
    n, extra, k, m = rng.integers(4, 9), rng.integers(0, 3), rng.integers(0, 9), rng.integers(1, 7)
    columns = np.sort(rng.permutation(n + extra)[:n])
    low = -0.003 if near_too_near else 0.01

    def found(size):
        distances, rows = rng.uniform(low, 0.06, size), 0.3 * rng.normal(size=(size, n + extra))
        if size:
            rows[rng.integers(size), columns] = 0.0
        return Found(distances, rows)

    first, ends = found(k), [found(rng.integers(0, 4)) for _ in range(LOOKS)]
    step = rng.normal(size=n) * 10.0 ** rng.uniform(-4.0, -1.5)
    bounds = rng.choice(3)
    low, high = -rng.uniform(0.001, 0.05, n), rng.uniform(0.001, 0.05, n)
    low[0] = -np.inf
    return {
        "columns": columns,
        "positions": n + extra,
        "reach": rng.uniform(0.2, 1.0, n),
        "found": first,
        "ends": ends,
        "step": step,
        "J": rng.normal(size=(m, n)) if rng.random() < 0.8 else None,
        "low": low if bounds == 1 else None,
        "high": high if bounds == 1 else None,
        "bounds": (lambda: (low, high)) if bounds == 2 else None,
        "moved": rng.normal(size=k) * 1e-3 if rng.random() < 0.3 else None,
    }


def both(native_kernel, case):
    """Numpy's answer and the kernel's."""
    clear = ClearStep(ClearanceConfig(), 0.01, RATES, case["reach"])
    found, columns, moved = case["found"], case["columns"], case["moved"]
    near = found.near(columns)
    same = {name: case[name] for name in ("J", "low", "high", "bounds")}
    ends = iter(case["ends"])
    one = clear(
        case["step"],
        near,
        lambda step: next(ends).near(columns),
        moved=None if moved is None else moved[near.places],
        **same,
    )
    one = one._replace(row=int(near.places[one.row]) if one.row >= 0 else -1)
    ends = iter(case["ends"])
    native = clear.native(columns, case["positions"], native_kernel)
    two = native(
        case["step"],
        found,
        lambda step: next(ends),
        LOOKS,
        taken=-1,
        moved=moved,
        **same,
    )
    return one, two


@pytest.mark.parametrize("near_too_near", [False, True])
def test_equals_numpy(native_kernel, near_too_near):
    rng = np.random.default_rng(int(near_too_near))
    changed = 0
    for _ in range(600):
        one, two = both(native_kernel, drawn := case(rng, near_too_near))
        np.testing.assert_allclose(two.step, one.step, rtol=1e-9, atol=1e-12)
        assert two.distance == one.distance
        assert (two.blocked, two.row) == (one.blocked, one.row)
        changed += one.row >= 0 and np.abs(one.step - drawn["step"]).max() > 1e-6
    assert changed > 100


def test_the_fields_are_those_of_the_kernel(native_kernel):
    assert native_kernel.clear_size() == ctypes.sizeof(ClearFields)


def test_what_the_kernel_cannot_take_is_left_to_numpy(native_kernel):
    rng = np.random.default_rng(3)
    clear = ClearStep(ClearanceConfig(), 0.01, RATES, np.ones(4))
    assert clear.native(np.arange(4), 4, None) is None
    native = clear.native(np.arange(4), 4, native_kernel)
    rest = {"taken": -1, "low": None, "high": None, "bounds": None, "moved": None}

    def ask(count, rows, distance=0.02, padded=False):
        found = Found(np.full(count, distance), rng.normal(size=(count, 4)))
        J = rng.normal(size=(rows, 4))
        counted = native.take(found, padded)
        answer = native(np.full(4, 0.01), found, lambda _: found, LOOKS, J=J, **rest)
        return (counted, answer and answer.row)

    assert ask(97, 3) == (-1, None)  # too many pairs
    assert ask(3, 7) == (3, None)  # too many rows of a task
    assert ask(3, 3, distance=-1e-3, padded=True) == (-1, None)  # rows that Drake may have turned


def test_threads_do_not_share_buffers(native_kernel, in_threads):
    rng = np.random.default_rng(4)
    clear = ClearStep(ClearanceConfig(), 0.01, RATES, np.ones(7))
    native = clear.native(np.arange(7), 7, native_kernel)
    rest = {"taken": -1, "J": None, "low": None, "high": None, "bounds": None, "moved": None}
    cases = [
        (0.01 * rng.normal(size=7), Found(rng.uniform(0.02, 0.04, 5), rng.normal(size=(5, 7))))
        for _ in range(3)
    ]
    free = Found(np.zeros(0), np.zeros((0, 7)))

    def run(i):
        step, found = cases[i]
        first = native(step, found, lambda _: free, LOOKS, **rest).step
        for _ in range(300):
            again = native(step, found, lambda _: free, LOOKS, **rest).step
            np.testing.assert_array_equal(again, first)

    in_threads(run)
