"""What a run leaves behind."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common.yaml import yaml_load_typed

from fikm_drake.arrays import Array
from fikm_drake.files import import_pandas, write_csv
from fikm_drake.simulation.log_file import read_log, write_archive
from fikm_drake.simulation.log_info import LogInfo
from fikm_drake.simulation.scenario import Scenario
from fikm_drake.simulation.tracking_metrics import TrackingMetrics, tracking_metrics

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Cycles:
    """What N control cycles did, a row each."""

    time: Array
    """When each began (N,) [s]."""
    desired: Array
    """Its target (N,m) [m]."""
    actual: Array
    """The tool after it, in the same coordinates."""
    q: Array
    """Joint positions after it (N,n) [rad or m]."""
    error: Array
    """Its target less the tool after it (N,m) [m], as papers print it."""
    joint_step: Array
    """dθ that it made, before the joint limits (N,n) [rad or m]; (N,0) of controllers without."""


class RunLog:
    """Times and named series, a row a sample: of `simulate`, or of any Diagram by `record`.

        log = fd.simulate(scenario)
        log.q, log["gain"], log.metrics()
        log.save("run.npz"); log.to_csv("run.csv"); log.to_dataframe()

    A run of N control cycles has N + 1 rows; row 0 is the start. Row k is of the moment just before cycle
    k: where the arm is (`q`, `actual`, `velocity`), where it should be (`desired`), and what the cycle is
    about to do (`joint_step`, `gain`, `status`). `error_before` is desired less actual of the same row;
    `error_after` is to the target of the cycle that has just ended, so `error_after[1:]` are the errors
    after the steps, which papers print; `error_after[0]` is the error of the start.

    Args:
        time: (N,) [s], increasing.
        series: (N,) or (N,k) each, by name.
        info: the head; its `columns` are made up where there is none.

    Raises:
        ValueError: the series do not fit together, or a time is not finite.
    """

    def __init__(
        self, time: ArrayLike, series: Mapping[str, ArrayLike], info: LogInfo | None = None
    ) -> None:
        self.time: Array = np.array(time, dtype=float)
        """(N,) [s]."""
        if self.time.ndim != 1 or not len(self.time) or not np.isfinite(self.time).all():
            raise ValueError(f"log: time must be (N,), N > 0, finite, got {self.time.shape}")
        if not (np.diff(self.time) > 0.0).all():
            raise ValueError("log: time must increase from row to row")
        columns = info.columns if info else {}
        self._series: dict[str, Array] = {}
        for name, values in series.items():
            array = np.array(values, dtype=float)
            array = array[:, None] if array.ndim == 1 else array
            width = len(columns[name]) if name in columns else array.shape[-1]
            if array.shape != (len(self.time), width):
                raise ValueError(
                    f"log: {name} has shape {array.shape}, expected {(len(self.time), width)}"
                )
            self._series[name] = array
        labels = {name: columns.get(name) or _labels(name, a) for name, a in self._series.items()}
        self.info: LogInfo = replace(info, columns=labels) if info else LogInfo(labels)
        """The head: scenario, law, versions, names of columns and of statuses."""
        self.info.validate()

    def __getitem__(self, name: str) -> Array:
        """A series by name, (N,k).

        Raises:
            KeyError: there is none; the message lists those there are.
        """
        if name not in self._series:
            raise KeyError(f"the log has no {name!r}; it has {', '.join(self._series)}")
        return self._series[name]

    def __contains__(self, name: object) -> bool:
        return name in self._series

    def __len__(self) -> int:
        return len(self.time)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the series."""
        return tuple(self._series)

    @property
    def desired(self) -> Array:
        """Target (N,m) [m], or its pose (N,7): quaternion w, x, y, z and position [m]."""
        return self["desired"]

    @property
    def actual(self) -> Array:
        """The tool, in the same coordinates as `desired`."""
        return self["actual"]

    @property
    def q(self) -> Array:
        """Joint positions of the arm (N,n) [rad or m]."""
        return self["q"]

    @property
    def command(self) -> Array:
        """Commanded joint positions (N,n) [rad or m]."""
        return self["command"]

    @property
    def velocity(self) -> Array:
        """Joint velocities (N,n) [rad/s or m/s]; of a kinematic run the commanded ones."""
        return self["velocity"]

    @property
    def torque(self) -> Array:
        """Torque of a torque-driven arm's joints (N,n) [N m or N]."""
        return self["torque"]

    @property
    def joint_step(self) -> Array:
        """dθ that the cycle is about to make, before the joint limits (N,n) [rad or m]."""
        return self["joint_step"]

    @property
    def error_before(self) -> Array:
        """Desired less actual of the same row; positions [m], turns as rotation vectors [rad]."""
        return self["error_before"]

    @property
    def error_after(self) -> Array:
        """The target of the cycle that has just ended, less actual; as `error_before`."""
        return self["error_after"]

    @property
    def gain(self) -> Array:
        """K before its filter (N,) [-]."""
        return self["gain"][:, 0]

    @property
    def oscillating(self) -> NDArray[np.bool_]:
        """True where the supervisor sees a joint oscillate (N,)."""
        return self["oscillating"][:, 0] > 0.5

    @property
    def clearance(self) -> Array:
        """Distance of the nearest pair of bodies, of which the joints move one (N,) [m].

        There where a scenario has obstacles; negative in penetration. `names_of_values("nearest_pair")`
        tells which pair it is.
        """
        return self["clearance"][:, 0]

    @property
    def status(self) -> NDArray[np.int64]:
        """The controller's status (N,)."""
        return self["status"][:, 0].astype(np.int64)

    @property
    def status_names(self) -> list[str]:
        """The names of `status`, such as `CONVERGED`."""
        return self.names_of_values("status")

    def names_of_values(self, name: str) -> list[str]:
        """The names of a series of whole numbers that has names, such as `status`."""
        known = self.info.names.get(name, {})
        return [known.get(f"{value:.0f}", f"{value:g}") for value in self[name][:, 0]]

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario that was run.

        Raises:
            ValueError: the log is of a Diagram of somebody's own, or its scenario is damaged.
        """
        if not self.info.scenario:
            raise ValueError("the log has no scenario: it is of a Diagram of somebody's own")
        try:
            scenario = yaml_load_typed(
                schema=Scenario, data=self.info.scenario, retain_map_defaults=True
            )
            scenario.validate()
        except Exception as error:  # Drake and PyYAML raise many kinds
            raise ValueError(f"the log's scenario is damaged: {error}") from error
        return scenario

    @functools.cached_property
    def cycles(self) -> "Cycles":
        """A row a control cycle: its target, what it did, and where that led."""
        n = len(self) - 1

        def whole(name: str, first: int) -> Array:
            return self[name][first : n + first] if name in self else np.empty((n, 0))

        return Cycles(
            time=self.time[:-1],
            desired=whole("desired", 0),
            actual=whole("actual", 1),
            q=whole("q", 1),
            error=whole("error_after", 1),
            joint_step=whole("joint_step", 0),
        )

    def metrics(self) -> TrackingMetrics:
        """Errors of the run, after the steps [m].

        Raises:
            ValueError: the log has no scenario.
        """
        after = slice(1, None) if len(self) > 1 else slice(None)
        corners = self.scenario.target_motion().corners
        clearance = None
        if "clearance" in self:
            known = self.clearance[np.isfinite(self.clearance)]
            clearance = float(known.min()) if known.size else float("nan")
        return tracking_metrics(
            self.error_after[after], self.actual[after], corners, clearance=clearance
        )

    def replace(self, **series: ArrayLike) -> "RunLog":
        """A copy with other values of some series."""
        return RunLog(self.time, self._series | series, replace(self.info))

    def rows(self, rows: slice) -> "RunLog":
        """A copy of some rows."""
        chosen = {name: values[rows] for name, values in self._series.items()}
        return RunLog(self.time[rows], chosen, replace(self.info))

    def save(self, path: str | Path) -> None:
        """Write a .npz without pickles; an old file stays until the new one is whole.

        Raises:
            OSError: the file cannot be written.
        """
        write_archive(path, self.info, np.column_stack([self.time, *self._series.values()]))

    @classmethod
    def load(cls, path: str | Path) -> "RunLog":
        """Read a log that `save` wrote, or what there is of one whose run was killed.

        Raises:
            FileNotFoundError: there is no such file.
            ValueError: the file is damaged or is not such a log; the message names it.
        """
        info, table = read_log(path)
        return cls.from_table(info, table)

    @classmethod
    def from_table(cls, info: LogInfo, table: Array) -> "RunLog":
        """A log of time and all columns (N, 1 + width), in the order of `info.columns`."""
        ends = np.cumsum([1, *map(len, info.columns.values())])
        series = {name: table[:, a:b] for name, a, b in zip(info.columns, ends, ends[1:])}
        return cls(table[:, 0], series, info)

    def to_csv(self, path: str | Path) -> None:
        """Write a table with a row a sample; the header names the units, the last columns the statuses.

        PlotJuggler and pandas load it as it is.

        Raises:
            OSError: the file cannot be written.
        """
        names = [name for name in self.info.names if name in self]
        labels = [label for columns in self.info.columns.values() for label in columns]
        numbers = np.column_stack([self.time, *self._series.values()]).tolist()
        texts = zip(*(self.names_of_values(name) for name in names)) if names else iter(())
        head = ["time_s", *labels, *(f"{name}_name" for name in names)]
        write_csv(path, [head, *([*row, *next(texts, ())] for row in numbers)])

    def to_dataframe(self) -> "pandas.DataFrame":
        """A pandas DataFrame: the columns of `to_csv`, by time.

        Raises:
            ImportError: pandas is not installed.
        """
        pandas = import_pandas()
        data = {
            label: values[:, i]
            for name, values in self._series.items()
            for i, label in enumerate(self.info.columns[name])
        }
        for name in self.info.names:
            if name in self:
                data[f"{name}_name"] = pandas.Categorical(self.names_of_values(name))
        return pandas.DataFrame(data, index=pandas.Index(self.time, name="time_s"))

    def __repr__(self) -> str:
        ended = f", ended: {self.info.ended}" if self.info.ended else ""
        return (
            f"<RunLog: {len(self)} rows from {self.time[0]:g} to {self.time[-1]:g} s, "
            f"{', '.join(self.names)}{ended}>"
        )


def _labels(name: str, values: Array) -> list[str]:
    width = values.shape[1]
    return [name] if width == 1 else [f"{name}_{i}" for i in range(width)]
