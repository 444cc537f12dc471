"""The native kernel: equal to numpy, built where it can be, left out where it cannot."""

from pathlib import Path

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.kinematics.native import build as building
from fikm_drake.kinematics.native import kernel as loading
from fikm_drake.kinematics.native.kernel import INSTRUCTION_SETS, Kernel
from fikm_drake.kinematics.native.native_kinematics import NativeKinematics
from fikm_drake.resources import model_names


def chains():
    """Of every model, and of frames that stand anyhow, with both kinds of joints."""
    yield from (fd.load_arm(name).chain for name in model_names())
    rng = np.random.default_rng(1)
    for n in (1, 2, 5, 11):
        before = np.tile(np.eye(4), (n + 1, 1, 1))
        before[:, :3, :3] = np.linalg.qr(rng.normal(size=(n + 1, 3, 3)))[0]
        before[:, :3, :3] *= np.linalg.det(before[:, :3, :3])[:, None, None]
        before[:, :3, 3] = rng.normal(size=(n + 1, 3))
        yield fd.SerialChain(
            name=f"random{n}",
            joint_names=tuple(f"joint{i}" for i in range(n)),
            kinds=tuple(rng.choice(["revolute", "prismatic"], n)),
            before=before[:-1],
            tool=before[-1],
            lower=np.full(n, -np.inf),
            upper=np.full(n, np.inf),
            velocity_limits=np.full(n, np.inf),
            acceleration_limits=np.full(n, np.inf),
            default_position=np.zeros(n),
        )


@pytest.mark.parametrize("most", INSTRUCTION_SETS)
def test_kinematics_equal_those_of_numpy(native_kernel, most):
    native_kernel = Kernel(native_kernel.path, most)
    for chain in chains():
        native = NativeKinematics(native_kernel, chain.packed(), chain.num_joints)
        for shape in ((), (1,), (3, 7)):
            q = np.random.default_rng(2).uniform(-7.0, 7.0, (*shape, chain.num_joints))
            frames = chain.frames(q.reshape(-1, chain.num_joints).T)
            X, J = native.poses(q), native.jacobians(q)
            assert X.shape == (*shape, 4, 4) and J.shape == (*shape, 6, chain.num_joints)
            X, J = X.reshape(-1, 4, 4), J.reshape(-1, *J.shape[-2:])
            exact = {"rtol": 0, "atol": 1e-12}
            np.testing.assert_allclose(X[:, :3, 3], frames.position.T, **exact)
            np.testing.assert_allclose(X[:, :3, :3], frames.rotation.transpose(2, 1, 0), **exact)
            np.testing.assert_allclose(J, frames.jacobian().transpose(2, 0, 1), **exact)
            np.testing.assert_array_equal(X[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (len(X), 1)))


def test_one_posture_equals_many():
    for chain in chains():
        q = np.random.default_rng(3).uniform(-7.0, 7.0, chain.num_joints)
        frames = chain.frames(q[:, None])
        X = chain.one.pose(q)
        exact = {"rtol": 0, "atol": 1e-12}
        np.testing.assert_allclose(X[:3, 3], frames.position[:, 0], **exact)
        np.testing.assert_allclose(X[:3, :3], frames.rotation[..., 0].T, **exact)
        for length in (1.0, 0.3, None):
            J = chain.one.jacobian(q, length)
            np.testing.assert_allclose(J, frames.jacobian(length)[..., 0], **exact)


def test_large_angles_and_small_ones(native_kernel):
    chain = fd.load_arm("planar2").chain
    native = NativeKinematics(native_kernel, chain.packed(), 2)
    for angle in (1e-300, 1e-9, np.pi / 2, np.pi, 1e3, 1e5, 1e7, 1e15, -1e7):
        X = native.poses(np.array([angle, 0.0]))
        np.testing.assert_allclose(X[:2, 0], [np.cos(angle), np.sin(angle)], rtol=0, atol=1e-15)


def test_sources_that_do_not_compile_leave_what_is_there(tmp_path, monkeypatch):
    library = tmp_path / "_kernel.so"
    library.write_bytes(b"as it was")
    monkeypatch.setenv("CC", "/nowhere/cc")
    assert "/nowhere/cc" in building.build(library)
    monkeypatch.delenv("CC")
    monkeypatch.setattr(building.shutil, "which", lambda name: None)
    assert "no C compiler" in building.build(library)
    assert library.read_bytes() == b"as it was"
    assert [path.name for path in tmp_path.iterdir()] == ["_kernel.so"]


def test_library_of_other_sources_is_refused(native_kernel, tmp_path):
    content = Path(native_kernel.path).read_bytes()
    digest = building.source_digest().encode()
    other = tmp_path / "_kernel.so"
    other.write_bytes(content.replace(digest, b"0" * 16))
    with pytest.raises(OSError, match="of other sources"):
        Kernel(other)
    none = tmp_path / "none.so"
    none.write_text("no library")
    with pytest.raises(OSError):
        Kernel(none)


def test_environment_chooses(native_kernel, monkeypatch):
    monkeypatch.setattr(loading, "LIBRARY", native_kernel.path)
    for value, described in [
        ("0", "numpy (FIKM_DRAKE_NATIVE=0)"),
        ("base", "native kernel (base)"),
        ("", f"native kernel ({native_kernel.instruction_set})"),
    ]:
        monkeypatch.setenv("FIKM_DRAKE_NATIVE", value)
        loading._load.cache_clear()
        assert loading.kernel_description() == described
    monkeypatch.setattr(loading, "LIBRARY", native_kernel.path.with_name("absent.so"))
    loading._load.cache_clear()
    assert loading.kernel_description() == "numpy (no native kernel was built)"
    monkeypatch.undo()
    loading._load.cache_clear()
