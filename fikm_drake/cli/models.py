"""`fikm-drake models` and `fikm-drake urdf`: what is in `models/`."""

import argparse

from fikm_drake.cli.shared import OK
from fikm_drake.fuzzy.mamdani import load_mamdani
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.resources import model_names, models_dir
from fikm_drake.simulation.tracking_scenario import load_scenario


def add_models(commands: "argparse._SubParsersAction") -> None:
    """Add the commands."""
    urdf = commands.add_parser("urdf", help="print an arm's URDF")
    urdf.add_argument("arm", help="name (see `fikm-drake models`) or path of a .yaml file")
    urdf.set_defaults(run=_urdf)

    models = commands.add_parser(
        "models", help="list the arms, the scenarios and the fuzzy systems"
    )
    models.set_defaults(run=_models)


def _urdf(options: argparse.Namespace) -> int:
    print(load_arm(options.arm).to_urdf(), end="")
    return OK


def _models(options: argparse.Namespace) -> int:
    print(f"in {models_dir()}\narms:")
    for name in model_names():
        arm = load_arm(name)
        print(f"  {name:15s} {arm.num_joints} joints, {arm.table.convention} convention")
    print("scenarios:")
    for name in model_names("scenarios"):
        scenario = load_scenario(name)
        arm, seconds = scenario.load_arm(), scenario.duration + scenario.hold
        print(f"  {name:15s} {arm.name}, {seconds:g} s at {scenario.control_rate:g} Hz")
    print("fuzzy systems:")
    for name in model_names("fuzzy"):
        config = load_mamdani(name).config
        inputs = ", ".join(variable.name for variable in config.inputs)
        outputs = ", ".join(variable.name for variable in config.outputs)
        print(f"  {name:15s} {inputs} to {outputs}, {len(config.rules)} rules")
    return OK
