"""Past paper 1: pseudo-inverse accuracy, calm where nothing can be reached, the dead point."""

import dataclasses

import numpy as np

from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.simulation.simulate import simulate
from fikm_drake.simulation.tracking_log import TrackingLog
from fikm_drake.simulation.tracking_scenario import TrackingScenario, load_scenario
from fikm_drake.systems.fuzzy_ik_config import FuzzyIkConfig

LINES = {"10": 0.002, "5": 0.006, "2": 0.04}
"""Table VI's lines by their seconds, and the largest error that three iterations may have [cm]."""
OUT_OF_REACH = {"planar4": ([0.0, 2.0], 500.0), "arm7": ([2.0, 0.0, 0.0], 1000.0)}
"""Targets by arm, and their distance from its reach [mm]."""
SETTLED = 300
"""Cycles after which an arm must rest."""
HOLD = 9.0
"""[s]"""


def past() -> Section:
    """Three iterations on the lines; the default where targets are out of reach or at a dead point."""
    cells = []
    sharp = FuzzyIkConfig.resolved_rate(iterations=3)
    for seconds, most in LINES.items():
        log = simulate(dataclasses.replace(load_scenario(f"table6_{seconds}s"), config=sharp))
        error = 100.0 * log.metrics().e_max
        cells.append(_at_most(f"3 iterations, line in {seconds} s: e_max [cm]", error, most))
    largest = 0.0
    for arm, (target, optimum) in OUT_OF_REACH.items():
        log = simulate(TrackingScenario(arm=arm, waypoints=[target], hold=HOLD))
        largest = max(largest, float(np.abs(log.joint_step).max()))
        motion = float(np.abs(log.joint_step[SETTLED:]).max())
        beyond = 1000.0 * log.metrics().e_ss - optimum
        cells.append(_at_most(f"{arm}, out of reach: error over the least [mm]", beyond, 1.0))
        cells.append(_at_most(f"{arm}, after {SETTLED} cycles: joint step [rad]", motion, 1e-4))
    log = simulate(TrackingScenario(arm="planar2", waypoints=[[1.0, 0.0]], hold=2.0))
    largest = max(largest, float(np.abs(log.joint_step).max()))
    cells.append(_at_most("dead point: under 1 mm for good after [s]", _settled(log), 2.0))
    cells.append(_at_most("largest joint step of a cycle in these [rad]", largest, 0.5))
    return Section(
        "past",
        "past the paper: accuracy, calm, the dead point",
        cells,
        notes=[
            "Lines without gain and filters, `FuzzyIkConfig.resolved_rate(iterations=3)`; all else with",
            "the default. Dead point: the stretched 2-joint arm, (1.5, 0) to (1, 0), where Jᵀ dr = 0.",
        ],
    )


def _at_most(label: str, ours: float, bound: float) -> Cell:
    return Cell(f"{label}, at most {bound:g}", None, ours, reached=ours <= bound)


def _settled(log: TrackingLog) -> float:
    """Time from which the error stays under 1 mm [s]."""
    late = np.flatnonzero(np.linalg.norm(log.error, axis=1) >= 1e-3)
    return (late[-1] + 1) / log.scenario.control_rate if late.size else 0.0
