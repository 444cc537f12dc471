"""Fuzzy inverse kinematics for robot arms, as Drake systems.

    import fikm_drake as fd

    log = fd.simulate(fd.load_scenario("table6_10s"))
    print(log.metrics())

Layers, each of which imports only those below it: `experiments`, `simulation`, `diagrams`,
`systems`, `laws` and `solvers`, `kinematics` and `fuzzy`. Lengths are in metres, angles in
radians, times in seconds.
"""

# A name is loaded when it is first asked for: the import takes a millisecond, a script loads what it uses.
# Where each of them is defined, and what type checkers read, is in `__init__.pyi`.
import importlib
import importlib.util
import re
from pathlib import Path

__version__ = "0.1.0"


def _homes() -> dict[str, str]:
    """The module of each public name, by the imports of `__init__.pyi`."""
    text = Path(__file__).with_suffix(".pyi").read_text("utf-8")
    found = re.findall(r"^from ([\w.]+) import (?:\(([^)]*)\)|(.*))$", text, flags=re.MULTILINE)
    return {
        name.strip(): module
        for module, many, one in found
        for name in (many or one).split(",")
        if name.strip()
    }


_HOMES = _homes()
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    """Load a public name, or a room of the package, when it is first asked for."""
    home = _HOMES.get(name)
    if home is not None:
        module = importlib.import_module(home)
        value = getattr(module, name, None)
        if value is None:  # a module in a package
            value = importlib.import_module(f"{home}.{name}")
    elif not name.startswith("_") and importlib.util.find_spec(f"{__name__}.{name}"):
        value = importlib.import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
