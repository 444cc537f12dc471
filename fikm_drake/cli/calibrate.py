"""`fikm-drake calibrate`: memberships that a paper gives no numbers for, from a seed."""

import argparse
from pathlib import Path

from pydrake.common.yaml import yaml_dump_typed

from fikm_drake.cli.shared import OK, positive_count, progress
from fikm_drake.files import write_whole
from fikm_drake.fuzzy.mamdani import MamdaniSystem
from fikm_drake.resources import find_model
from fikm_drake.solvers.labvolt.calibration import FIRST_PEAKS, calibrate


def add_calibrate(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "calibrate", help="search memberships for fuzzy starts, and write them as YAML"
    )
    what = parser.add_subparsers(required=True, metavar="WHAT")
    labvolt = what.add_parser("labvolt", help=", ".join(FIRST_PEAKS))
    labvolt.add_argument("--targets", type=positive_count, default=5000, help="how many (5000)")
    labvolt.add_argument("--rounds", type=positive_count, default=400, help="trials (400)")
    labvolt.add_argument("--seed", type=int, default=0, help="of targets and trials (0)")
    labvolt.add_argument("--folder", default=".", help="where the files are written (.)")
    labvolt.set_defaults(run=_labvolt)


def _labvolt(options: argparse.Namespace) -> int:
    folder = Path(options.folder)
    if not folder.is_dir():
        raise FileNotFoundError(f"there is no folder {folder}")
    for name in FIRST_PEAKS:
        found = calibrate(
            name,
            targets=options.targets,
            rounds=options.rounds,
            seed=options.seed,
            progress=progress(),
        )
        path = folder / f"{name}.yaml"
        _write(found.system, name, path)
        print(f"{path}: {found.what}, {found.first:g} at first, now {found.last:g}")
    return OK


def _write(system: MamdaniSystem, name: str, path: Path) -> None:
    """The system with the comments that head our file of that name."""
    lines = find_model(name, folder="fuzzy").read_text("utf-8").splitlines()
    head = [line for line in lines if line.startswith("#")]
    write_whole(path, "\n".join([*head, yaml_dump_typed(system.config)]))
