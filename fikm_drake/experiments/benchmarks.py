"""What `fikm-drake benchmark` measures."""

from collections.abc import Callable
from dataclasses import dataclass

from fikm_drake.experiments import batch_benchmark, pose_benchmark, step_benchmark
from fikm_drake.experiments.anfis import anfis_benchmark, regions_benchmark

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Benchmark:
    """One benchmark."""

    help: str
    """One line."""
    count: str
    """What its one option counts, such as `rounds`."""
    default: int
    """How many by default."""
    table: Callable[[int, Progress], str]
    """Runs it: the count and a callback for progress to the text of its table."""


BENCHMARKS = {
    "step": Benchmark(
        "CPU time of a control step beside Drake's", "rounds", 20, step_benchmark.table
    ),
    "poses": Benchmark(
        "poses reached in the loop, calm out of reach", "poses", 60, pose_benchmark.table
    ),
    "batch": Benchmark(
        "poses in batch, beside roboticstoolbox where installed", "rounds", 5, batch_benchmark.table
    ),
    "anfis": Benchmark(
        "training and bounds, beside anfis-toolbox where installed",
        "rounds",
        5,
        anfis_benchmark.table,
    ),
    "regions": Benchmark(
        "feasible regions: exactness and time a point", "points", 5000, regions_benchmark.table
    ),
}
"""Benchmarks by name."""
