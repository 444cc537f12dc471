"""What a run leaves behind."""

import csv
import io
import zipfile
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from fikm_drake.arrays import Array, Bools
from fikm_drake.files import whole_file
from fikm_drake.simulation.tracking_metrics import TrackingMetrics, tracking_metrics
from fikm_drake.simulation.tracking_scenario import TrackingScenario

KINDS = {"oscillating": np.bool_, "status": np.int64}
"""Types of the series that are not float64."""
FORMAT = "fikm_drake.TrackingLog/1"


@dataclass(frozen=True, eq=False)
class TrackingLog:
    """Everything of a run, a row a control cycle (N cycles, m task coordinates, n joints).

    `q`, `actual` and `error` are after the cycle's update; the rest is what the cycle computed.

    Raises:
        ValueError: the series do not fit together or do not fit the scenario.
    """

    scenario: TrackingScenario
    """The scenario that was run."""
    time: Array
    """Start of each cycle (N,) [s]."""
    desired: Array
    """Target (N,m) [m]."""
    actual: Array
    """Tool position (N,m) [m]."""
    q: Array
    """Joint positions (N,n) [rad or m]."""
    joint_step: Array
    """dθ before the joint limits (N,n) [rad or m]."""
    error: Array
    """Desired minus actual (N,m) [m]."""
    gain: Array
    """K of Table I before its filter (N,) [-]."""
    oscillating: Bools
    """True where the supervisor saw a joint oscillate (N,)."""
    status: NDArray[np.int64]
    """`ControllerStatus` (N,)."""

    def __post_init__(self) -> None:
        N = len(self.time) if self.time.ndim == 1 else -1
        m, n = len(self.scenario.waypoints[0]), self.scenario.load_arm().num_joints
        shapes = {"desired": (N, m), "actual": (N, m), "error": (N, m)}
        shapes |= {"q": (N, n), "joint_step": (N, n)}
        for name in series_names():
            series, shape = getattr(self, name), shapes.get(name, (N,))
            if series.shape != shape or N < 1:
                raise ValueError(f"log: {name} has shape {series.shape}, expected {shape}, N > 0")
            kind = KINDS.get(name, np.float64)
            if series.dtype != kind:
                raise ValueError(f"log: {name} must be {kind.__name__}, got {series.dtype}")

    def metrics(self) -> TrackingMetrics:
        """Errors of the run [m]."""
        return tracking_metrics(self.error, self.actual, np.array(self.scenario.waypoints))

    def save(self, path: str | Path) -> None:
        """Write a .npz without pickles: the series, and the scenario with its arm as YAML.

        Raises:
            OSError: the file cannot be written.
        """
        arm = self.scenario.load_arm().table  # so that the log outlives the arm's file
        scenario = replace(self.scenario, arm=arm)
        series = {name: getattr(self, name) for name in series_names()}
        with whole_file(path) as file:
            np.savez_compressed(file, format=FORMAT, scenario=yaml_dump_typed(scenario), **series)

    @classmethod
    def load(cls, path: str | Path) -> "TrackingLog":
        """Read a log that `save` wrote.

        Raises:
            FileNotFoundError: there is no such file.
            ValueError: the file is damaged or is not such a log.
        """
        if not Path(path).exists():
            raise FileNotFoundError(f"no log {path}")
        try:
            with np.load(path, allow_pickle=False) as file:
                if str(file["format"]) != FORMAT:
                    raise ValueError(f"its format is {str(file['format'])!r}, not {FORMAT!r}")
                scenario = yaml_load_typed(schema=TrackingScenario, data=str(file["scenario"]))
                scenario.validate()
                return cls(scenario=scenario, **{name: file[name] for name in series_names()})
        except (OSError, ValueError, KeyError, EOFError, RuntimeError, zipfile.BadZipFile) as error:
            raise ValueError(f"{path} is not a tracking log of fikm_drake: {error}") from error
        except Exception as error:  # a damaged archive can raise from zlib, numpy or PyYAML
            raise ValueError(f"{path} is damaged: {error}") from error

    def to_csv(self, path: str | Path) -> None:
        """Write a table with a row a cycle; the header names the units.

        Raises:
            OSError: the file cannot be written.
        """
        axes = "xyz"[: self.desired.shape[1]]
        revolute = self.scenario.load_arm().chain.revolute
        joints = [f"{i}_{'rad' if turns else 'm'}" for i, turns in enumerate(revolute, start=1)]
        header = ["time_s"]
        for name in ("desired", "actual", "error"):
            header += [f"{name}_{axis}_m" for axis in axes]
        for name in ("q", "joint_step"):
            header += [f"{name}_{joint}" for joint in joints]
        header += ["gain", "oscillating", "status"]
        columns = [self.desired, self.actual, self.error, self.q, self.joint_step]
        flags = np.stack([self.oscillating.astype(int), self.status], axis=1)
        with whole_file(path) as file:
            text = io.TextIOWrapper(file, encoding="utf-8", newline="")
            writer = csv.writer(text)
            writer.writerow(header)
            numbers = np.column_stack([self.time, *columns, self.gain]).tolist()
            writer.writerows([*row, *flag] for row, flag in zip(numbers, flags.tolist()))
            text.flush()
            text.detach()


def series_names() -> list[str]:
    """Names of the series of a log, in order."""
    return [f.name for f in fields(TrackingLog) if f.name != "scenario"]
