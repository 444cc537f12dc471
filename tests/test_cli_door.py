"""The command for programs and shells: --version, --json, completion."""

import json
import shutil
import subprocess
import sys

import pytest

import fikm_drake
from fikm_drake.cli import main
from fikm_drake.resources import model_names

SCENARIO = "arm: planar2\nwaypoints: [[1.5, 0.0], [1.3, 0.4]]\nduration: 0.2\nhold: 0.1\n"


def test_version_names_ours_and_what_results_depend_on(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--version"])
    out = capsys.readouterr().out
    assert stopped.value.code == 0
    assert out.startswith(f"fikm-drake {fikm_drake.__version__} (drake ")
    assert "numpy" in out and f"Python {sys.version.split()[0]}" in out


def test_models_as_json(capsys):
    assert main(["models", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found["arms"]) == model_names()
    assert found["arms"]["panda"]["joints"] == 7
    assert list(found["scenarios"]) == model_names("scenarios")
    assert found["fuzzy_systems"]["labvolt_theta3"]["inputs"] == ["x", "y"]


def test_run_as_json_gives_the_metrics_of_the_log(tmp_path, capsys):
    path, log = tmp_path / "short.yaml", tmp_path / "run.npz"
    path.write_text(SCENARIO)
    assert main(["run", str(path), "--json", "--log", str(log)]) == 0
    found = json.loads(capsys.readouterr().out)
    metrics = fikm_drake.RunLog.load(log).metrics()
    assert found["metrics"]["e_max"] == metrics.e_max
    assert found["status"] in {status.name.lower() for status in fikm_drake.ControllerStatus}


def test_benchmark_as_json_gives_a_row_a_measurement(capsys):
    assert main(["benchmark", "cycle", "--rounds", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["benchmark"], found["rounds"]) == ("cycle", 1)
    assert all(row["microseconds"] > 0.0 and row["name"] for row in found["rows"])


def complete(words, script):
    """What bash offers after these words, the last of which is being typed."""
    code = 'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _fikm_drake; '
    code += 'printf "%s\\n" "${COMPREPLY[@]}"'
    command = ["bash", "--norc", "-c", code, str(script), "fikm-drake", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


@pytest.mark.skipif(not shutil.which("bash"), reason="no bash")
def test_bash_completes_commands_options_models_and_choices(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)  # no files to offer
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "completion.sh"
    script.write_text(capsys.readouterr().out)
    assert {"run", "models", "benchmark", "completion"} <= set(complete([""], script))
    assert complete(["mod"], script) == ["models"]
    assert "--log" in complete(["run", "--"], script)
    assert set(complete(["run", "table6_"], script)) == {
        name for name in model_names("scenarios") if name.startswith("table6_")
    }
    assert {"bash", "zsh", "fish"} <= set(complete(["completion", ""], script))
    assert "--epochs" in complete(["train", "bounds", "--"], script)
    script_in_folder = complete(["run", "compl"], script)
    assert script_in_folder == ["completion.sh"]  # a path of one's own


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_know_every_command(shell, capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = capsys.readouterr().out
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for command in ("run", "models", "urdf", "reproduce", "benchmark", "export-c", "train"):
        assert command in listed and command in script
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True)


def test_completion_of_an_unknown_shell_names_the_known_ones(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["completion", "tcsh"])
    assert stopped.value.code == 2 and "fish" in capsys.readouterr().err


def test_rules_of_a_system_and_which_fire(tmp_path, capsys):
    assert main(["rules", "labvolt_theta3"]) == 0
    rules = capsys.readouterr().out.splitlines()
    assert rules == fikm_drake.load_mamdani("labvolt_theta3").rules()
    picture, page = tmp_path / "rules.png", tmp_path / "rules.html"
    words = ["rules", "labvolt_theta3", "--at", "0.4", "0.1", "--plot", str(picture)]
    assert main([*words, "--page", str(page)]) == 0
    out = capsys.readouterr().out
    assert out.startswith("at x = 0.4, y = 0.1:") and "by mean of maximum" in out
    assert picture.stat().st_size > 1000 and page.stat().st_size > 1000
    assert main(["rules", "labvolt_theta3", "--at", "0.4"]) == 2
    assert "point must be 2 finite numbers" in capsys.readouterr().err
