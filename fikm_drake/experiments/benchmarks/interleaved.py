"""CPU times: of calls that take turns, so that a noisy machine disturbs them alike; of kinematics alone."""

import gc
import time
from collections.abc import Callable
from statistics import median
from typing import Any

from fikm_drake.arrays import Array
from fikm_drake.kinematics.dh_arm import DhArm

IN_CACHE = 512
"""Postures of a batch that the cache holds."""


def interleaved(
    calls: dict[str, Callable[[], Any]], *, rounds: int, repeats: int
) -> dict[str, list[float]]:
    """CPU time of a call of each [s], a number a round, undisturbed by the garbage collector.

    Args:
        calls: by name.
        rounds: how often they take turns.
        repeats: calls of each in a round.
    """
    costs: dict[str, list[float]] = {name: [] for name in calls}
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, call in calls.items():
                start = time.process_time()
                for _ in range(repeats):
                    call()
                costs[name].append((time.process_time() - start) / repeats)
    finally:
        gc.enable()
    return costs


def jacobian_time(arm: DhArm, q: Array) -> float:
    """CPU time of a Jacobian, with the forward kinematics that it needs, in a batch of postures (N,n) [s].

    No inverse kinematics can do with less a posture.
    """
    rows, times = q[:IN_CACHE], []
    for _ in range(20):
        start = time.process_time()
        for _ in range(10):
            arm.jacobian(rows)
        times.append((time.process_time() - start) / (10 * len(rows)))
    return median(times)
