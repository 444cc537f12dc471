"""Settings of all tests."""

import pytest
from hypothesis import settings

from fikm_drake.kinematics.native.build import LIBRARY, build
from fikm_drake.kinematics.native.kernel import Kernel

settings.register_profile("fikm_drake", derandomize=True, deadline=None)
settings.load_profile("fikm_drake")


@pytest.fixture(scope="session")
def native_kernel(tmp_path_factory):
    """The native kernel, built here where it is not; a machine without a compiler has none to test."""
    library = LIBRARY
    try:
        return Kernel(library)
    except OSError:
        library = tmp_path_factory.mktemp("native") / "_kernel.so"
        problem = build(library)
        if problem:
            pytest.skip(f"no native kernel: {problem}")
        return Kernel(library)
