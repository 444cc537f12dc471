"""The fuzzy mapping's step by the native kernel equals that of numpy."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.kinematics.native.native_step import NativeStep
from fikm_drake.laws import fuzzy_mapping as module

LAWS = [
    fd.FuzzyMapping(),
    fd.FuzzyMapping(row_floor=0.05, column_floor=0.1),
    fd.FuzzyMapping.iterated(),
    fd.FuzzyMapping(iterations=6, damping=0.1, row_floor=0.05),
    fd.FuzzyMapping(iterations=6),
    fd.FuzzyMapping(iterations=3, damping=1e-3),
]


def steps(monkeypatch, native_kernel, law, J, dr, damping=0.0):
    """Of the kernel, and of numpy."""
    monkeypatch.setattr(module, "_native_step", lambda: NativeStep(native_kernel))
    native = law.step(J, dr, damping)
    monkeypatch.setattr(module, "_native_step", lambda: None)
    return native, law.step(J, dr, damping)


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_equals_numpy(monkeypatch, native_kernel, law, damping):
    rng = np.random.default_rng(1)
    for name, rows in (("iiwa14", slice(0, 6)), ("puma560", slice(3, 6)), ("planar4", slice(3, 5))):
        arm = fd.load_arm(name)
        for _ in range(20):
            J = arm.jacobian(rng.uniform(-2.0, 2.0, arm.num_joints))[rows]
            dr = 0.1 * rng.normal(size=len(J))
            for jacobian in (J, np.asfortranarray(J)):
                native, numpy = steps(monkeypatch, native_kernel, law, jacobian, dr, damping)
                scale = 1e-12 * max(1.0, np.abs(numpy).max())
                np.testing.assert_allclose(native, numpy, rtol=1e-7, atol=scale)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_zero_rows_and_columns_and_singular_postures(monkeypatch, native_kernel, law):
    stretched = fd.load_arm("planar4").jacobian(np.zeros(4))
    empty = np.zeros((3, 4))
    single = np.zeros((3, 4))
    single[0, 1] = 0.5
    for J in (stretched, stretched[3:5], empty, single):
        native, numpy = steps(monkeypatch, native_kernel, law, J, np.full(len(J), 0.1))
        assert np.isfinite(native).all()
        np.testing.assert_allclose(native, numpy, rtol=1e-7, atol=1e-9)


def test_more_rows_than_the_kernel_takes(monkeypatch, native_kernel):
    rng = np.random.default_rng(2)
    J, dr = rng.normal(size=(7, 9)), rng.normal(size=7)
    native, numpy = steps(monkeypatch, native_kernel, fd.FuzzyMapping(), J, dr)
    np.testing.assert_array_equal(native, numpy)


def test_threads_do_not_share_buffers(native_kernel, in_threads):
    step = NativeStep(native_kernel)

    def run(seed):
        rng = np.random.default_rng(seed)
        J, dr = rng.normal(size=(3, 7)), rng.normal(size=3)
        first = step(J, dr, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 0.0)
        for _ in range(300):
            again = step(J, dr, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 0.0)
            np.testing.assert_array_equal(again, first)

    in_threads(run)
