"""`fikm-drake rules`: a fuzzy system's rules, and what they say at a point."""

import argparse
import sys

from fikm_drake.cli.shared import OK
from fikm_drake.files import save_figure
from fikm_drake.fuzzy.mamdani import load_mamdani
from fikm_drake.fuzzy.teaching import fuzzy_view, plot_memberships, plot_rules, write_rules_page
from fikm_drake.fuzzy.teaching.plots import output_number


def add_rules(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    rules = commands.add_parser(
        "rules", help="print a fuzzy system's rules, or which fire at a point"
    )
    rules.add_argument("system", help="name (see `fikm-drake models`) or path of a .yaml file")
    rules.add_argument(
        "--at",
        nargs="+",
        type=float,
        metavar="X",
        help="one number an input: which rules fire there",
    )
    rules.add_argument("--output", metavar="NAME", help="of a system with several")
    rules.add_argument(
        "--plot",
        metavar="RULES.png",
        help="write a picture: of the rules there, or of all memberships",
    )
    rules.add_argument(
        "--page", metavar="RULES.html", help="write a page where sliders move the inputs"
    )
    rules.set_defaults(run=_rules)


def _rules(options: argparse.Namespace) -> int:
    system = load_mamdani(options.system)
    view = fuzzy_view(system)
    output = output_number(view, options.output or view.outputs[0].name)
    if options.at is None:
        print("\n".join(system.rules()))
    else:
        print(view.explain(options.at, output))
    if options.plot is not None:
        name = view.outputs[output].name
        at = options.at
        save_figure(
            plot_memberships(system) if at is None else plot_rules(system, at, name), options.plot
        )
        print(f"wrote {options.plot}", file=sys.stderr)
    if options.page is not None:
        write_rules_page(system, options.page, title=options.system)
        print(f"wrote {options.page}", file=sys.stderr)
    return OK
