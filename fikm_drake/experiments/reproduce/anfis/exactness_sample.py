"""How exact closed form and tracer are: samples of `fikm-drake benchmark regions`."""

from fikm_drake.experiments.benchmarks.self_motion_benchmark import (
    closed_form_against_scan,
    planar_against_closed_form,
    seven_joints,
)
from fikm_drake.experiments.reproduce.report import Cell, Section

POINTS = 20_000
TRACED = 300
POSES = 4


def exactness() -> Section:
    """Closed form against a scan, tracer against the closed form, residuals of 7-joint arms."""
    scanned = closed_form_against_scan(POINTS)
    traced = planar_against_closed_form(TRACED)
    cells = [
        Cell(
            f"closed form against scan and bisection, {POINTS} points [rad]",
            None,
            scanned.error,
            scanned.same and scanned.error <= 1e-12,
        ),
        Cell("closed form: CPU time a point [µs]", None, 1e6 * scanned.seconds),
        Cell(
            f"traced against closed form, {TRACED} points [rad]",
            None,
            traced.error,
            traced.same and traced.error <= 1e-9,
        ),
        Cell("traced: CPU time a point [ms]", None, 1e3 * traced.seconds),
    ]
    for name in ("iiwa14", "panda"):
        cost = seven_joints(name, POSES)
        cells += [
            Cell(
                f"{name}, {POSES} poses: residual on the curves [m]",
                None,
                cost.error,
                cost.same and cost.error <= 1e-11,
            ),
            Cell(f"{name}: CPU time a pose [ms]", None, 1e3 * cost.seconds),
        ]
    return Section("exactness", "closed form and tracer, a sample", cells)
