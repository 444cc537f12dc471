"""Logs on disk: nothing lost, nothing foreign taken in, nothing large made of something small."""

import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
import tracemalloc
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fikm_drake as fd
from fikm_drake import FuzzyIkConfig, RunLog, load_arm, simulate
from fikm_drake.simulation import log_file
from fikm_drake.simulation.log_info import FORMAT


def assert_same(ours, theirs):
    np.testing.assert_array_equal(theirs.time, ours.time)
    assert theirs.names == ours.names
    for name in ours.names:
        np.testing.assert_array_equal(theirs[name], ours[name])


def test_save_and_load_keep_every_number_and_the_head(any_log, tmp_path):
    any_log.save(tmp_path / "run.npz")
    again = RunLog.load(tmp_path / "run.npz")
    assert_same(any_log, again)
    assert again.info == any_log.info
    assert again.metrics() == any_log.metrics()
    assert again.scenario == any_log.scenario
    assert again.status_names == [fd.ControllerStatus(s).name for s in any_log.status]
    assert {"fikm_drake", "drake", "numpy", "python"} <= set(again.info.versions)


def test_numpy_reads_it_too(planar_log, tmp_path):
    planar_log.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as file:
        np.testing.assert_array_equal(file["q"], planar_log.q)
        np.testing.assert_array_equal(file["time"], planar_log.time)
        assert json.loads(file["info.json"])["format"] == FORMAT


def test_loaded_scenario_runs_to_the_same_log(planar_log, tmp_path):
    planar_log.save(tmp_path / "run.npz")
    assert_same(planar_log, simulate(RunLog.load(tmp_path / "run.npz").scenario))


def test_the_law_is_kept_by_its_text(tmp_path):
    scenario = fd.TrackingScenario("planar2", [[1.3, 0.4]], hold=0.1)
    log = simulate(scenario, law=fd.PseudoInverse())
    log.save(tmp_path / "run.npz")
    assert "PseudoInverse" in RunLog.load(tmp_path / "run.npz").info.law


def test_an_infinite_error_limit_survives_the_file(tmp_path):
    scenario = fd.TrackingScenario(
        "planar2", [[1.3, 0.4]], hold=0.1, config=FuzzyIkConfig(error_limit=np.inf)
    )
    simulate(scenario).save(tmp_path / "run.npz")
    config = RunLog.load(tmp_path / "run.npz").scenario.controller_config()
    assert config.error_limit == np.inf


def test_log_outlives_the_arms_file(tmp_path):
    from pydrake.common.yaml import yaml_dump_typed

    arm = tmp_path / "arm.yaml"
    arm.write_text(yaml_dump_typed(load_arm("planar2").table))
    simulate(fd.TrackingScenario(str(arm), [[1.3, 0.4]], hold=0.1)).save(tmp_path / "run.npz")
    arm.unlink()
    assert RunLog.load(tmp_path / "run.npz").scenario.load_arm().name == "planar2"


def test_file_name_is_the_given_one(planar_log, tmp_path):
    planar_log.save(tmp_path / "run.log")
    assert [path.name for path in tmp_path.iterdir()] == ["run.log"]
    RunLog.load(str(tmp_path / "run.log"))


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="gone"):
        RunLog.load(tmp_path / "gone.npz")


@pytest.fixture(scope="module")
def stored(planar_log, tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.npz"
    planar_log.save(path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def growing(planar_log, tmp_path_factory):
    """The bytes of a file that has grown by blocks of two rows."""
    path = tmp_path_factory.mktemp("log") / "run.npz"
    file = log_file.GrowingLog(path, planar_log.info)
    table = np.column_stack([planar_log.time, *(planar_log[n] for n in planar_log.names)])
    for k, row in enumerate(table):
        file.append(row)
        if k % 2:
            file.flush()
    file.close()
    return path.read_bytes()


def load_bytes(folder, data):
    path = folder / "damaged.npz"
    path.write_bytes(data)
    return RunLog.load(path)


def test_truncated_files_raise_value_error_that_names_the_file(stored, tmp_path):
    for length in [*range(0, 100, 7), *np.linspace(100, len(stored) - 1, 60, dtype=int)]:
        with pytest.raises(ValueError, match="damaged.npz"):
            load_bytes(tmp_path, stored[:length])


@settings(max_examples=150)
@given(data=st.data())
def test_flipped_bits_raise_value_error_or_harm_nothing(
    data, stored, growing, tmp_path_factory, planar_log
):
    damaged = bytearray(data.draw(st.sampled_from([stored, growing])))
    damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    try:
        log = load_bytes(tmp_path_factory.getbasetemp(), bytes(damaged))
    except ValueError as error:
        assert "damaged.npz" in str(error)
    else:  # a byte that means nothing, such as a date; or the last block is lost
        assert_same(planar_log.rows(slice(0, len(log))), log)
        assert len(log) == len(planar_log) or log.info.ended  # it says that rows are missing


def test_a_growing_file_can_be_read_wherever_it_ends(growing, planar_log, tmp_path):
    head = growing.index(b"}", growing.index(b"ended")) + 1
    lengths = set()
    for length in np.linspace(head + 200, len(growing), 80, dtype=int):
        try:
            log = load_bytes(tmp_path, growing[:length])
        except ValueError:  # not one whole block yet
            continue
        lengths.add(len(log))
        assert_same(planar_log.rows(slice(0, len(log))), log)
        assert log.info.ended
    assert len(lengths) > 5 and max(lengths) >= len(planar_log) - 1


def test_a_growing_file_whose_middle_is_damaged_is_refused(growing, tmp_path):
    damaged = bytearray(growing)
    damaged[-2000] ^= 1
    with pytest.raises(ValueError, match="block"):
        load_bytes(tmp_path, bytes(damaged))


def packed(members, method=zipfile.ZIP_STORED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return buffer.getvalue()


def members_of(stored):
    with zipfile.ZipFile(io.BytesIO(stored)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def test_foreign_files_raise_value_error(stored, tmp_path):
    pickled = io.BytesIO()
    np.savez(pickled, info=np.array([{"a": 1}], dtype=object))
    plain = io.BytesIO()
    np.savez(plain, x=np.zeros(3))
    foreign = [b"", b"time,gain\n0,1\n", pickled.getvalue(), plain.getvalue(), npy(np.zeros(3))]
    for data in foreign:
        with pytest.raises(ValueError, match="damaged.npz"):
            load_bytes(tmp_path, data)
    with pytest.raises(ValueError, match="not a log"):
        RunLog.load(tmp_path)


def test_inflated_files_are_refused_at_once_without_their_memory(stored, tmp_path):
    bomb = packed(members_of(stored) | {"q.npy": npy(np.zeros(8_000_000))}, zipfile.ZIP_DEFLATED)
    lying = members_of(stored)
    lying["q.npy"] = npy(np.zeros((1, 2))).replace(b"(1, 2)", b"(99999999, 2)"[:6].ljust(6))
    header = npy(np.zeros((16, 2)))
    lying["q.npy"] = header.replace(b"(16, 2), }      ", b"(16000000, 2), }")
    for data in (bomb, packed(lying)):
        tracemalloc.start()
        start = time.process_time()
        with pytest.raises(ValueError, match="damaged.npz"):
            load_bytes(tmp_path, data)
        assert time.process_time() - start < 0.25
        assert tracemalloc.get_traced_memory()[1] < 4_000_000
        tracemalloc.stop()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_times_must_be_finite_and_increase(bad, stored, planar_log, tmp_path):
    times = planar_log.time.copy()
    times[3] = bad
    with pytest.raises(ValueError, match="times"):
        load_bytes(tmp_path, packed(members_of(stored) | {"time.npy": npy(times)}))
    with pytest.raises(ValueError, match="time"):
        RunLog(times, {"q": planar_log.q})


def test_wrong_members_are_named(stored, planar_log, tmp_path):
    members = members_of(stored)
    for name in members:
        rest = {key: value for key, value in members.items() if key != name}
        with pytest.raises(ValueError, match=name.split(".")[0]):
            load_bytes(tmp_path, packed(rest))
    for wrong in (planar_log.q[:-1], planar_log.q.astype(str), planar_log.q.astype(complex)):
        with pytest.raises(ValueError, match="q is"):
            load_bytes(tmp_path, packed(members | {"q.npy": npy(wrong)}))
    with pytest.raises(ValueError, match="extra"):
        load_bytes(tmp_path, packed(members | {"extra.npy": npy(planar_log.q)}))


@pytest.mark.parametrize("text", ["][", "robot: planar2\n", "arm: gone.yaml\n"])
def test_damaged_scenarios_raise_value_error(text, planar_log):
    log = planar_log.replace()
    log.info.scenario = text
    with pytest.raises(ValueError, match="scenario"):
        log.metrics()


def test_csv_header_and_numbers(any_log, tmp_path):
    path = tmp_path / "run.csv"
    any_log.to_csv(path)
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    axes = "xyz"[: any_log.desired.shape[1]]
    n = any_log.q.shape[1]
    points = ("desired", "actual", "error_before", "error_after")
    assert header == [
        "time_s",
        *(f"{name}_{axis}_m" for name in points for axis in axes),
        *(f"{name}_{i}_rad" for name in ("q", "command") for i in range(1, n + 1)),
        *(f"velocity_{i}_radps" for i in range(1, n + 1)),
        *(f"joint_step_{i}_rad" for i in range(1, n + 1)),
        "gain",
        "oscillating",
        "status",
        "status_name",
    ]
    numbers = np.array([row[:-1] for row in rows], dtype=float)
    expected = np.column_stack([any_log.time, *(any_log[name] for name in any_log.names)])
    np.testing.assert_array_equal(numbers, expected)  # every digit
    assert [row[-1] for row in rows] == any_log.status_names


def test_dataframe_has_the_columns_of_the_csv(any_log, tmp_path):
    pandas = pytest.importorskip("pandas")
    any_log.to_csv(tmp_path / "run.csv")
    read = pandas.read_csv(tmp_path / "run.csv", index_col="time_s")
    frame = any_log.to_dataframe()
    assert list(frame.columns) == list(read.columns)
    np.testing.assert_array_equal(frame.index, read.index)
    np.testing.assert_array_equal(frame["q_1_rad"], any_log.q[:, 0])
    assert list(frame["status_name"]) == any_log.status_names


def test_csv_of_a_prismatic_joint_says_m(tmp_path):
    table = fd.DhTable(
        "slide",
        joints=[fd.DhJoint(), fd.DhJoint(alpha=1.5707963267948966, type="prismatic", d=0.5)],
    )
    simulate(fd.TrackingScenario(table, [[0.0, -0.5]], hold=0.1)).to_csv(tmp_path / "run.csv")
    header = (tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    assert {"q_1_rad", "q_2_m", "joint_step_1_rad", "joint_step_2_m", "velocity_2_mps"} <= {*header}


RUN = """
import sys, fikm_drake as fd
scenario = fd.TrackingScenario("planar2", [[1.5, 0.0], [0.0, 1.5]], duration=1e6, hold=0.0)
fd.simulate(scenario, file=sys.argv[1])
"""


def test_kill_9_leaves_a_log_up_to_the_last_second(tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(b"old")
    process = subprocess.Popen([sys.executable, "-c", RUN, str(path)])
    try:
        deadline = time.monotonic() + 120
        while path.stat().st_size < 100_000 and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(1.0)
        before = len(RunLog.load(path))
        time.sleep(1.2)
        os.kill(process.pid, signal.SIGKILL)
    finally:
        process.kill()
        process.wait()
    log = RunLog.load(path)
    assert len(log) > before > 100
    assert "process ended" in log.info.ended
    np.testing.assert_allclose(log.time, np.arange(len(log)) / 50.0)
    assert log.metrics().e_max < 0.5
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]
