"""CPU times of calls that take turns, so that a noisy machine disturbs them alike."""

import gc
import time
from collections.abc import Callable
from typing import Any


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
