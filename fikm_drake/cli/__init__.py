"""The command `fikm-drake`."""

import argparse
import platform
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from fikm_drake.cli.benchmark import add_benchmark
from fikm_drake.cli.calibrate import add_calibrate
from fikm_drake.cli.check import add_check
from fikm_drake.cli.completion import add_completion
from fikm_drake.cli.export_c import add_export_c
from fikm_drake.cli.follow import add_follow
from fikm_drake.cli.fuzz import add_fuzz
from fikm_drake.cli.models import add_models
from fikm_drake.cli.reproduce import add_reproduce
from fikm_drake.cli.rules import add_rules
from fikm_drake.cli.run import add_run
from fikm_drake.cli.shared import BAD_INPUT, EXIT_CODES, FAILED, code_of, sigterm_raises
from fikm_drake.cli.sweep import add_sweep
from fikm_drake.cli.teleop import add_teleop
from fikm_drake.cli.train import add_train
from fikm_drake.kinematics.native.kernel import kernel_description


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command with `arguments`, by default those of the process; returns the exit code."""
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        with sigterm_raises():
            return options.run(options)
    except (ValueError, FileNotFoundError) as error:
        print(f"fikm-drake: {error}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        print(f"fikm-drake: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt as error:
        return code_of(error)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fikm-drake",
        description="Fuzzy inverse kinematics on Drake.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=_versions())
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    for add in (
        add_run,
        add_sweep,
        add_teleop,
        add_follow,
        add_models,
        add_check,
        add_rules,
        add_reproduce,
        add_benchmark,
        add_fuzz,
        add_export_c,
        add_calibrate,
        add_train,
        add_completion,
    ):
        add(commands)
    return parser


def _versions() -> str:
    """Ours and those of what results depend on."""
    own = sys.modules["fikm_drake"].__version__
    others = []
    for name in ("drake", "numpy"):
        try:
            others.append(f"{name} {version(name)}")
        except PackageNotFoundError:  # Drake built from source
            others.append(f"{name} of unknown version")
    others += [f"Python {platform.python_version()}", kernel_description()]
    return f"fikm-drake {own} ({', '.join(others)})"
