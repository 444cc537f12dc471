"""`fikm-drake reproduce`: a paper's tables and figures beside ours."""

import argparse
import sys
from pathlib import Path

from fikm_drake.cli.shared import FAILED, OK
from fikm_drake.experiments.reproduce.papers import listing, page, select
from fikm_drake.files import save_figure, write_whole


def add_reproduce(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
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
    reproduce.add_argument("--list", action="store_true", help="only name the parts and their keys")
    reproduce.add_argument(
        "--map", metavar="FILE.md", help="write the page of every item, its file and its verdict"
    )
    reproduce.add_argument("--pictures", metavar="FOLDER", help="write the pictures there")
    reproduce.set_defaults(run=_reproduce)


def _reproduce(options: argparse.Namespace) -> int:
    if options.list:
        print(listing(options.paper))
        return OK
    keys = [*options.only, *(f"table {n}" for n in options.table)]
    keys += [f"figure {n}" for n in options.figure]
    experiments = select(options.paper, keys)
    if options.pictures is not None:
        Path(options.pictures).mkdir(parents=True, exist_ok=True)
    missed, sections = [], {}
    for name, experiment in experiments.items():
        section = sections[name] = experiment()
        print(f"{section}\n", flush=True)
        missed += [] if section.reached else [name]
        if options.pictures is not None:
            for stem, figure in section.pictures.items():
                save_figure(figure, Path(options.pictures) / f"{stem}.png", dpi=110)
    if options.map is not None:
        write_whole(options.map, page(sections))
    if missed:
        print(f"fikm-drake: not reached: {', '.join(missed)}", file=sys.stderr)
    return FAILED if missed else OK
