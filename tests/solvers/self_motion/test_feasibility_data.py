"""Feasibility data: the same by every executor, resumable, honest about bad files."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.self_motion import generate_feasibility_data as module
from fikm_drake.solvers.self_motion.closest_to_mid_range import closest_to_mid_range
from fikm_drake.solvers.self_motion.feasibility_data import FeasibilityData
from fikm_drake.solvers.self_motion.feasible_intervals import feasible_interval_table
from fikm_drake.solvers.self_motion.generate_feasibility_data import generate_feasibility_data

ARM = load_arm("hassantabar3r")
POINTS = np.random.default_rng(1).uniform(-4.0, 4.5, (300, 2))


def same(first, second):
    for name in ("points", "count", "lower", "upper", "closest"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_data_are_the_closed_form_s():
    data = generate_feasibility_data(ARM, POINTS)
    table = feasible_interval_table(ARM, POINTS)
    assert len(data) == 300 and 50 < data.feasible.sum() < 250
    np.testing.assert_array_equal(data.count, table.count)
    np.testing.assert_array_equal([data.lower, data.upper], table.widest())
    np.testing.assert_array_equal(data.closest, closest_to_mid_range(ARM, POINTS))


@pytest.mark.parametrize("make", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_executors_change_nothing(make):
    shares = []
    with make(2) as executor:
        data = generate_feasibility_data(ARM, POINTS, executor, chunk=40, progress=shares.append)
    same(data, generate_feasibility_data(ARM, POINTS))
    assert len(shares) == 8 and shares == sorted(shares) and shares[-1] == 1.0


def test_traced_data_are_the_closed_form_s():
    exact = generate_feasibility_data(ARM, POINTS[:40])
    data = generate_feasibility_data(ARM, POINTS[:40], task="xy", chunk=15)
    np.testing.assert_array_equal(data.count, exact.count)
    np.testing.assert_allclose(data.lower, exact.lower, atol=1e-9)
    np.testing.assert_allclose(data.upper, exact.upper, atol=1e-9)
    np.testing.assert_allclose(data.closest, exact.closest, atol=1e-9)


def test_any_joint_of_any_arm():
    arm = load_arm("panda")
    X = arm.forward_kinematics([[0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7]])
    data = generate_feasibility_data(arm, X, task="pose", joint=2)
    assert data.count[0] > 0 and data.lower[0] < data.upper[0]
    np.testing.assert_allclose(arm.forward_kinematics(data.closest), X, atol=1e-11)


def test_a_stopped_run_goes_on_where_it_was(tmp_path, monkeypatch):
    file = tmp_path / "data.npz"
    done = []

    def stop(share):
        done.append(share)
        if len(done) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        generate_feasibility_data(ARM, POINTS, file=file, chunk=50, progress=stop)
    assert (FeasibilityData.load(file).count >= 0).sum() == 150
    computed = []
    rows = module.feasibility_rows
    monkeypatch.setattr(
        module, "feasibility_rows", lambda *a: computed.append(len(a[1])) or rows(*a)
    )
    data = generate_feasibility_data(ARM, POINTS, file=file, chunk=50)
    assert computed == [50, 50, 50]
    same(data, generate_feasibility_data(ARM, POINTS))
    same(data, FeasibilityData.load(file))
    assert [path.name for path in tmp_path.iterdir()] == ["data.npz"]


def test_files_of_other_jobs_are_not_touched(tmp_path):
    file = tmp_path / "data.npz"
    generate_feasibility_data(ARM, POINTS[:10], file=file)
    before = file.read_bytes()
    for points, options in ((POINTS[:9], {}), (POINTS[1:11], {}), (POINTS[:10], {"task": "xy"})):
        with pytest.raises(ValueError, match="another arm, task, joint or other points"):
            generate_feasibility_data(ARM, points, file=file, **options)
    assert file.read_bytes() == before
    broken = tmp_path / "broken.npz"
    broken.write_bytes(b"no zip")
    with pytest.raises(ValueError, match="no feasibility data"):
        generate_feasibility_data(ARM, POINTS, file=broken)
    np.savez(broken, points=POINTS)
    with pytest.raises(ValueError, match="no feasibility data"):
        FeasibilityData.load(broken)


@pytest.mark.parametrize(
    ("points", "options", "words"),
    [
        ([[1.0, np.nan]], {}, "points"),
        ([1.0, 2.0], {}, "points"),
        ([[1.0, 2.0, 3.0]], {}, "points"),
        ([[1.0, 2.0]], {"joint": 1}, "joint"),
        ([[1.0, 2.0]], {"joint": 3, "task": "xy"}, "joint"),
        ([[1.0, 2.0]], {"task": "pose"}, "leaves"),
        ([[1.0, 2.0]], {"chunk": 0}, "chunk"),
    ],
)
def test_bad_jobs_are_named(points, options, words):
    with pytest.raises(ValueError, match=words):
        generate_feasibility_data(ARM, points, **options)


def test_no_points():
    data = generate_feasibility_data(ARM, np.zeros((0, 2)))
    assert len(data) == 0 and data.feasible.shape == (0,)
