"""Logs on disk: nothing lost, nothing foreign taken in."""

import csv
import dataclasses
import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fikm_drake import FuzzyIkConfig, TrackingLog, load_arm, simulate
from fikm_drake.simulation.tracking_log import series_names


def test_save_and_load_keep_every_number(any_log, tmp_path):
    path = tmp_path / "run.npz"
    any_log.save(path)
    again = TrackingLog.load(path)
    for name in series_names():
        ours, theirs = getattr(any_log, name), getattr(again, name)
        np.testing.assert_array_equal(theirs, ours)
        assert theirs.dtype == ours.dtype
    assert again.metrics() == any_log.metrics()
    assert again.scenario.load_arm().table == any_log.scenario.load_arm().table
    unarmed = dataclasses.replace(again.scenario, arm=any_log.scenario.arm)
    assert unarmed == any_log.scenario


def test_loaded_scenario_runs_to_the_same_log(planar_log, tmp_path):
    planar_log.save(tmp_path / "run.npz")
    again = simulate(TrackingLog.load(tmp_path / "run.npz").scenario)
    np.testing.assert_array_equal(again.q, planar_log.q)


def test_an_infinite_error_limit_survives_the_file(planar_log, tmp_path):
    config = FuzzyIkConfig(error_limit=np.inf)
    log = dataclasses.replace(
        planar_log, scenario=dataclasses.replace(planar_log.scenario, config=config)
    )
    log.save(tmp_path / "run.npz")
    assert TrackingLog.load(tmp_path / "run.npz").scenario.config.error_limit == np.inf


def test_log_outlives_the_arms_file(planar_log, tmp_path):
    from pydrake.common.yaml import yaml_dump_typed

    arm = tmp_path / "arm.yaml"
    arm.write_text(yaml_dump_typed(load_arm("planar2").table))
    scenario = dataclasses.replace(planar_log.scenario, arm=str(arm))
    dataclasses.replace(planar_log, scenario=scenario).save(tmp_path / "run.npz")
    arm.unlink()
    assert TrackingLog.load(tmp_path / "run.npz").scenario.load_arm().name == "planar2"


def test_file_name_is_the_given_one(planar_log, tmp_path):
    planar_log.save(tmp_path / "run.log")
    assert [path.name for path in tmp_path.iterdir()] == ["run.log"]
    TrackingLog.load(str(tmp_path / "run.log"))


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="gone"):
        TrackingLog.load(tmp_path / "gone.npz")


def test_folder_that_is_not_there_is_an_os_error(planar_log, tmp_path):
    for write in (planar_log.save, planar_log.to_csv):
        with pytest.raises(OSError, match="gone"):
            write(tmp_path / "gone" / "run")


@pytest.fixture(scope="module")
def stored(planar_log, tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.npz"
    planar_log.save(path)
    return path.read_bytes()


def load_bytes(folder, data):
    path = folder / "damaged.npz"
    path.write_bytes(data)
    return TrackingLog.load(path)


def test_truncated_files_raise_value_error_that_names_the_file(stored, tmp_path):
    for length in [*range(0, 100), *np.linspace(100, len(stored) - 1, 150, dtype=int)]:
        with pytest.raises(ValueError, match="damaged.npz"):
            load_bytes(tmp_path, stored[:length])


@settings(max_examples=300)
@given(data=st.data())
def test_flipped_bits_raise_value_error_or_harm_nothing(data, stored, tmp_path_factory, planar_log):
    damaged = bytearray(stored)
    damaged[data.draw(st.integers(0, len(stored) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    try:
        log = load_bytes(tmp_path_factory.getbasetemp(), bytes(damaged))
    except ValueError as error:
        assert "damaged.npz" in str(error)
    else:  # a byte that means nothing, such as a date
        for name in series_names():
            np.testing.assert_array_equal(getattr(log, name), getattr(planar_log, name))


def contents(stored):
    with np.load(io.BytesIO(stored)) as file:
        return {name: file[name] for name in file.files}


def packed(**arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"time,gain\n0,1\n",
        packed(x=np.zeros(3)),
        packed(format="another/1", scenario="", time=np.zeros(3)),
        packed(format=np.array([{"a": 1}], dtype=object)),
    ],
    ids=["empty", "csv", "another npz", "another format", "pickle"],
)
def test_foreign_files_raise_value_error(data, tmp_path):
    with pytest.raises(ValueError, match="damaged.npz"):
        load_bytes(tmp_path, data)


def test_plain_npy_is_foreign(tmp_path):
    buffer = io.BytesIO()
    np.save(buffer, np.zeros(3))
    with pytest.raises(ValueError, match="damaged.npz"):
        load_bytes(tmp_path, buffer.getvalue())


def test_directory_is_not_a_log(tmp_path):
    with pytest.raises(ValueError, match="not a tracking log"):
        TrackingLog.load(tmp_path)


@pytest.mark.parametrize("missing", ["format", "scenario", *series_names()])
def test_missing_keys_are_named(missing, stored, tmp_path):
    arrays = contents(stored)
    del arrays[missing]
    with pytest.raises(ValueError, match=missing):
        load_bytes(tmp_path, packed(**arrays))


@pytest.mark.parametrize("name", series_names())
def test_series_of_another_length_are_named(name, stored, tmp_path):
    arrays = contents(stored)
    arrays[name] = arrays[name][:-1]
    with pytest.raises(ValueError, match="shape"):
        load_bytes(tmp_path, packed(**arrays))


@pytest.mark.parametrize("name", series_names())
def test_series_that_are_not_numbers_are_refused(name, stored, tmp_path):
    arrays = contents(stored)
    for wrong in (arrays[name].astype(str), arrays[name].astype(complex)):
        arrays[name] = wrong
        with pytest.raises(ValueError, match=name):
            load_bytes(tmp_path, packed(**arrays))


@pytest.mark.parametrize(
    "text", ["", "][", "arm: planar2\n", "arm: gone.yaml\nwaypoints: [[1, 0]]\n"]
)
def test_damaged_scenarios_raise_value_error(text, stored, tmp_path):
    arrays = contents(stored)
    arrays["scenario"] = np.array(text)
    with pytest.raises(ValueError, match="damaged.npz"):
        load_bytes(tmp_path, packed(**arrays))


def test_joints_of_another_arm_are_refused(stored, tmp_path):
    arrays = contents(stored)
    for name in ("q", "joint_step"):
        arrays[name] = np.zeros((len(arrays["time"]), 5))
    with pytest.raises(ValueError, match=r"5.*expected.*2"):
        load_bytes(tmp_path, packed(**arrays))


def test_csv_header_and_numbers(any_log, tmp_path):
    path = tmp_path / "run.csv"
    any_log.to_csv(path)
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    axes = "xyz"[: any_log.desired.shape[1]]
    joints = [f"{i}_rad" for i in range(1, any_log.q.shape[1] + 1)]
    assert header == [
        "time_s",
        *(f"{name}_{axis}_m" for name in ("desired", "actual", "error") for axis in axes),
        *(f"{name}_{joint}" for name in ("q", "joint_step") for joint in joints),
        "gain",
        "oscillating",
        "status",
    ]
    numbers = np.array(rows, dtype=float)
    order = ["time", "desired", "actual", "error", "q", "joint_step", "gain"]
    expected = np.column_stack([*(getattr(any_log, name) for name in order)])
    np.testing.assert_array_equal(numbers[:, :-2], expected)  # every digit
    np.testing.assert_array_equal(numbers[:, -2], any_log.oscillating)
    np.testing.assert_array_equal(numbers[:, -1], any_log.status)
    assert rows[0][-1].isdigit()


def test_csv_of_a_prismatic_joint_says_m(tmp_path):
    from fikm_drake import DhJoint, DhTable, TrackingScenario

    table = DhTable(
        "slide", joints=[DhJoint(), DhJoint(alpha=1.5707963267948966, type="prismatic", d=0.5)]
    )
    log = simulate(TrackingScenario(table, [[0.0, -0.5]], hold=0.1))
    log.to_csv(tmp_path / "run.csv")
    header = (tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    assert {"q_1_rad", "q_2_m", "joint_step_1_rad", "joint_step_2_m"} <= set(header)
