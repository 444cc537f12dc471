"""Solvers and generators of data on any executor: the same results, and all that is sent can be pickled."""

import contextlib
import pickle
import threading
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.executors import completed
from fikm_drake.fuzzy.anfis.structure_search import search_structures

ARM = fd.load_arm("panda")
PLANAR = fd.load_arm("hassantabar3r")
POSTURES = np.random.default_rng(5).uniform(ARM.lower, ARM.upper, (1100, 7))
POSES = ARM.forward_kinematics(POSTURES)
POINTS = np.random.default_rng(6).uniform(-4.0, 4.5, (60, 2))


@contextlib.contextmanager
def dask():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client.get_executor()


@pytest.fixture(scope="module", params=["processes", "dask"])
def executor(request):
    pool = dask() if request.param == "dask" else ProcessPoolExecutor(2, get_context("spawn"))
    with pool as made:
        yield made


def poses(executor, progress):
    found = fd.solve_batch(ARM, POSES, task="pose", executor=executor, progress=progress)
    return [found.q, found.status, found.cycles, found.position_error]


def from_a_start(executor, progress):
    start = np.array(ARM.default_position)
    positions = POSES[:, :3, 3]
    found = fd.solve_batch(
        ARM, positions, initial_position=start, executor=executor, progress=progress
    )
    return [found.q, found.status]


def closed_form(executor, progress):
    found = fd.generate_feasibility_data(PLANAR, POINTS, executor, chunk=20, progress=progress)
    return [found.count, found.lower, found.upper, found.closest]


def traced(executor, progress):
    found = fd.generate_feasibility_data(
        PLANAR, POINTS[:12], executor, task="xy", chunk=4, progress=progress
    )
    return [found.count, found.lower, found.upper, found.closest]


def bounds(executor, progress):
    learned = fd.train_bounds(
        PLANAR,
        memberships=(3, 3),
        points=200,
        epochs=2,
        starts=1,
        executor=executor,
        progress=progress,
    )
    return [learned.predict(POINTS)]


def structures(executor, progress):
    X = np.random.default_rng(7).uniform(-1.0, 1.0, (120, 2))
    rows = (X, np.sin(X.sum(axis=1)))
    found = search_structures(
        rows, rows, memberships=(2, 3), epochs=2, executor=executor, progress=progress
    )
    return [[s.validation for s in found], [s.anfis.num_rules for s in found]]


JOBS = [poses, from_a_start, closed_form, traced, bounds, structures]


@pytest.mark.parametrize("job", JOBS, ids=lambda job: job.__name__)
def test_the_results_are_those_of_this_process(job, executor):
    told = []
    found, expected = job(executor, told.append), job(None, None)
    for ours, theirs in zip(found, expected):
        np.testing.assert_array_equal(ours, theirs)
    assert told == sorted(told) and told[-1] == 1.0 and len(told) > 1


def test_a_tracer_traces_elsewhere_what_it_traces_here(executor):
    tracer = fd.SelfMotionTracer(ARM, "pose", searches=2)
    q = np.array([0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7])
    here, there = tracer.trace(q), executor.submit(tracer.trace, q).result()
    assert len(here.components) == len(there.components) >= 1
    for ours, theirs in zip(here.components, there.components):
        np.testing.assert_array_equal(ours.q, theirs.q)
        assert ours.ends == theirs.ends
        middle = 0.5 * ours.length  # what came back can still be asked
        np.testing.assert_array_equal(ours.at(middle), theirs.at(middle))


def test_a_solver_solves_elsewhere(executor):
    solver = fd.Solver(ARM, task="pose", tolerance=(1e-4, 1e-3), seed=3)
    solver.solve(POSES[0])
    there = executor.submit(solver.solve, POSES[1]).result()
    np.testing.assert_array_equal(there.q, solver.solve(POSES[1]).q)


def test_a_tracer_of_a_plant():
    """Of the plant's chain once it was pickled; of a plant with a gripper it says what to take."""
    plant = fd.MakeDhArmPlant(ARM)
    tracer = fd.SelfMotionTracer(plant, "pose", searches=2)
    q = np.array([0.1, -0.7, 0.2, -2.2, 0.1, 1.6, 0.7])
    again = pickle.loads(pickle.dumps(tracer))
    for ours, theirs in zip(tracer.trace(q).components, again.trace(q).components):
        assert ours.ends == theirs.ends
        np.testing.assert_allclose(ours.lower, theirs.lower, atol=1e-7)
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    finger = (
        '<link name="finger"/><joint name="slide" type="prismatic"><parent link="tool"/>'
        '<child link="finger"/><axis xyz="1 0 0"/><limit lower="0" upper="0.04" effort="5"/>'
        "</joint></robot>"
    )
    more = MultibodyPlant(0.0)
    Parser(more).AddModelsFromString(ARM.to_urdf().replace("</robot>", finger), "urdf")
    more.WeldFrames(more.world_frame(), more.GetFrameByName("base"))
    more.Finalize()
    with pytest.raises(TypeError, match="SerialChain.from_plant"):
        pickle.dumps(fd.SelfMotionTracer(more, "pose"))


def test_threads_beside_an_executor_are_not_used():
    with ProcessPoolExecutor(1) as pool:
        with pytest.raises(ValueError, match="threads 2 is not used"):
            fd.solve_batch(ARM, POSES, task="pose", threads=2, executor=pool)


class Slow:
    """An executor that never begins."""

    def __init__(self):
        self.futures = []

    def submit(self, function, *arguments):
        self.futures.append(Future())
        return self.futures[-1]


def test_what_has_not_begun_is_cancelled():
    executor = Slow()
    work = completed(executor, len, [("ab",), ("c",), ("",)])
    threading.Timer(0.1, lambda: executor.futures[1].set_result(1)).start()
    assert next(work) == (1, 1)
    work.close()
    assert [future.cancelled() for future in executor.futures] == [True, False, True]
