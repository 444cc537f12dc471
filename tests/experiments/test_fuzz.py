"""Random cases of everything, a few; `fikm-drake fuzz` runs many."""

from dataclasses import replace

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.cli import main
from fikm_drake.experiments.fuzz import controller_fuzz, random_case
from fikm_drake.experiments.fuzz.fuzz_cases import KINDS, fuzz
from fikm_drake.experiments.fuzz.random_arm import MOST_JOINTS, random_arm
from fikm_drake.kinematics.tasks import make_task


def test_a_short_run_is_clean_and_has_every_kind():
    report = fuzz(20, seed=12)
    assert not report.violations, str(report)
    assert set(report.cases) == set(KINDS) and sum(report.cases.values()) == 20
    assert report.cycles > 200 and report.refused < 5


def test_a_case_is_made_from_the_seed_and_its_index_alone():
    whole, last = fuzz(4, seed=3), fuzz(1, seed=3, first=3)
    assert fuzz(3, seed=3).cycles + last.cycles == whole.cycles


def test_arms_of_all_kinds_come():
    arms = [random_arm(np.random.default_rng(i)) for i in range(60)]
    joints = [len(arm.lower) for arm in arms]
    assert min(joints) == 1 and 40 < max(joints) <= MOST_JOINTS
    assert min(arm.scale for arm in arms) < 0.01 and max(arm.scale for arm in arms) > 100.0
    free = [np.isinf(arm.upper).any() for arm in arms]
    locked = [(arm.upper == arm.lower).any() for arm in arms]
    assert any(free) and not all(free) and any(locked)
    for arm in arms:
        q = arm.posture(np.random.default_rng(0))
        assert (q >= arm.lower).all() and (q <= arm.upper).all()


@pytest.mark.parametrize(
    ("broken", "kind"),
    [
        (lambda self, step, low, high: step * np.nan, "not finite"),
        (lambda self, step, low, high: 2.0 * step + 1e6, "step length"),
        (lambda self, step, low, high: 1e3 * high, "speed limit"),
    ],
)
def test_it_sees_a_guard_that_is_broken(broken, kind, monkeypatch):
    monkeypatch.setattr("fikm_drake.control.guard.Guard.__call__", broken)
    assert kind in fuzz(6, seed=0).violations


def test_it_sees_a_fused_block_that_differs(monkeypatch):
    cycle = fd.ControlCycle.advance
    monkeypatch.setattr(fd.ControlCycle, "advance", lambda *a: cycle(*a) or a[1].gain.fill(0.3))
    assert "diagram is not fused" in fuzz(3, seed=0).violations


@pytest.mark.parametrize(
    "options",
    [
        {"max_joint_step": 5e-4},
        {"max_joint_step": 0.02, "task": "z", "acceleration_limits": []},
        {"null_space_motion": True},
    ],
    ids=["shortened", "solved-again-and-shortened", "null-space"],
)
@pytest.mark.parametrize("iterations", [1, 6])
def test_what_the_kernel_leaves_to_python_rounds_as_the_diagram(options, iterations, monkeypatch):
    """Seeds in which the Diagram and the fused block once differed in their last bits."""
    law, drawn = fd.FuzzyMapping(iterations=iterations), random_case.random_config
    changed = {"law": law, "posture_rate": 0.0, "limit_retreat": 0.0, **options}
    monkeypatch.setattr(
        random_case, "random_config", lambda rng, arm: replace(drawn(rng, arm), **changed)
    )
    found, cycles = [], 0
    with np.errstate(all="ignore"):
        for i in range(25):
            try:
                for violations in controller_fuzz.controller_case(np.random.default_rng([7, i])):
                    found, cycles = found + violations, cycles + 1
            except ValueError:  # of limits for other joints than an arm has
                pass
    assert not found, found[0]
    assert cycles > 200


def test_its_own_measure_of_the_error_is_that_of_the_tasks():
    plant = fd.MakeDhArmPlant(fd.load_arm("iiwa14"))
    rng = np.random.default_rng(0)
    arm = fd.PlantArm(plant)
    for name in ("position", "xy", "pointing", "pose", "orientation"):
        task, config = make_task(arm, name), fd.FuzzyIkConfig(task=name)
        q, other = rng.uniform(-1, 1, (2, 7))
        target = _target(arm, name, other)
        error = controller_fuzz.true_error(plant, config, target, q)
        assert error == pytest.approx(np.linalg.norm(task.error(target, q)), rel=1e-6)


def _target(arm, name, q):
    pose = arm.pose(arm.context_at(q))
    if name in ("pose", "orientation"):
        return pose
    p = pose.translation()
    if name == "pointing":
        return np.concatenate((p, pose.rotation().matrix()[:, 2]))
    return p[: len("xyz" if name == "position" else name)]


def test_the_command_counts_and_ends_with_0(capsys):
    assert main(["fuzz", "--cases", "5", "--seed", "2"]) == 0
    printed = capsys.readouterr().out
    assert "5 cases" in printed and "violations: 0" in printed
