"""Section 2.7's supervision at the output of Drake's differential IK."""

from fikm_drake.experiments.benchmarks.supervise_benchmark import supervise_benchmark
from fikm_drake.experiments.reproduce.report import Cell, Section

POSES = 5
CALMER = 50.0
"""By how much the joint speed at the far pose must fall."""
HARM = 1.01
"""How much larger the error on the path may be."""


def supervise() -> Section:
    """Chatter out of reach, tracking and reaching of Drake's controller, as it is and supervised."""
    results = supervise_benchmark(poses=POSES)
    cells = []
    for before, after in zip(results[::2], results[1::2]):
        cells += [
            Cell(
                f"{before.arm}, out of reach [rad/s rms]",
                before.unrest,
                after.unrest,
                after.unrest * CALMER <= before.unrest,
            ),
            Cell(
                f"{before.arm}, reversals a second",
                before.reversals,
                after.reversals,
                after.reversals == 0,
            ),
            Cell(
                f"{before.arm}, e_max of a path [mm]",
                1e3 * before.e_max,
                1e3 * after.e_max,
                after.e_max <= HARM * before.e_max,
            ),
            Cell(
                f"{before.arm}, e_mean of a path [mm]",
                1e3 * before.e_mean,
                1e3 * after.e_mean,
                after.e_mean <= HARM * before.e_mean,
            ),
            Cell(
                f"{before.arm}, poses reached of {POSES}",
                before.reached,
                after.reached,
                after.reached >= before.reached,
            ),
        ]
    return Section(
        "supervise",
        "Drake's differential IK, supervised",
        cells,
        notes=[
            "The column `paper` is Drake's own controller; more by `fikm-drake benchmark supervise`."
        ],
    )
