"""Many runs, on one machine or many: a table, and a log each."""

import itertools
import re
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydrake.common.yaml import yaml_load

from fikm_drake.executors import completed
from fikm_drake.files import import_pandas, write_csv
from fikm_drake.resources import find_model
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import Scenario, load_scenario
from fikm_drake.simulation.simulate import FILES, SimulationStopped, run_versions, simulate

if TYPE_CHECKING:
    import pandas

ROW_FIELDS = (
    "status",
    "e_max",
    "e_mean",
    "e_ss",
    "turn_max",
    "travel",
    "clearance",
    "seconds",
    "error",
)


@dataclass
class SweepRow:
    """One run of a sweep."""

    name: str
    options: dict[str, object] = field(default_factory=dict)
    """What differs from the base, by path; empty for scenarios that were given one by one."""
    status: str = ""
    """The last cycle's."""
    e_max: float = float("nan")
    """Largest error after a step [m]."""
    e_mean: float = float("nan")
    """Mean error [m]."""
    e_ss: float = float("nan")
    """Error at the end [m]."""
    turn_max: float = float("nan")
    """Largest angle to the target's orientation [rad]."""
    travel: float = float("nan")
    """Way of all joints together [rad or m]."""
    clearance: float = float("nan")
    """Least distance of the robot to anything [m]."""
    seconds: float = float("nan")
    """Time the run took; NaN where the log was there already."""
    error: str = ""
    """Why there is no result; empty for a good run."""


@dataclass
class Sweep:
    """What `sweep` returns: a row a run, in the order they were given."""

    rows: list[SweepRow]
    folder: Path | None = None
    """Where the logs are, NAME.npz each; None: nowhere."""

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def option_names(self) -> list[str]:
        """Paths of the options that were swept."""
        return list(dict.fromkeys(name for row in self.rows for name in row.options))

    def column(self, name: str) -> list:
        """A column by name: of `SweepRow`, or an option's path.

        Raises:
            KeyError: there is none; the message lists the names.
        """
        if name in self.option_names:
            return [row.options.get(name) for row in self.rows]
        known = [item.name for item in fields(SweepRow) if item.name != "options"]
        if name not in known:
            raise KeyError(f"no column {name!r}; there are {', '.join(self.option_names + known)}")
        return [getattr(row, name) for row in self.rows]

    def log(self, name: str) -> RunLog:
        """The log of a run by its name.

        Raises:
            ValueError: the sweep has no folder.
            FileNotFoundError: there is no such log.
        """
        if self.folder is None:
            raise ValueError("the sweep kept no logs: give it a folder")
        return RunLog.load(self.folder / f"{name}.npz")

    def to_csv(self, path: str | Path) -> None:
        """Write the table.

        Raises:
            OSError: the file cannot be written.
        """

        def cells(row: SweepRow) -> list[object]:
            options = [row.options.get(name) for name in self.option_names]
            return [row.name, *options, *(getattr(row, field) for field in ROW_FIELDS)]

        write_csv(path, [["name", *self.option_names, *ROW_FIELDS], *map(cells, self.rows)])

    def to_dataframe(self) -> "pandas.DataFrame":
        """A pandas DataFrame of the table.

        Raises:
            ImportError: pandas is not installed.
        """
        pandas = import_pandas()
        names = ["name", *self.option_names, *ROW_FIELDS]
        return pandas.DataFrame({name: self.column(name) for name in names})

    def __str__(self) -> str:
        width = max([4, *(len(row.name) for row in self.rows)])
        lines = [f"{'name':{width}s}  e_max [cm]  e_mean [cm]   e_ss [cm]  travel  status"]
        for r in self.rows:
            numbers = f"{100 * r.e_max:10.4f}  {100 * r.e_mean:11.4f}  {100 * r.e_ss:10.5f}"
            lines.append(f"{r.name:{width}s}  {numbers}  {r.travel:6.2f}  {r.error or r.status}")
        return "\n".join(lines)


@dataclass
class Grid:
    """Every combination of options on a base.

        fd.Grid(fd.load_scenario("table6_2s"), {"target.duration": [1.0, 2.0], "control_rate": [50, 100]})

    Attributes:
        base: the scenario that is varied.
        options: values by dotted path, see `Scenario.with_options`.
    """

    base: Scenario
    options: dict[str, Sequence]

    def scenarios(self) -> dict[str, tuple[Scenario, dict[str, object]]]:
        """Name, scenario and options of each combination.

        Raises:
            ValueError: an option does not exist or a combination is not valid; the message names it.
        """
        found: dict[str, tuple[Scenario, dict[str, object]]] = {}
        for values in itertools.product(*self.options.values()):
            options = dict(zip(self.options, values))
            name = ",".join(f"{path.split('.')[-1]}={_short(v)}" for path, v in options.items())
            try:
                scenario = self.base.with_options(options)
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from error
            unique = name if name not in found else f"{name},{len(found)}"
            found[unique] = (scenario, options)
        return found


def load_grid(path: str | Path) -> Grid:
    """Read a sweep from YAML: `base`, a scenario's name or path, and `grid`, values by dotted path.

    Raises:
        FileNotFoundError: there is no such file or scenario.
        ValueError: it is no such file; the message names it.
    """
    found = find_model(path, folder="scenarios", kind="sweep")
    try:
        data = yaml_load(filename=str(found))
    except Exception as error:  # PyYAML raises many kinds
        raise ValueError(f"{found} is not YAML: {error}") from error
    grid = data.get("grid") if isinstance(data, dict) else None
    if (
        not isinstance(grid, dict)
        or set(data) != {"base", "grid"}
        or not all(isinstance(values, list) and values for values in grid.values())
    ):
        raise ValueError(f"{found} must have base: SCENARIO and grid: {{path: [value, …]}}")
    base = str(data["base"])
    beside = found.parent / base
    return Grid(load_scenario(beside if beside.is_file() else base), grid)


def sweep(
    scenarios: Grid | Mapping[str, Scenario] | Sequence[Scenario],
    executor: Executor | None = None,
    *,
    folder: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Sweep:
    """Run many scenarios.

        with ProcessPoolExecutor() as executor:
            table = fd.sweep(fd.Grid(base, {"control_rate": [50.0, 100.0]}), executor, folder="runs")

    A run that fails is a row with its error; the others go on.

    Args:
        scenarios: a grid, or scenarios, with or without names.
        executor: of any kind, such as ProcessPoolExecutor or Dask's `client.get_executor()`; None: this
            process, one after the other.
        folder: where each run's log is kept; it is made. What is there already of the same scenario is not
            run again, so that a sweep that was stopped goes on where it was; a log of another scenario, of
            another version, or of a model file that has changed since, is written anew. Workers write
            there: it must be the same folder on all machines.
        progress: called after each run with the fraction done.

    Raises:
        ValueError: there is nothing to run, a name is no file's name, or a scenario is not valid.
        OSError: the folder cannot be made.
    """
    jobs = _jobs(scenarios)
    place = None if folder is None else Path(folder).absolute()
    if place is not None:
        place.mkdir(parents=True, exist_ok=True)
    rows: dict[str, SweepRow] = {}
    names = list(jobs)
    work = [(name, scenario, place) for name, (scenario, _) in jobs.items()]
    for number, row in completed(executor, run_one, work):
        name = names[number]
        row.options = jobs[name][1]
        rows[name] = row
        if progress:
            progress(len(rows) / len(jobs))
    result = Sweep([rows[name] for name in jobs], place)
    if place is not None:
        try:
            result.to_csv(place / "sweep.csv")
        except OSError as error:  # what was run is worth more than its table
            warnings.warn(f"the table of the sweep was not written: {error}", stacklevel=2)
    return result


def run_one(name: str, scenario: Scenario, folder: Path | None) -> SweepRow:
    """One run's row; its log is read where it is there already. Any process can do it."""
    path = None if folder is None else folder / f"{name}.npz"
    log = _kept(path, scenario)
    start, spent = time.perf_counter(), float("nan")
    try:
        if log is None:
            log = simulate(scenario, file=path)
            spent = time.perf_counter() - start
        metrics = log.metrics()
    except (SimulationStopped, ValueError) as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # it is the sweep that shall end
            raise error.__cause__ from error
        return SweepRow(name, error=str(error).split("\n")[0])
    return SweepRow(
        name,
        status=log.status_names[-1] if "status" in log else "",
        e_max=metrics.e_max,
        e_mean=metrics.e_mean,
        e_ss=metrics.e_ss,
        turn_max=float("nan") if metrics.turn_max is None else metrics.turn_max,
        travel=float(np.abs(np.diff(log.q, axis=0)).sum()),
        clearance=float("nan") if metrics.clearance is None else metrics.clearance,
        seconds=spent,
    )


def _kept(path: Path | None, scenario: Scenario) -> RunLog | None:
    """The whole log of this scenario that is there already, of the same versions and the same files."""
    if path is None or not path.is_file():
        return None
    try:
        log = RunLog.load(path)
    except ValueError:
        return None
    info, now = log.info, run_versions(scenario)
    same = info.scenario == scenario.whole().to_yaml() and all(
        info.versions.get(name) == now.get(name) for name in ("fikm_drake", "drake", "numpy", FILES)
    )
    return log if same and not info.ended else None


def _jobs(
    scenarios: Grid | Mapping[str, Scenario] | Sequence[Scenario],
) -> dict[str, tuple[Scenario, dict[str, object]]]:
    if isinstance(scenarios, Grid):
        jobs = scenarios.scenarios()
    else:
        named = (
            dict(scenarios)
            if isinstance(scenarios, Mapping)
            else {f"{i:04d}": scenario for i, scenario in enumerate(scenarios, start=1)}
        )
        jobs = {name: (scenario, {}) for name, scenario in named.items()}
    if not jobs:
        raise ValueError("there is nothing to sweep: no scenarios")
    for name, (scenario, _) in jobs.items():
        if not isinstance(scenario, Scenario):
            raise ValueError(f"{name!r} must be a Scenario, got {scenario!r}")
        if Path(name).name != name or name in (".", "..", ""):
            raise ValueError(f"a run's name must be a file's name, got {name!r}")
        scenario.validate()
    return jobs


def _short(value: object) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return re.sub(r"[^\w.+-]+", "_", text).strip("_")[:40]
