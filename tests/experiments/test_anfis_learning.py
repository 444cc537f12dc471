"""Chapter 4 of Hassantabar (2021): what `fikm-drake reproduce anfis` claims of it."""

import importlib

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.experiments.benchmarks.anfis_benchmark import table
from fikm_drake.experiments.reproduce.anfis import (
    EXPERIMENTS,
    arms_without_closed_form,
    learning,
    samples,
    seven_joints,
)
from fikm_drake.experiments.reproduce.anfis.tables import bilinear_table, radial_table


@pytest.mark.parametrize("name", ["accuracy", "figure 4.16", "resolution"])
def test_claims_are_reached(name):
    section = EXPERIMENTS[name]()
    assert section.key == name
    assert section.reached, str(section)
    assert any(cell.reached for cell in section.cells)


def test_figures_4_8_and_4_12_with_fewer_epochs(monkeypatch):
    monkeypatch.setattr(learning, "EPOCHS", 3)
    learning.hybrid_anfis.cache_clear()
    try:
        sections = [EXPERIMENTS[name]() for name in ("figure 4.8", "figure 4.12")]
    finally:
        learning.hybrid_anfis.cache_clear()
    cells = {cell.label: cell.ours for cell in sections[0].cells}
    assert cells["rules of each ANFIS"] == 64
    for name in samples.QUANTITIES:
        assert cells[f"{name}: rms error, fresh points [rad]"] < 0.02
    assert {"figure_4_8", "figures_4_9_11"} == set(sections[0].pictures)


def test_structures_with_fewer_of_them(monkeypatch):
    module = importlib.import_module("fikm_drake.experiments.reproduce.anfis.structures")
    monkeypatch.setattr(module, "MEMBERSHIPS", (4, 8))
    monkeypatch.setattr(module, "EPOCHS", 2)
    module.found.cache_clear()
    try:
        section = EXPERIMENTS["structures"]()
    finally:
        module.found.cache_clear()
    assert section.reached, str(section)
    assert len(section.cells) == 2 * (8 + 1) and list(section.pictures) == ["anfis_structures"]


def test_freedom_of_the_7_joint_arm(monkeypatch):
    monkeypatch.setattr(seven_joints, "FRESH", 3)
    section = seven_joints.freedom()
    assert section.reached, str(section)


def test_arms_without_a_closed_form(monkeypatch):
    for name, count in (("FRESH", 300), ("TRACED", 20), ("TRACED_7", 1)):
        monkeypatch.setattr(arms_without_closed_form, name, count)
    section = arms_without_closed_form.no_closed_form()
    assert section.reached, str(section)
    assert sum(cell.reached is True for cell in section.cells) == 6


def test_radial_table_is_the_exact_form_between_its_knots():
    arm = fd.load_arm("hassantabar3r")
    points = samples.fresh_points()[:500]
    polar = np.column_stack([np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])])
    exact = samples.exact(points)
    for name in ("lower", "upper"):
        coarse, fine = (
            np.abs(radial_table(arm, name, count)(polar) - exact[name]).mean()
            for count in (224, 1500)
        )
        assert fine < 0.3 * coarse < 1e-3


def test_bilinear_table_fits_bilinear_functions():
    X = np.random.default_rng(0).uniform([-1, 2], [3, 5], (400, 2))
    Y = 1 + 2 * X[:, 0] - X[:, 1] + 0.5 * X[:, 0] * X[:, 1]
    np.testing.assert_allclose(bilinear_table(X, Y, 5)(*X.T), Y, atol=1e-8)


def test_benchmark_prints_both_comparisons():
    done = []
    printed = table(1, done.append)
    assert done[-1] == 1.0
    assert "fd.Anfis" in printed and "exact bounds" in printed and "times faster" in printed
