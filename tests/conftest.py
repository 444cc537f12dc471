"""Settings of all tests."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import settings
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import SpatialInertia

import fikm_drake as fd
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


@pytest.fixture(scope="session")
def in_threads():
    """in_threads(work, count=3): work(i) at once, each in a thread of its own; what one raises comes out."""

    def run(work, count=3):
        together = threading.Barrier(count)

        def begin(i):
            together.wait()
            return work(i)

        with ThreadPoolExecutor(count) as pool:
            return list(pool.map(begin, range(count)))

    return run


@pytest.fixture(scope="session")
def checker_with():
    """checker_with((shape, position), …) -> the checker of an arm among shapes in the world.

    `floating`: each is on a body that moves, whose pose is seven of the positions of all else; its
    `position` is then where the plant has it by default, the origin.
    """

    def checker(*shapes, arm="iiwa14", floating=False, padding=0.0):
        def populate(robot):
            plant = robot.plant()
            for i, (shape, position) in enumerate(shapes):
                body, X = plant.world_body(), RigidTransform(position)
                if floating:
                    instance = plant.AddModelInstance(f"thing{i}")
                    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
                    body, X = plant.AddRigidBody(f"thing{i}", instance, inertia), RigidTransform()
                plant.RegisterCollisionGeometry(body, X, shape, f"shape{i}", CoulombFriction())

        arm = fd.load_arm(arm)
        return fd.MakeCollisionChecker(arm, populate, robots=[arm.name], robot_padding=padding)

    return checker
