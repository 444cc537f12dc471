"""Paper 1, section 5: its claims in words, checked and told as they are."""

import numpy as np

from fikm_drake.experiments.reproduce.conventions import both
from fikm_drake.experiments.reproduce.fikm import paths
from fikm_drake.experiments.reproduce.fikm.costs import saving_cells
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import Scenario, load_scenario
from fikm_drake.simulation.simulate import simulate

PRINTED = "279, 179 by its cells"
"""The growth that the text states, and the one of its Table VI: 3.07 over 1.10."""
SETTLED = 0.01
"""What we call zero after one second of hold [cm]."""


def scenarios() -> dict[str, Scenario]:
    """The paths of section 4.4."""
    return {
        "2 joints, curve": paths.curve_2_joints(),
        "4 joints, curve": paths.curve_4_joints(),
        "7 joints, star": paths.complex_path_7_joints(),
        "7 joints, curve": paths.curve_7_joints(),
        **{f"7 joints, line in {t} s": load_scenario(f"table6_{t}s") for t in (10, 5, 2)},
    }


def claims() -> Section:
    """Section 5: steady state, error against speed, smooth joints, distal joints, the 2.5 times."""
    logs = {
        name: simulate(scenario.but(target__hold=1.0)) for name, scenario in scenarios().items()
    }
    cells = []
    for name, log in logs.items():
        e_ss = 100 * log.metrics().e_ss
        cells.append(Cell(f"{name}: error 1 s after the end [cm]", "0", e_ss, e_ss <= SETTLED))
    slow, fast = (both(logs[f"7 joints, line in {t} s"]) for t in (10, 2))
    means = [_growth(a.e_mean, b.e_mean) for a, b in zip(slow, fast)]
    largest = [_growth(a.e_max, b.e_max) for a, b in zip(slow, fast)]
    cells += [
        Cell("line, 5 times the speed: e_mean grows by [%]", 78, means[0], before=means[1]),
        Cell("line, 5 times the speed: e_max grows by [%]", PRINTED, largest[0], before=largest[1]),
    ]
    for name, log in logs.items():
        text = " ".join(f"{x:.2f}" for x in _travel(log))
        cells.append(Cell(f"{name}: travel of each joint [rad]", None, text))
    acceleration = np.diff(logs["7 joints, line in 10 s"].cycles.q, n=2, axis=0) * 50.0**2
    text = " ".join(f"{x:.2f}" for x in np.sqrt((acceleration**2).mean(axis=0)))
    cells.append(Cell("line in 10 s: acceleration of each joint, rms [rad/s²]", None, text))
    for name, log in logs.items():
        cells.append(Cell(f"{name}: reversals of a joint, most", None, _most_reversals(log)))
    cells += saving_cells()
    notes = [
        "Error grows in proportion to speed, as it must for a filtered first-order loop; the paper's",
        "smaller growth is the share of its error that does not depend on speed.",
        "Distal joints are not preferred as such: the law weighs joint j by Σ|J_ij| / r_i over c_j, so",
        "where a joint near the tool moves the tool as well as one near the base, it moves as much.",
        "Joints are smooth but for the first and the last tenths of a second and sharp turns.",
    ]
    return Section("claims", "section 5 in words", cells, notes)


def _growth(slow: float, fast: float) -> float:
    return float(np.round(100 * (fast / slow - 1)))


def _travel(log: RunLog) -> np.ndarray:
    return np.abs(np.diff(log.q, axis=0)).sum(axis=0)


def _most_reversals(log: RunLog) -> int:
    signs = np.sign(np.where(np.abs(log.cycles.joint_step) > 1e-6, log.cycles.joint_step, 0.0))
    return int((signs[1:] * signs[:-1] < 0).sum(axis=0).max())
