"""What `fikm-drake benchmark` measures."""

from collections.abc import Callable
from dataclasses import dataclass

from fikm_drake.experiments.benchmarks import (
    anfis_benchmark,
    arms_benchmark,
    batch_benchmark,
    calm_benchmark,
    cycle_benchmark,
    feedback_benchmark,
    hard_benchmark,
    labvolt_benchmark,
    mamdani_benchmark,
    many_benchmark,
    obstacles_benchmark,
    pose_benchmark,
    rate_benchmark,
    self_motion_benchmark,
    single_benchmark,
    step_benchmark,
    supervise_benchmark,
)

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
    seeds: str = "nothing is random"
    """Of its random numbers."""


BENCHMARKS = {
    "step": Benchmark(
        "CPU time of a control step beside Drake's", "rounds", 20, step_benchmark.table
    ),
    "cycle": Benchmark(
        "CPU time of a law and of a cycle of differential IK", "rounds", 40, cycle_benchmark.table
    ),
    "feedback": Benchmark(
        "a path through an inner loop, beside Drake's integrator",
        "seconds",
        5,
        feedback_benchmark.table,
        "noise seeded by the time",
    ),
    "hard": Benchmark(
        "a line, a large step, targets out of reach, beside others",
        "seconds",
        10,
        hard_benchmark.table,
    ),
    "obstacles": Benchmark(
        "past obstacles, beside Drake's differential IK, and Pink where installed",
        "scenes",
        3,
        obstacles_benchmark.table,
        "seeds 0 and 1",
    ),
    "poses": Benchmark(
        "poses reached in the loop, calm out of reach", "poses", 60, pose_benchmark.table, "seed 0"
    ),
    "batch": Benchmark(
        "one pose and many, beside roboticstoolbox where installed",
        "rounds",
        3,
        batch_benchmark.table,
        "seeds 0, 1, 77, then 78, …",
    ),
    "many": Benchmark(
        "20,000 poses of an arm at once, a million, and the kinematics alone",
        "poses",
        20_000,
        many_benchmark.table,
        "seeds 0, 1, 77",
    ),
    "single": Benchmark(
        "one posture, one pose, poses at limits, the import",
        "rounds",
        20,
        single_benchmark.table,
        "seed 0",
    ),
    "arms": Benchmark(
        "public arms beside Drake's integrator, SNOPT, and Pink where installed",
        "targets",
        20,
        arms_benchmark.table,
        "seed 7",
    ),
    "calm": Benchmark(
        "what the calm costs where a target can be followed, and what it is for",
        "runs",
        150,
        calm_benchmark.table,
        "seed 0",
    ),
    "supervise": Benchmark(
        "Drake's differential IK, as it is and supervised",
        "poses",
        20,
        supervise_benchmark.table,
        "seed 0",
    ),
    "frmrc": Benchmark(
        "fuzzy rate control beside the pseudo-inverse, in batch",
        "rounds",
        10,
        rate_benchmark.table,
        "seed 0",
    ),
    "labvolt": Benchmark(
        "LabVolt 5250: SQP, Drake's IK, closed form", "rounds", 5, labvolt_benchmark.table, "seed 0"
    ),
    "mamdani": Benchmark(
        "Mamdani inference, beside scikit-fuzzy where installed",
        "rounds",
        10,
        mamdani_benchmark.table,
        "seed 0",
    ),
    "anfis": Benchmark(
        "training and bounds, beside anfis-toolbox where installed",
        "rounds",
        5,
        anfis_benchmark.table,
    ),
    "regions": Benchmark(
        "feasible regions: exactness and time a point",
        "points",
        5000,
        self_motion_benchmark.table,
        "seeds 2021 to 2023",
    ),
}
"""Benchmarks by name."""
