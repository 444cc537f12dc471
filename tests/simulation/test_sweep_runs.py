"""Sweeps: every combination once, resumed, on any executor; two logs compared."""

import os
import pickle
import signal
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.cli import main
from fikm_drake.simulation import sweep_runs

BASE = fd.TrackingScenario(
    "planar2", [[1.5, 0.0], [1.3, 0.4]], 0.3, hold=0.2, config=fd.FuzzyIkConfig(fused=True)
)
GRID = fd.Grid(BASE, {"control_rate": [50.0, 100.0], "target.duration": [0.2, 0.4]})


def test_a_grid_is_every_combination_by_its_options():
    table = fd.sweep(GRID)
    assert table.column("control_rate") == [50.0, 50.0, 100.0, 100.0]
    assert table.column("target.duration") == [0.2, 0.4, 0.2, 0.4]
    for row in table.rows:
        scenario = BASE.with_options(row.options)
        log = fd.simulate(scenario)
        assert row.e_max == log.metrics().e_max and row.status == log.status_names[-1]
        assert row.travel == pytest.approx(np.abs(np.diff(log.q, axis=0)).sum())
    assert "control_rate=50,duration=0.2" in str(table)
    with pytest.raises(KeyError, match="target.duration"):
        table.column("speed")


def test_scenarios_with_and_without_names_and_what_is_not_valid():
    assert [row.name for row in fd.sweep([BASE, BASE]).rows] == ["0001", "0002"]
    assert fd.sweep({"mine": BASE}).rows[0].name == "mine"
    for bad, word in (([], "nothing"), ({"a/b": BASE}, "a/b"), (["x"], "Scenario")):
        with pytest.raises(ValueError, match=word):
            fd.sweep(bad)
    with pytest.raises(ValueError, match="control_rate=-1.*control_rate"):
        fd.sweep(fd.Grid(BASE, {"control_rate": [-1.0]}))
    with pytest.raises(ValueError, match="no option 'speed'"):
        fd.sweep(fd.Grid(BASE, {"speed": [1.0]}))


class Counting(Executor):
    """Runs at once, and counts."""

    def __init__(self):
        self.names = []

    def submit(self, function, *arguments):
        pickle.loads(pickle.dumps((function, arguments)))  # as another process would get it
        self.names.append(arguments[0])
        future = Future()
        future.set_result(function(*arguments))
        return future


def test_a_stopped_sweep_goes_on_and_runs_nothing_twice(tmp_path, monkeypatch):
    runs = []
    real = sweep_runs.simulate

    def counted(scenario, **options):
        runs.append(scenario)
        return real(scenario, **options)

    monkeypatch.setattr(sweep_runs, "simulate", counted)

    def stop_after_two(fraction):
        if fraction >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fd.sweep(GRID, folder=tmp_path, progress=stop_after_two)
    assert len(runs) == 2
    seen = []
    executor = Counting()
    table = fd.sweep(GRID, executor, folder=tmp_path, progress=seen.append)
    assert len(runs) == 4 and len(executor.names) == 4 and seen == [0.25, 0.5, 0.75, 1.0]
    np.testing.assert_array_equal(table.column("e_max"), fd.sweep(GRID).column("e_max"))
    assert np.isnan(table.column("seconds")).sum() == 2  # the two that were there
    assert len((tmp_path / "sweep.csv").read_text().splitlines()) == 5
    assert table.log(table.rows[3].name).metrics().e_max == table.rows[3].e_max
    runs.clear()
    changed = fd.Grid(BASE.but(target__hold=0.3), GRID.options)
    fd.sweep(changed, folder=tmp_path)  # logs of the same names, but of other scenarios
    assert len(runs) == 4


def test_a_run_that_fails_is_a_row_and_the_others_go_on(monkeypatch):
    real = sweep_runs.simulate

    def failing(scenario, **options):
        if scenario.control_rate == 50.0:
            raise ValueError("the arm is away")
        return real(scenario, **options)

    monkeypatch.setattr(sweep_runs, "simulate", failing)
    table = fd.sweep(GRID)
    assert [bool(row.error) for row in table.rows] == [True, True, False, False]
    assert "the arm is away" in str(table)


def test_threads_and_processes_give_the_same_table(tmp_path):
    expected = fd.sweep(GRID).column("e_mean")
    with ThreadPoolExecutor(2) as executor:
        assert fd.sweep(GRID, executor).column("e_mean") == expected
    with ProcessPoolExecutor(1) as executor:
        assert fd.sweep(GRID, executor, folder=tmp_path).column("e_mean") == expected


def test_dask_with_a_worker_that_is_killed_loses_nothing_and_doubles_nothing(tmp_path):
    distributed = pytest.importorskip("distributed")
    grid = fd.Grid(BASE.but(target__duration=3.0), {"control_rate": np.arange(50.0, 62.0).tolist()})
    expected = fd.sweep(grid)
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        victim = next(iter(client.run(os.getpid).values()))

        def kill_once(fraction):
            nonlocal victim
            if victim is not None:
                os.kill(victim, signal.SIGKILL)
                victim = None

        table = fd.sweep(grid, client.get_executor(), folder=tmp_path, progress=kill_once)
    assert victim is None
    assert [row.name for row in table.rows] == [row.name for row in expected.rows]
    assert table.column("e_max") == expected.column("e_max")
    assert len(list(tmp_path.glob("*.npz"))) == len(grid.options["control_rate"])
    assert not list(tmp_path.glob(".*.part*"))


def test_pictures(tmp_path):
    table = fd.sweep(GRID)
    heat = fd.plot_sweep(table, tmp_path / "sweep.png").axes[0]
    np.testing.assert_allclose(
        heat.images[0].get_array().T.ravel(), table.column("e_max"), rtol=1e-12
    )
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")
    line = fd.plot_sweep(fd.sweep(fd.Grid(BASE, {"target.duration": [0.2, 0.4]}))).axes[0]
    assert line.get_xlabel() == "target.duration"
    fd.plot_sweep(fd.sweep([BASE]))


def test_compare_tells_what_differs(tmp_path):
    a = fd.simulate(BASE)
    assert fd.compare(a, a).same
    b = fd.simulate(BASE.but(control_rate=100.0))
    found = fd.compare(a, b)
    assert not found.same and found.rows == len(a)
    at = np.searchsorted(np.rint(b.time * 1e6), np.rint(a.time * 1e6))
    assert found.largest["q"] == pytest.approx(np.abs(a.q - b.q[at]).max())
    text = str(found)
    for word in ("e_max", "control_rate: 50.0", "control_rate: 100.0", "q ", "CONVERGED"):
        assert word in text
    found.plot(tmp_path / "both.png")
    assert (tmp_path / "both.png").stat().st_size > 5000


def test_commands(tmp_path, capsys):
    (tmp_path / "base.yaml").write_text(BASE.to_yaml())
    (tmp_path / "grid.yaml").write_text(
        "base: base.yaml\ngrid:\n  controller.config.tolerance: [0.001, 0.01]\n"
    )
    folder = tmp_path / "runs"
    picture = tmp_path / "sweep.png"
    arguments = ["sweep", str(tmp_path / "grid.yaml"), "--folder", str(folder)]
    assert main([*arguments, "--plot", str(picture), "--csv", str(tmp_path / "t.csv")]) == 0
    assert "tolerance=0.01" in capsys.readouterr().out and picture.is_file()
    first, second = sorted(map(str, folder.glob("*.npz")))
    assert main(["compare", first, first]) == 0
    assert main(["compare", first, second]) == 1
    assert "tolerance: 0.01" in capsys.readouterr().out
    for text in ("base: base.yaml\n", "grid: {}\nbase: base.yaml\nmore: 1\n", "[\n"):
        (tmp_path / "bad.yaml").write_text(text)
        assert main(["sweep", str(tmp_path / "bad.yaml")]) == 2
        assert "bad.yaml" in capsys.readouterr().err


def test_a_model_file_that_has_changed_is_run_again(tmp_path):
    """Also one that another file names; a scenario, a version: whatever a log's numbers depend on."""
    urdf = fd.load_arm("planar2").to_urdf()
    (tmp_path / "mine.urdf").write_text(urdf)
    (tmp_path / "world.dmd.yaml").write_text(
        "directives:\n- add_model: {name: arm, file: mine.urdf}\n"
        "- add_weld: {parent: world, child: arm::base}\n".replace(
            "mine.urdf", "package://here/m.urdf"
        )
    )
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "package.xml").write_text("<package/>")
    (tmp_path / "here" / "world.dmd.yaml").write_text((tmp_path / "world.dmd.yaml").read_text())
    (tmp_path / "here" / "m.urdf").write_text(urdf)
    runs = {
        "urdf": BASE.but(robot=str(tmp_path / "mine.urdf")),
        "world": BASE.but(
            robot=fd.scenario.Model(str(tmp_path / "here/world.dmd.yaml"), "arm::tool")
        ),
        "table": BASE,
    }
    folder = tmp_path / "logs"

    def ran():
        return {row.name for row in fd.sweep(runs, folder=folder).rows if not np.isnan(row.seconds)}

    assert ran() == {"urdf", "world", "table"}
    assert ran() == set()
    shorter = urdf.replace("0.5 0 0", "0.4 0 0").replace("0.5 0.0 0.0", "0.4 0.0 0.0")
    assert shorter != urdf
    (tmp_path / "mine.urdf").write_text(shorter)
    assert ran() == {"urdf"}
    (tmp_path / "here" / "m.urdf").write_text(shorter)
    assert ran() == {"world"}
    log = fd.RunLog.load(folder / "table.npz")
    log.info.versions["drake"] = "1.0"
    log.save(folder / "table.npz")
    assert ran() == {"table"}
    assert ran() == set()
