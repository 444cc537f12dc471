"""`fikm-drake run --meshcat`: a server on a free port, a page that is served, a run that ends."""

import re
import socket
import subprocess
import sys
import urllib.request

import pytest
from pydrake.geometry import Meshcat

import fikm_drake as fd
from fikm_drake.cli import run
from fikm_drake.simulation.scenario import Obstacle, Path, Scenario

SCENARIO = """\
robot: planar2
target: {positions: [[1.5, 0.0], [0.0, 1.5]], duration: 1.5, hold: 0.0}
obstacles: [{xyz: [-1.0, 0.0, 0.0], radius: 0.2, name: ball}]
"""


def start(tmp_path, *more):
    scenario = tmp_path / "mine.yaml"
    scenario.write_text(SCENARIO)
    command = [sys.executable, "-m", "fikm_drake.cli", "run", str(scenario), "--meshcat", *more]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def address(process):
    """What the command tells to open, read while it runs."""
    for line in process.stderr:
        if found := re.search(r"open (http://\S+)", line):
            return found[1]
    raise AssertionError("no address was told")


def test_pages_are_served_beside_each_other_and_the_runs_end(tmp_path):
    other = Meshcat()  # takes the first free port
    log = tmp_path / "run.npz"
    process = start(tmp_path, "--log", str(log))
    try:
        url = address(process)
        assert url != other.web_url()
        with urllib.request.urlopen(url, timeout=30) as page:
            text = page.read().decode("utf-8")
        assert "<html" in text.lower() and "meshcat" in text.lower()
        out, _ = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 0 and "e_max" in out
    assert len(fd.RunLog.load(log)) == 76
    port = int(url.rsplit(":", 1)[1].strip("/"))
    with socket.socket() as probe:  # nothing is left behind
        assert probe.connect_ex(("127.0.0.1", port)) != 0


def test_a_person_gets_time_to_open_the_page(monkeypatch, capsys):
    monkeypatch.setattr(run.sys.stdin, "isatty", lambda: True, raising=False)
    seen = []
    monkeypatch.setattr(run.time, "sleep", seen.append)
    monkeypatch.setattr(run, "PATIENCE", 0.05)
    assert isinstance(run._meshcat(True), Meshcat)
    assert seen and "the run begins when the page is open" in capsys.readouterr().err
    assert run._meshcat(False) is None


def test_the_page_shows_robot_and_obstacles():
    meshcat = Meshcat()
    scenario = Scenario(
        robot="planar2",
        target=Path(positions=[[1.5, 0.0]], hold=0.1),
        obstacles=[Obstacle([-1.0, 0.0, 0.0], radius=0.2, name="ball")],
    )
    fd.simulate(scenario, meshcat=meshcat)
    html = meshcat.StaticHtml()
    assert meshcat.HasPath("visualizer")
    assert len(html) > len(Meshcat().StaticHtml()) + 1000
    assert any(meshcat.HasPath(f"visualizer/{name}") for name in ("ball", "DefaultModelInstance"))


@pytest.mark.parametrize("what", ["gone", "mine.yaml"])
def test_a_bad_scenario_ends_before_a_server_starts(what, tmp_path):
    (tmp_path / "mine.yaml").write_text("robot: planar2\n")
    name = str(tmp_path / what) if what.endswith("yaml") else what
    done = subprocess.run(
        [sys.executable, "-m", "fikm_drake.cli", "run", name, "--meshcat"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2 and "open http" not in done.stderr
