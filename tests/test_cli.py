"""The command: what it prints, what it writes, what it exits with."""

import functools
import re
import subprocess
import sys

import pytest

from fikm_drake import RunLog, load_arm
from fikm_drake.cli import main, models, run
from fikm_drake.cli.shared import progress
from fikm_drake.experiments.benchmarks import batch_benchmark
from fikm_drake.experiments.benchmarks.benchmark_page import section
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.resources import find_model, model_names

SCENARIO = "arm: planar2\nwaypoints: [[1.5, 0.0], [1.3, 0.4]]\nduration: 0.3\nhold: 0.1\n"


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "short.yaml"
    path.write_text(SCENARIO)
    return str(path)


def test_models_lists_arms_scenarios_and_fuzzy_systems(capsys):
    assert main(["models"]) == 0
    out = capsys.readouterr().out
    for name in [*model_names(), *model_names("scenarios"), *model_names("fuzzy")]:
        assert name in out
    assert "7 joints" in out and "standard convention" in out


def test_urdf_prints_the_arms_urdf(capsys):
    assert main(["urdf", "panda"]) == 0
    assert capsys.readouterr().out == load_arm("panda").to_urdf()


def test_run_prints_the_metrics(scenario, capsys):
    assert main(["run", scenario]) == 0
    out = capsys.readouterr().out
    for word in (scenario, "e_max", "e_mean", "e_ss", "cm", "distance from the path", "at the end"):
        assert word in out


def test_run_of_our_own_scenario_by_name(capsys):
    assert main(["run", "large_step_2"]) == 0
    assert "converged at the end" in capsys.readouterr().out


def test_run_writes_every_file(scenario, tmp_path, capsys):
    files = {"log": "run.npz", "csv": "run.csv", "plot": "run.png", "html": "run.html"}
    options = [word for name, file in files.items() for word in (f"--{name}", str(tmp_path / file))]
    assert main(["run", scenario, *options]) == 0
    captured = capsys.readouterr()
    for file in files.values():
        assert (tmp_path / file).stat().st_size > 1000
        assert f"wrote {tmp_path / file}" in captured.err
    log = RunLog.load(tmp_path / "run.npz")
    assert len(log.time) == 21
    assert str(log.metrics()) in captured.out
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "run.csv").read_text().splitlines()) == 22


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["run", "table7"], ["'table7'", "table6_10s", "large_step_2"]),
        (["run", "gone.yaml"], ["gone.yaml"]),
        (["urdf", "pandaa"], ["'pandaa'", "panda", "arm7"]),
        (["urdf", "gone.yaml"], ["gone.yaml"]),
    ],
)
def test_bad_names_exit_with_2_and_list_the_good_ones(arguments, words, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    for word in words:
        assert word in captured.err
    assert "Traceback" not in captured.err


@pytest.mark.parametrize("text", ["", "- 1\n", SCENARIO + "speed: 1\n", "arm: [\n"])
def test_bad_scenario_exits_with_2_and_names_the_file(text, tmp_path, capsys):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    assert main(["run", str(path)]) == 2
    assert "bad.yaml" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["fly"],
        ["run"],
        ["urdf"],
        ["run", "a", "--speed", "1"],
        ["benchmark"],
        ["benchmark", "step", "--rounds", "0"],
        ["benchmark", "step", "--rounds", "many"],
    ],
)
def test_bad_arguments_exit_with_2(arguments, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert "usage" in capsys.readouterr().err


def test_help_tells_the_exit_codes(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--help"])
    assert stopped.value.code == 0
    out = capsys.readouterr().out
    for word in ("run", "urdf", "models", "benchmark", "exit codes", "130"):
        assert word in out


@pytest.mark.parametrize("option", ["--log", "--csv", "--plot", "--html"])
def test_missing_folder_exits_with_1_before_the_run(
    option, scenario, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(run, "simulate", lambda *_, **__: pytest.fail("it ran"))
    path = str(tmp_path / "gone" / "run")
    assert main(["run", scenario, option, path]) == 1
    assert path in capsys.readouterr().err


def test_a_file_that_cannot_be_written_exits_with_1_and_the_others_are_written(
    scenario, tmp_path, capsys
):
    folder, picture, page = tmp_path / "folder", tmp_path / "run.xyz", tmp_path / "run.html"
    folder.mkdir()
    table = tmp_path / "run.csv"
    options = ["--log", folder, "--csv", table, "--plot", picture, "--html", page]
    assert main(["run", scenario, *map(str, options)]) == 1
    captured = capsys.readouterr()
    assert f"cannot write {folder}" in captured.err
    assert f"cannot write {picture}" in captured.err
    assert table.is_file() and page.is_file()
    assert "e_max" in captured.out


@pytest.mark.parametrize("reason, code", [(KeyboardInterrupt(), 130), (RuntimeError("oh"), 1)])
def test_interrupted_run_keeps_its_log(reason, code, scenario, tmp_path, capsys, monkeypatch):
    def stop_half_way():
        def progress(fraction):
            if fraction >= 0.5:
                raise reason

        return progress

    monkeypatch.setattr(run, "progress", stop_half_way)
    assert main(["run", scenario, "--log", str(tmp_path / "run.npz")]) == code
    captured = capsys.readouterr()
    assert "stopped after" in captured.err
    assert 0 < len(RunLog.load(tmp_path / "run.npz").time) < 20
    assert "e_max" in captured.out


def test_interruption_elsewhere_exits_with_130(monkeypatch):
    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(models, "load_arm", interrupt)
    assert main(["urdf", "panda"]) == 130


def test_progress_shows_only_to_a_patient_person(capsys, monkeypatch):
    show = progress(patience=0.0)
    show(0.5)
    assert capsys.readouterr().err == ""  # no terminal
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    show(0.5)
    show(1.0)
    err = capsys.readouterr().err
    assert "50 %" in err and "100 %, 0 s left" in err and err.endswith("\n")
    progress(patience=60.0)(0.5)
    assert capsys.readouterr().err == ""


def test_benchmark_prints_the_costs(capsys):
    assert main(["benchmark", "step", "--rounds", "1"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if "µs" in line]
    assert len(rows) >= 3
    assert all(float(number) > 0 for row in rows for number in re.findall(r"\d+\.\d+", row))


def test_python_m_runs_the_command():
    done = subprocess.run(
        [sys.executable, "-m", "fikm_drake.cli", "models"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "arm7" in done.stdout
    done = subprocess.run(
        [sys.executable, "-m", "fikm_drake.cli", "urdf", "nope"], capture_output=True, timeout=120
    )
    assert done.returncode == 2


def test_benchmark_batch_prints_success_and_time(capsys, monkeypatch):
    small = functools.partial(batch_benchmark.batch_benchmark, poses=10, arms=["iiwa14"])
    monkeypatch.setattr(batch_benchmark, "batch_benchmark", small)
    assert main(["benchmark", "batch", "--rounds", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("Solver, numpy") == 8
    assert "100.000 %" in printed and "inside limits" in printed


def test_all_benchmarks_as_markdown(capsys):
    chosen = ["--only", "cycle", "step", "--count", "1"]
    assert main(["benchmark", "all", "--markdown", *chosen]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("# Benchmarks\n")
    assert re.search(r"^Python 3\.\d+\.\d+, drake .*, numpy .*; .* processors", printed, re.M)
    assert "`fikm-drake benchmark cycle --rounds 1`; nothing is random." in printed
    assert "| rows | whole | name | microseconds | ratio |" in printed
    assert "| name | microseconds | to usual | to least |" in printed
    assert printed.count("| pseudo-inverse |") == 4
    assert "*to usual*: " in printed  # the meaning of a column


def test_benchmarks_as_a_page(tmp_path, capsys):
    page = tmp_path / "page.md"
    assert main(["benchmark", "all", "--page", str(page), "--only", "frmrc", "--count", "1"]) == 0
    written = page.read_text("utf-8")
    assert written == capsys.readouterr().out
    assert "## frmrc: " in written and "| damped least squares |" in written
    assert main(["benchmark", "all", "--page", "/nowhere/page.md", "--only", "frmrc"]) != 0


def test_a_page_sums_up_long_tables():
    row = {"arm": "panda", "error": 0.25}
    short = section("calm", 150, BenchmarkTable(["summed up"], [row] * 60))
    assert (
        short.count("| panda | 0.25 |") == 60 and "`fikm-drake benchmark calm --runs 150`" in short
    )
    assert "```text\nsummed up\n```" in section(
        "calm", 150, BenchmarkTable(["summed up"], [row] * 61)
    )


def test_benchmark_many_and_single(capsys):
    assert main(["benchmark", "many", "--poses", "20"]) == 0
    printed = capsys.readouterr().out
    assert printed.count(" 77 ") == 7 and "iiwa14       1000" in printed
    assert main(["benchmark", "single", "--rounds", "1"]) == 0
    printed = capsys.readouterr().out
    assert "pose at limits, panda" in printed and printed.count("100.0 %") == 4


def test_benchmark_poses_prints_each_law(capsys):
    assert main(["benchmark", "poses", "--poses", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.count(" of 1 poses") >= 6
    assert "damped least squares" in printed and "rad/s" in printed


def test_benchmark_frmrc_prints_batch_and_step(capsys):
    assert main(["benchmark", "frmrc", "--rounds", "1"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("smooth, 3 sweeps") == 3 and "one by one" in printed


def test_export_c_of_ones_own_arm(tmp_path, capsys):
    plane = "origin: [0.35, 0.2, 0.15]\nyaw: -1.5707963267948966\nsize: [200, 150]\n"
    (tmp_path / "plane.yaml").write_text(plane, encoding="utf-8")
    arm = tmp_path / "puma.yaml"
    arm.write_text(find_model("puma560").read_text("utf-8"), encoding="utf-8")
    start = ["0", "29", "-143", "0", "29", "0"]
    command = ["export-c", str(tmp_path / "puma.c"), "--arm", str(arm), "--labels", "4", "3"]
    command += ["--workplane", str(tmp_path / "plane.yaml"), "--conjunction", "product"]
    assert main([*command, "--start", *start]) == 0
    assert "12 rules, 6 joints" in capsys.readouterr().out
    assert "4 x 3 rules, AND = product" in (tmp_path / "puma.c").read_text("utf-8")
    assert main(["export-c", str(tmp_path / "a.c"), "--start", "1"]) == 2
    assert "--arm" in capsys.readouterr().err
