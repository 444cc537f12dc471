"""How a run ends: SIGTERM, Ctrl-C, a full disk, folders that cannot be written, options on the line."""

import json
import os
import resource
import signal
import subprocess
import sys
import time

import pytest

import fikm_drake as fd
from fikm_drake.cli import main

LONG = """\
robot: planar2
target: {positions: [[1.5, 0.0], [0.0, 1.5]], duration: 1.0e+6, hold: 0.0}
controller: {config: {fused: true}}
"""


@pytest.mark.parametrize("number, code", [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_ends_a_run_with_its_log_up_to_the_last_cycle(number, code, tmp_path):
    scenario, log = tmp_path / "long.yaml", tmp_path / "run.npz"
    scenario.write_text(LONG)
    command = [sys.executable, "-m", "fikm_drake.cli", "run", str(scenario), "--log", str(log)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 120
        while not log.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        before = len(fd.RunLog.load(log))
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == code
    assert "stopped after" in err and "e_max" in out
    found = fd.RunLog.load(log)
    assert len(found) > before and found.info.ended
    assert [path.name for path in tmp_path.iterdir()] in (
        ["long.yaml", "run.npz"],
        ["run.npz", "long.yaml"],
    )


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_sweep_that_is_ended_exits_with_143_and_goes_on_where_it_was(jobs, tmp_path):
    (tmp_path / "mine.yaml").write_text(LONG.replace("1.0e+6", "0.4"))
    (tmp_path / "grid.yaml").write_text("base: mine.yaml\ngrid: {target.duration: [0.5, 1.0e+6]}\n")
    folder = tmp_path / "logs"
    command = [sys.executable, "-m", "fikm_drake.cli", "sweep", str(tmp_path / "grid.yaml")]
    command += ["--folder", str(folder), "--jobs", jobs]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 120
        while len(list(folder.glob("*.npz"))) < 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)  # it does not wait for the endless run
    finally:
        process.kill()
    assert process.returncode == 143 and "Traceback" not in err
    logs = {path.name: fd.RunLog.load(path) for path in folder.glob("*.npz")}
    ended = {name: bool(log.info.ended) for name, log in logs.items()}
    assert ended == {"duration=0.5.npz": False, "duration=1e+06.npz": True}
    base = fd.load_scenario(tmp_path / "mine.yaml")
    again = fd.sweep(fd.Grid(base, {"target.duration": [0.5, 1.0]}), folder=folder)
    first, second = again.column("seconds")
    assert first != first and second > 0.0  # NaN: it was there already


def test_a_disk_that_fills_up_exits_with_1_and_leaves_what_was_there(tmp_path):
    scenario, log = tmp_path / "mine.yaml", tmp_path / "run.npz"
    scenario.write_text(LONG.replace("1.0e+6", "20.0"))
    log.write_bytes(b"old")
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
        sys.stdout = sys.stderr = open(os.devnull, "w")
        code = main(["run", str(scenario), "--log", str(log)])
        os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1
    assert log.read_bytes() == b"old"
    assert {path.name for path in tmp_path.iterdir()} == {"mine.yaml", "run.npz"}


def test_options_on_the_line(tmp_path, capsys):
    scenario, log = tmp_path / "mine.yaml", tmp_path / "run.npz"
    scenario.write_text(LONG.replace("1.0e+6", "0.5"))
    changes = ["--set", "target.duration=0.2", "--set", "controller=!Frmrc {sweeps: 2}"]
    assert main(["run", str(scenario), "--set", "target.duration=0.2", "--log", str(log)]) == 0
    assert fd.RunLog.load(log).scenario.target.duration == 0.2
    assert main(["run", str(scenario), "--set", "controller=frmrc"]) == 0
    assert main(["run", str(scenario), *changes[:2], "--set", "speed=1"]) == 2
    assert "no option 'speed'" in capsys.readouterr().err
    assert main(["run", str(scenario), "--set", "speed"]) == 2


def test_teleop_runs_and_logs_without_a_browser(tmp_path, capsys):
    log = tmp_path / "run.npz"
    assert main(["teleop", "planar4", "--seconds", "0.2", "--log", str(log)]) == 0
    found = fd.RunLog.load(log)
    assert len(found) == 21 and set(found.status_names) <= {"CONVERGED", "TRACKING"}
    assert "open http" in capsys.readouterr().out
    assert main(["teleop", "planar4", "--frame", "hand"]) == 2
    assert main(["teleop", "planar4", "--log", str(tmp_path / "gone" / "run.npz")]) == 1
    assert "no such folder" in capsys.readouterr().err


@pytest.mark.parametrize("number, code", [(signal.SIGTERM, 143), (signal.SIGINT, 0)])
def test_teleop_keeps_its_log_when_it_is_ended(number, code, tmp_path):
    log = tmp_path / "run.npz"
    command = [sys.executable, "-m", "fikm_drake.cli", "teleop", "planar4", "--log", str(log)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 120
        while not log.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == code, err
    assert "rows" in out and len(fd.RunLog.load(log)) > 10


def test_teleop_follows_the_sliders(tmp_path):
    import numpy as np

    teleop = fd.Teleop("panda")
    meshcat = teleop.meshcat
    start = meshcat.GetSliderValue("z")
    meshcat.SetSliderValue("z", start - 0.1)
    log = teleop.run(seconds=2.0)
    np.testing.assert_allclose(log.desired[-1, 6], start - 0.1, atol=0.006)
    np.testing.assert_allclose(log.actual[-1, 4:], log.desired[-1, 4:], atol=2e-3)
    assert log.status_names[-1] == "CONVERGED"
    assert np.abs(np.diff(log.q, axis=0)).max() <= 1.5 / 100 + 1e-9


def test_json_is_alone_on_the_standard_output(tmp_path):
    """Drake's solver writes lines of its own there, beside Python."""
    (tmp_path / "mine.yaml").write_text(
        "robot: iiwa14\ncontroller: supervised_drake\n"
        "target: {poses: [{xyz: [0.5, 0, 0.5], rpy: [0, 3, 0]}], hold: 1.0}\n"
    )
    (tmp_path / "grid.yaml").write_text("base: mine.yaml\ngrid: {target.hold: [0.5, 1.0]}\n")
    for arguments in (["run", "mine.yaml"], ["sweep", "grid.yaml", "--jobs", "2"]):
        command = [sys.executable, "-m", "fikm_drake.cli", *arguments, "--json"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)
        assert "Allocating" not in done.stderr
