"""Three ways to compute one run: the Diagram, the fused block, and a plain loop."""

from dataclasses import replace

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake import ControllerStatus as Status


def naive_controller(arm, config, start, desired, rows):
    """Equations 27-34, section 2.7 and figure 1 in a plain loop; K_0 = 1, d_0 = 0."""
    coordinates = [row - 3 for row in rows]
    q, K_applied, d = np.array(start), 1.0, np.zeros(len(rows))
    errors, steps, qs, gains, dthetas = [], [], [], [], []
    for target in desired:
        e = target - arm.forward_kinematics(q)[coordinates, 3]
        size = np.sqrt((e**2).sum())
        if size > config.error_limit:  # ours, not the paper's
            e, size = e * config.error_limit / size, config.error_limit
        errors.append(size)
        last = errors[-10:]
        relative = size / np.mean(last) if len(last) == 10 else 1.0
        signs = np.sign(np.array(steps[-10:]))
        changes = (np.diff(signs, axis=0) != 0).sum(axis=0).max() if len(steps) > 1 else 0
        table = [0.1, 0.4, 0.03] if changes >= 4 else [1.0, 2.6, 0.8]
        K = np.interp(relative, [0.0, 1.0, 2.0], table)
        K_applied = K / 3 + 2 / 3 * K_applied
        d = K_applied * e / 3 + 2 / 3 * d
        J = arm.jacobian(q)[rows]
        r, c = np.abs(J).sum(axis=1), np.abs(J).sum(axis=0)
        dtheta = (J * (d / r)[:, None]).sum(axis=0) / c
        q = q + dtheta
        for series, value in ((steps, dtheta), (qs, q), (gains, K), (dthetas, dtheta)):
            series.append(value)
    return np.array(qs), np.array(dthetas), np.array(gains)


@pytest.mark.parametrize("name", ["table6_10s", "table6_5s", "table6_2s"])
def test_simulated_run_equals_a_plain_loop(name, scenario_inputs, fused):
    arm, config, start, desired = scenario_inputs(name, fused=fused)
    q, dtheta, gain = naive_controller(arm, config, start, desired, [3, 4, 5])
    log = fd.simulate(fd.load_scenario(name).with_config(config))
    assert len(log.cycles.q) == len(q)
    np.testing.assert_allclose(log.cycles.q, q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(log.cycles.joint_step, dtheta, rtol=0, atol=1e-9)
    np.testing.assert_allclose(log.gain[:-1], gain, rtol=0, atol=1e-6)


FUSED_RUNS = [
    ("table6_10s", {}),
    ("table6_5s", {}),
    ("table6_2s", {}),
    ("table6_2s", {"law": fd.FuzzyMapping("direct")}),
    ("large_step_2", {}),
    ("large_step_4", {}),
    ("panda_square", {}),
    ("panda_square", {"measured_position": True}),
    ("panda_square", {"velocity_limits": [0.4], "acceleration_limits": [3.0], "posture_rate": 1.0}),
    ("large_step_2", {"law": fd.FuzzyMapping(iterations=2), "restart_search": True}),
]


def assert_equal_series(first, second, tolerance=1e-12):
    """Measured: equal to the last bit. The gain is a function of a ratio of errors, so where they
    are 1e-6 m a last bit more or less shows in it a million times larger.
    """
    for name in first:
        atol = 1e3 * tolerance if name == "gain" else tolerance
        np.testing.assert_allclose(first[name], second[name], rtol=0, atol=atol, err_msg=name)


@pytest.mark.parametrize("lost", [False, True], ids=["", "with-nan"])
@pytest.mark.parametrize(("name", "changes"), FUSED_RUNS)
def test_fused_equals_the_diagram(name, changes, lost, plant_with, scenario_inputs, run):
    arm, config, start, desired = scenario_inputs(name, **changes)
    if lost:
        desired[20:26] = np.nan
        desired[35, 0] = np.inf
    plant = plant_with(arm)

    def late(k, commanded):  # a measurement that lags and fails for a while
        measured = 0.98 * commanded + 0.02 * start
        return np.full(7, np.nan) if lost and 60 <= k < 65 else measured

    measure = late if config.measured_position else None
    runs = [
        run(plant, replace(config, fused=fused), start, desired, measure) for fused in (False, True)
    ]
    assert_equal_series(*runs)
    assert np.isfinite(np.concatenate([v.ravel() for v in runs[0].values()])).all()


EVERYTHING = {
    "restart_search": True,
    "posture_rate": 0.5,
    "limit_margin": 0.2,
    "velocity_limits": [2.0],
    "acceleration_limits": [20.0],
    "law": fd.FuzzyMapping(iterations=3, damping=0.05, row_floor=0.02),
}


@pytest.mark.parametrize(("arm", "measured"), [("puma560", False), ("arm7", True)])
def test_fused_equals_the_diagram_with_every_option(arm, measured, plant_with, run):
    """Out of reach, lost, back, and straight inward; the calm's damping is in it too."""
    start = fd.load_arm(arm).default_position + 0.1
    parts = [(240, [1.6, 0, 0.3]), (5, [np.nan] * 3), (80, [0.2, 0.4, 0.4]), (99, [-0.35, 0, 0.3])]
    desired = np.concatenate([np.tile(target, (cycles, 1)) for cycles, target in parts])
    config = fd.FuzzyIkConfig(**EVERYTHING, measured_position=measured)
    measure = (lambda k, commanded: 0.99 * commanded + 0.01 * start) if measured else None
    runs = [
        run(plant_with(arm), replace(config, fused=fused), start, desired, measure)
        for fused in (False, True)
    ]
    assert_equal_series(*runs)
    seen = {Status(int(status)) for status in runs[0]["status"].ravel()}
    assert seen >= {Status.RESTART_SEARCH, Status.LIMITED, Status.INVALID_INPUT}


def test_fused_equals_the_diagram_at_joint_limits(plant_with, run):
    arm = fd.load_arm("panda")
    start = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    angle = np.linspace(0, 2 * np.pi, 600)[:, None]
    desired = np.array([0.2, 0.0, 0.5]) + 0.9 * np.hstack([np.cos(angle), np.sin(angle), 0 * angle])
    runs = [
        run(plant_with("panda"), fd.FuzzyIkConfig(fused=fused), start, desired)
        for fused in (False, True)
    ]
    assert_equal_series(*runs)
    q = runs[0]["commanded_position"]
    assert (runs[0]["status"] == Status.LIMITED).sum() > 20
    assert (q >= arm.lower).all() and (q <= arm.upper).all()
    at_limit = (q == arm.lower) | (q == arm.upper)
    assert at_limit.any()
