"""`fikm-drake models` and `fikm-drake urdf`: what is in `models/`."""

import argparse
from typing import TypedDict

from fikm_drake.cli.shared import OK, print_json
from fikm_drake.fuzzy.mamdani import load_mamdani
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import model_names, models_dir
from fikm_drake.simulation.scenario import load_scenario


def add_models(commands: "argparse._SubParsersAction") -> None:
    """Add the commands."""
    urdf = commands.add_parser("urdf", help="print an arm's URDF")
    urdf.add_argument("arm", help="name (see `fikm-drake models`) or path of a .yaml file")
    urdf.set_defaults(run=_urdf)

    models = commands.add_parser(
        "models", help="list the arms, the scenarios and the fuzzy systems"
    )
    models.add_argument("--json", action="store_true", help="print the lists as JSON")
    models.set_defaults(run=_models)


def _urdf(options: argparse.Namespace) -> int:
    print(load_arm(options.arm).to_urdf(), end="")
    return OK


def _models(options: argparse.Namespace) -> int:
    folder, arms, runs, systems = models_dir(), _arms(), _scenarios(), _fuzzy_systems()
    if options.json:
        found = {"folder": folder, "arms": arms, "scenarios": runs, "fuzzy_systems": systems}
        print_json(found)
        return OK
    print(f"in {folder}\narms:")
    for name, arm in arms.items():
        print(f"  {name:15s} {arm['joints']} joints, {arm['convention']} convention")
    print("scenarios:")
    for name, run in runs.items():
        print(f"  {name:15s} {run['robot']}, {run['seconds']:g} s at {run['control_rate']:g} Hz")
    print("fuzzy systems:")
    for name, system in systems.items():
        inputs, outputs = ", ".join(system["inputs"]), ", ".join(system["outputs"])
        print(f"  {name:15s} {inputs} to {outputs}, {system['rules']} rules")
    return OK


class _Arm(TypedDict):
    joints: int
    convention: str


class _Scenario(TypedDict):
    robot: str
    seconds: float
    control_rate: float


class _FuzzySystem(TypedDict):
    inputs: list[str]
    outputs: list[str]
    rules: int


def _arms() -> dict[str, _Arm]:
    arms = {name: load_arm(name) for name in model_names()}
    return {
        name: {"joints": arm.num_joints, "convention": arm.table.convention}
        for name, arm in arms.items()
    }


def _scenarios() -> dict[str, _Scenario]:
    runs = {name: load_scenario(name) for name in model_names("scenarios")}
    return {
        name: {
            "robot": run.load_robot().name,
            "seconds": run.target.duration + run.target.hold,
            "control_rate": run.control_rate,
        }
        for name, run in runs.items()
    }


def _fuzzy_systems() -> dict[str, _FuzzySystem]:
    configs = {name: load_mamdani(name).config for name in model_names("fuzzy")}
    return {
        name: {
            "inputs": [variable.name for variable in config.inputs],
            "outputs": [variable.name for variable in config.outputs],
            "rules": len(config.rules),
        }
        for name, config in configs.items()
    }
