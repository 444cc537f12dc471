"""Rules from data that a user measured."""

import numpy as np
import pytest

import fikm_drake as fd

GRID = np.array([(x, y) for x in (0, 150, 400) for y in (0, 150, 300)])
ANGLES = np.random.default_rng(0).uniform(-1, 1, (9, 5))


def test_nine_points_in_any_order_are_the_singletons_themselves():
    """Section 3.3: nine points of the rectangle, here unevenly spaced and for five joints."""
    order = np.random.default_rng(1).permutation(9)
    ik = fd.IntegerFuzzyIk(fd.WorkplaneData(GRID[order], ANGLES[order]))
    assert ik.num_joints == 5
    assert ik.rules.first.knots.tolist() == [0, 150, 400]
    found = ik.to_radians(ik.solve_batch(GRID)[0])
    np.testing.assert_allclose(found, ANGLES, atol=np.deg2rad(0.005) + 1e-12)


@pytest.mark.parametrize("conjunction", ["min", "product"])
def test_scattered_points_are_fitted(conjunction):
    rng = np.random.default_rng(2)
    truth = fd.IntegerFuzzyIk(labels=(4, 5), conjunction=conjunction, rounding="nearest")
    points = np.concatenate([rng.integers(0, [401, 301], (400, 2)), [[0, 0], [400, 300]]])
    data = fd.WorkplaneData(points, truth.to_radians(truth.solve_batch(points)[0]))
    ik = fd.IntegerFuzzyIk(data, labels=(4, 5), conjunction=conjunction, rounding="nearest")
    step = np.abs(ik.rules.singletons - truth.rules.singletons)
    assert step.max() < 100  # 1°: grades to 255 are coarse
    assert step.mean() < 20


def test_other_labels_than_the_grid_are_fitted():
    data = fd.WorkplaneData(GRID, ANGLES)
    ik = fd.IntegerFuzzyIk(data, labels=(2, 2), conjunction="product")
    assert ik.rules.size == 4
    assert ik.rules.first.knots.tolist() == [0, 400]


@pytest.mark.parametrize(
    ("points", "angles", "words"),
    [
        (GRID[:, :1], ANGLES, r"points must be \(k, 2\)"),
        (GRID, ANGLES[:5], r"positions must be \(9, n\), got \(5, 5\)"),
        (GRID, ANGLES[:, 0], r"\(9,\)"),
        (GRID, np.where(ANGLES == ANGLES[4, 1], np.nan, ANGLES), "positions must be finite.*row 4"),
        (np.where(GRID == 400, np.inf, GRID), ANGLES, "points must be finite.*row 6"),
        (np.zeros((0, 2)), np.zeros((0, 4)), "at least one"),
        (GRID, np.zeros((9, 0)), "at least one"),
    ],
)
def test_bad_data(points, angles, words):
    with pytest.raises(ValueError, match=words):
        fd.WorkplaneData(points, angles)


def test_too_few_points_for_the_labels():
    with pytest.raises(ValueError, match="9 points determine .* of the 25 singletons"):
        fd.IntegerFuzzyIk(fd.WorkplaneData(GRID, ANGLES), labels=(5, 5))
    with pytest.raises(ValueError, match="increase strictly"):
        fd.IntegerFuzzyIk(fd.WorkplaneData([[3, 3]], [[0.1]]))


@pytest.mark.parametrize("head", ["", "x,y,a,b,c,d,e\n", "# measured\nx [mm], y [mm], a\n\n"])
def test_csv(head, tmp_path):
    path = tmp_path / "data.csv"
    rows = np.column_stack([GRID, np.rad2deg(ANGLES)])
    path.write_text(head + "\n".join(", ".join(map(repr, row)) for row in rows.tolist()))
    ik = fd.IntegerFuzzyIk(fd.load_workplane_data(path))
    direct = fd.IntegerFuzzyIk(fd.WorkplaneData(GRID, ANGLES))
    np.testing.assert_array_equal(ik.rules.singletons, direct.rules.singletons)


@pytest.mark.parametrize(
    "text", ["", "x,y,a\n", "0,0\n", "0,0,1\n0,1\n", "0,0,1\n0,1,a\n", "0,0,nan\n"]
)
def test_bad_csv_is_named(text, tmp_path):
    path = tmp_path / "data.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match="data.csv is not a table"):
        fd.load_workplane_data(path)
