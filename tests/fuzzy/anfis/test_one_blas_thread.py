"""numpy's linear algebra in one thread while an ANFIS learns."""

import numpy as np
import pytest

from fikm_drake.fuzzy.anfis import Anfis
from fikm_drake.fuzzy.anfis.one_blas_thread import _switch, one_blas_thread


@pytest.fixture
def threads():
    """OpenBLAS's number of threads, set to 2."""
    switch = _switch()
    if switch is None:
        pytest.skip("numpy has no OpenBLAS of its own")
    get, put = switch
    before = get()
    put(2)
    if get() != 2:
        pytest.skip("OpenBLAS was built for one thread")
    yield get
    put(before)


def test_one_thread_inside_and_as_many_as_before_after(threads):
    with pytest.raises(KeyError):
        with one_blas_thread():
            with one_blas_thread():
                assert threads() == 1
            assert threads() == 1
            raise KeyError
    assert threads() == 2


def test_learning_has_one_thread_and_gives_them_back(threads):
    X = np.random.default_rng(0).uniform(-1.0, 1.0, (200, 2))
    seen = []
    anfis = Anfis(memberships=(2, 2), names=("x", "y", "z"))
    anfis.fit(X, X[:, 0] * X[:, 1], epochs=2, progress=lambda done: seen.append(threads()))
    assert seen == [1, 1] and threads() == 2
