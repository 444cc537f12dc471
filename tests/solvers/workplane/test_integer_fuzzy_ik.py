"""All-integer fuzzy IK of the paper's arm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fikm_drake as fd

SINGLETONS = {  # rows y = N, M, F; columns x = L, C, R [°]
    1: [(92.78, 53.26, 5.09), (72.16, 40.48, 1.38), (48.68, 22.75, -14.45)],
    2: [(118.18, 135.95, 115.59), (103.03, 112.23, 89.87), (75.70, 77.54, 44.13)],
    3: [(32.47, -24.82, -52.63), (9.82, -31.07, -47.81), (-3.53, -31.30, -35.10)],
}


@pytest.fixture(scope="module")
def ik():
    return fd.IntegerFuzzyIk()


def test_default_is_the_papers(ik):
    assert repr(ik) == "<IntegerFuzzyIk 3 x 3 labels, 4 joints, min, truncate, 0.01°>"
    assert ik.rules.first.knots.tolist() == [0, 200, 400]
    assert ik.rules.second.knots.tolist() == [0, 150, 300]


def test_singletons_of_the_model_arm(ik):
    for joint, rows in SINGLETONS.items():
        np.testing.assert_allclose(ik.rules.singletons[..., joint].T / 100, rows, atol=0.006)


@given(st.integers(-100, 500), st.integers(-100, 400))
def test_scalar_and_batch_agree_and_flag_what_is_outside(ik, x, y):
    angles, outside = ik.solve(x, y)
    batch, flags = ik.solve_batch([[x, y]])
    assert (batch[0].tolist(), bool(flags[0])) == (angles, outside)
    assert outside == (not (0 <= x <= 400 and 0 <= y <= 300))
    assert all(type(angle) is int for angle in angles)


def test_resolution_is_one_step():
    coarse, fine = fd.IntegerFuzzyIk(resolution=0.5), fd.IntegerFuzzyIk(resolution=0.005)
    for x, y in ((0, 0), (120, 80), (399, 299)):
        a = coarse.to_radians(coarse.solve(x, y)[0])
        b = fine.to_radians(fine.solve(x, y)[0])
        np.testing.assert_allclose(a, b, atol=np.deg2rad(1.5))


def test_least_squares_lowers_the_mean_angle_error():
    inverse = fd.TiltedPlaneInverse(fd.load_arm("tojo4dof"), fd.load_workplane("tojo4dof"))
    points = inverse.workplane.grid()[::5, ::5]
    exact = inverse(points)
    errors = []
    for least_squares in (False, True):
        ik = fd.IntegerFuzzyIk(inverse, labels=(5, 5), least_squares=least_squares)
        errors.append(((ik.to_radians(ik.solve_batch(points)[0]) - exact) ** 2).mean())
    assert errors[1] < 0.7 * errors[0]


def test_least_squares_on_a_large_desk():
    """15 m by 10 m: of its 150 million points some 200 thousand do."""
    large = fd.Workplane(origin=[10.0, 4.0, 0.0], yaw=-np.pi / 2, size=[15000, 10000])
    table = fd.load_arm("tojo4dof").table
    for row in (*table.joints[2:], table.tool):
        row.a *= 50
    inverse = fd.TiltedPlaneInverse(fd.DhArm(table), large)
    ik = fd.IntegerFuzzyIk(inverse, conjunction="product", least_squares=True)
    exact = np.rad2deg(inverse([7500, 5000]))
    np.testing.assert_allclose(np.array(ik.solve(7500, 5000)[0]) / 100, exact, atol=10)


def test_to_c_tells_its_units(ik, tmp_path):
    source, header = ik.to_c(tmp_path / "tojo.c", shape="rule_loop")
    assert "Outputs: 4 joint angles in steps of 0.01 degrees." in header.read_text("utf-8")
    assert (
        "int tojo_infer(int32_t x, int32_t y, int32_t outputs[TOJO_OUTPUTS])" in source.read_text()
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"labels": (3,)}, "labels must be two"),
        ({"labels": 3}, "labels must be two.*got 3"),
        ({"labels": (3.5, 3)}, "33 labels, got 3.5"),
        ({"labels": (3, 34)}, "33 labels, got 34"),
        ({"labels": (1, 3)}, "33 labels, got 1"),
        ({"conjunction": "max"}, "'max'"),
        ({"rounding": "floor"}, "'floor'"),
        ({"resolution": 0.0}, "resolution.*0.0"),
        ({"resolution": np.nan}, "resolution.*nan"),
        ({"resolution": 1e-9}, "too fine"),
        ({"resolution": 1e-3}, "65535.*coarser"),
    ],
)
def test_bad_options(options, words):
    with pytest.raises(ValueError, match=words):
        fd.IntegerFuzzyIk(**options)


def test_bad_points(ik):
    for bad in ([[1.0, 2.0]], [[np.nan, 1.0]], [["a", "b"]]):
        with pytest.raises(ValueError, match="must be integers"):
            ik.solve_batch(bad)
    for shape in ((), (3,), (4, 3)):
        with pytest.raises(ValueError, match=r"points must be \(…, 2\)"):
            ik.solve_batch(np.zeros(shape, dtype=int))
    with pytest.raises(TypeError):
        ik.solve(1.5, 2)
