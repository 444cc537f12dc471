"""The command `fikm-drake`."""

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from fikm_drake.experiments.batch_benchmark import batch_benchmark
from fikm_drake.experiments.papers import select
from fikm_drake.experiments.pose_benchmark import pose_benchmark
from fikm_drake.experiments.step_benchmark import step_benchmark
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.controller_status import ControllerStatus
from fikm_drake.resources import model_names, models_dir
from fikm_drake.simulation.plot_log import plot_log
from fikm_drake.simulation.simulate import SimulationStopped, simulate
from fikm_drake.simulation.tracking_log import TrackingLog
from fikm_drake.simulation.tracking_scenario import load_scenario
from fikm_drake.simulation.write_html import write_html

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
EXIT_CODES = """exit codes:
  0    done
  1    the run failed, or a file could not be written
  2    bad arguments, or a model or scenario that is missing or not valid
  130  interrupted; the log so far is written where one was asked for"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command with `arguments`, by default those of the process; returns the exit code."""
    parser = _parser()
    options = parser.parse_args(arguments)
    try:
        return options.run(options)
    except (ValueError, FileNotFoundError) as error:
        print(f"fikm-drake: {error}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        print(f"fikm-drake: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fikm-drake",
        description="Fuzzy inverse kinematics on Drake.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="run a scenario and print its errors")
    run.add_argument("scenario", help="name (see `fikm-drake models`) or path of a .yaml file")
    run.add_argument("--log", metavar="RUN.npz", help="write the log")
    run.add_argument("--csv", metavar="RUN.csv", help="write the log as a table")
    run.add_argument("--plot", metavar="RUN.png", help="write a picture")
    run.add_argument("--html", metavar="RUN.html", help="write a page that plays the run")
    run.set_defaults(run=_run)

    urdf = commands.add_parser("urdf", help="print an arm's URDF")
    urdf.add_argument("arm", help="name (see `fikm-drake models`) or path of a .yaml file")
    urdf.set_defaults(run=_urdf)

    models = commands.add_parser("models", help="list the arms and the scenarios")
    models.set_defaults(run=_models)

    reproduce = commands.add_parser(
        "reproduce", help="a paper's tables and figures beside ours; exit code 1 if a claim fails"
    )
    reproduce.add_argument("paper", help="name of a paper, or all")
    reproduce.add_argument("--table", action="append", default=[], metavar="N", help="only table N")
    reproduce.add_argument(
        "--figure", action="append", default=[], metavar="N", help="only figure N"
    )
    reproduce.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="NAME",
        help="only this part, such as ablation",
    )
    reproduce.add_argument("--pictures", metavar="FOLDER", help="write the pictures there")
    reproduce.set_defaults(run=_reproduce)

    benchmark = commands.add_parser("benchmark", help="measure costs")
    what = benchmark.add_subparsers(required=True, metavar="WHAT")
    step = what.add_parser("step", help="CPU time of a control step beside Drake's")
    step.add_argument("--rounds", type=_count, default=20, help="times to follow the path (20)")
    step.set_defaults(run=_benchmark_step)
    poses = what.add_parser("poses", help="poses reached in the loop, calm out of reach")
    poses.add_argument("--poses", type=_count, default=60, help="random poses (60)")
    poses.set_defaults(run=_benchmark_poses)
    batch = what.add_parser("batch", help="poses in batch, beside roboticstoolbox where installed")
    batch.add_argument("--rounds", type=_count, default=5, help="rounds of 1000 poses (5)")
    batch.set_defaults(run=_benchmark_batch)
    return parser


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {number}")
    return number


def _run(options: argparse.Namespace) -> int:
    scenario = load_scenario(options.scenario)
    if not _folders_exist(options):
        return FAILED
    code = OK
    try:
        log = simulate(scenario, progress=_progress())
    except SimulationStopped as stopped:
        print(f"fikm-drake: {stopped}", file=sys.stderr)
        log = stopped.log
        code = INTERRUPTED if isinstance(stopped.__cause__, KeyboardInterrupt) else FAILED
    if not _write(log, options):
        code = code or FAILED
    last = ControllerStatus(int(log.status[-1])).name.lower().replace("_", " ")
    print(f"{options.scenario}: {log.metrics()}, {last} at the end")
    return code


def _folders_exist(options: argparse.Namespace) -> bool:
    """Complain of a mistyped folder before the run, not after it."""
    for name in ("log", "csv", "plot", "html"):
        path = getattr(options, name)
        if path is not None and not Path(path).parent.is_dir():
            print(f"fikm-drake: cannot write {path}: there is no such folder", file=sys.stderr)
            return False
    return True


def _write(log: TrackingLog, options: argparse.Namespace) -> bool:
    """Write the files that were asked for, each even if another fails; True if all could be."""
    good = True
    writers: dict[str, Callable] = {
        "log": log.save,
        "csv": log.to_csv,
        "plot": lambda path: plot_log(log, path),
        "html": lambda path: write_html(log, path),
    }
    for name, write in writers.items():
        path = getattr(options, name)
        if path is None:
            continue
        try:
            write(path)
            print(f"wrote {path}", file=sys.stderr)
        except (OSError, ValueError, RuntimeError) as error:
            print(f"fikm-drake: cannot write {path}: {error}", file=sys.stderr)
            good = False
    return good


def _urdf(options: argparse.Namespace) -> int:
    print(load_arm(options.arm).to_urdf(), end="")
    return OK


def _models(options: argparse.Namespace) -> int:
    print(f"in {models_dir()}\narms:")
    for name in model_names():
        arm = load_arm(name)
        print(f"  {name:12s} {arm.num_joints} joints, {arm.table.convention} convention")
    print("scenarios:")
    for name in model_names("scenarios"):
        scenario = load_scenario(name)
        arm, seconds = scenario.load_arm(), scenario.duration + scenario.hold
        print(f"  {name:12s} {arm.name}, {seconds:g} s at {scenario.control_rate:g} Hz")
    return OK


def _reproduce(options: argparse.Namespace) -> int:
    keys = [*options.only, *(f"table {n}" for n in options.table)]
    keys += [f"figure {n}" for n in options.figure]
    experiments = select(options.paper, keys)
    if options.pictures is not None:
        Path(options.pictures).mkdir(parents=True, exist_ok=True)
    missed = []
    for name, experiment in experiments.items():
        section = experiment()
        print(f"{section}\n", flush=True)
        missed += [] if section.reached else [name]
        if options.pictures is not None:
            for stem, figure in section.pictures.items():
                figure.savefig(Path(options.pictures) / f"{stem}.png", dpi=110)
    if missed:
        print(f"fikm-drake: not reached: {', '.join(missed)}", file=sys.stderr)
    return FAILED if missed else OK


def _benchmark_step(options: argparse.Namespace) -> int:
    costs = step_benchmark(rounds=options.rounds, progress=_progress())
    print(
        "one control step of arm7 in a Simulator, CPU time (median), over Drake's usual and least"
    )
    for cost in costs:
        print(
            f"  {cost.name:44s} {cost.microseconds:6.1f} µs"
            f"  {cost.to_usual:5.2f}  {cost.to_least:5.2f}"
        )
    return OK


def _benchmark_batch(options: argparse.Namespace) -> int:
    costs = batch_benchmark(rounds=options.rounds, progress=_progress())
    print("random reachable poses from a home posture, within 1 mm and 0.5°, time a pose (median)")
    for cost in costs:
        limits = "inside limits" if cost.limits else "limits ignored"
        print(
            f"  {cost.arm:8s} {limits:15s} {cost.solver:24s} {cost.success:7.2f} %"
            f"  {cost.microseconds:6.1f} µs  {cost.cycles:4.0f} cycles"
        )
    return OK


def _benchmark_poses(options: argparse.Namespace) -> int:
    results = pose_benchmark(poses=options.poses, progress=_progress())
    print("iiwa14 in the loop, 6 s a pose at 100 Hz, 1 mm and 0.01 rad; then a pose out of reach")
    for result in results:
        print(
            f"  {result.name:26s} {result.reached:3d} of {result.poses} poses,"
            f" out of reach {result.unrest:.2g} rad/s rms"
        )
    return OK


def _progress(patience: float = 2.0) -> Callable[[float], None]:
    """A progress line on standard error, for a person who has waited for `patience` seconds."""
    start = time.monotonic()
    shown = False

    def show(fraction: float) -> None:
        nonlocal shown
        if not sys.stderr.isatty():
            return
        if shown or time.monotonic() - start > patience:
            shown = True
            end = "\n" if fraction >= 1.0 else ""
            print(f"\r{100 * fraction:3.0f} %", end=end, file=sys.stderr, flush=True)

    return show


if __name__ == "__main__":
    sys.exit(main())
