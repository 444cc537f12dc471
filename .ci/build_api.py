"""The API reference as HTML: `python .ci/build_api.py [FOLDER]`, with the extra `docs` installed.

Pages: the public names (`import fikm_drake as fd`), and each room of the package with its mathematics. A
warning of pdoc is an error here.
"""

import importlib
import pkgutil
import re
import sys
import warnings
from pathlib import Path

import pdoc
import pdoc.docstrings
import pdoc.render

import fikm_drake

SYSTEM = re.compile(r"\.\. pydrake_system::\n\n((?: {4}[^\n]*\n|\n)+)")


LEFT_OUT = ("!fikm_drake.cli", "!fikm_drake.experiments", "!fikm_drake.*_kernel")
"""The command has `--help` and runs the experiments; the kernel is no Python."""


def rooms() -> list[str]:
    """The folders of the package; what is below them comes along."""
    found = pkgutil.iter_modules(fikm_drake.__path__, "fikm_drake.")
    return sorted(module.name for module in found if module.ispkg)


def readable(docstring: str) -> str:
    """Drake's block of ports as code: pdoc does not know its directive."""

    def as_code(found: re.Match) -> str:
        block = re.sub(r"^ {4}", "", found[1].strip("\n"), flags=re.M)
        return f"```yaml\n{block}\n```\n\n"

    return SYSTEM.sub(as_code, docstring)


def build(folder: Path) -> list[str]:
    """Write the pages; returns pdoc's warnings."""
    importlib.import_module(
        "matplotlib.font_manager"
    )  # its first import asks fc-list: pdoc forbids that
    for name in fikm_drake.__all__:  # they are loaded when they are asked for
        getattr(fikm_drake, name)
    pdoc.render.configure(docformat="google", math=True, show_source=False)
    convert = pdoc.docstrings.convert
    pdoc.docstrings.convert = lambda docstring, *rest: convert(readable(docstring), *rest)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            pdoc.pdoc("fikm_drake", *rooms(), *LEFT_OUT, output_directory=folder)
        finally:
            pdoc.docstrings.convert = convert
    return [f"{found.category.__name__}: {found.message}" for found in caught]


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "api")
    complaints = build(target)
    print(*complaints, sep="\n", file=sys.stderr)
    print(f"wrote {target / 'index.html'}: {len(rooms()) + 1} pages, {len(complaints)} warnings")
    sys.exit(bool(complaints))
