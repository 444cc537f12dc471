"""Two logs beside each other."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fikm_drake.files import new_figure, save_figure
from fikm_drake.simulation.run_log import RunLog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Comparison:
    """What `compare` found."""

    logs: tuple[RunLog, RunLog]
    rows: int
    """Rows at the same times, which were compared."""
    largest: dict[str, float]
    """Largest absolute difference of each series that both have with the same columns."""
    only: tuple[list[str], list[str]]
    """Series that the other log does not have, or with other columns."""
    scenario: list[str]
    """Lines of the scenarios that differ, `-` of the first and `+` of the second."""
    versions: list[str]
    """Versions that differ."""

    @property
    def same(self) -> bool:
        """Whether all numbers are equal: rows, columns and values."""
        a, b = self.logs
        whole = len(a) == len(b) == self.rows and not any(self.only)
        return whole and not any(self.largest.values())

    def __str__(self) -> str:
        a, b = self.logs
        lines = [f"rows {len(a)} and {len(b)}, {self.rows} at the same times"]
        for name in ("e_max", "e_mean", "e_ss"):
            try:
                x, y = (100 * getattr(log.metrics(), name) for log in self.logs)
            except (KeyError, ValueError):  # a log of somebody's own Diagram
                break
            lines.append(f"{name} [cm]: {x:.5g} and {y:.5g}, {y - x:+.3g}")
        for name in ("status",):
            if name in a and name in b:
                lines.append(f"{name} at the end: {a.status_names[-1]} and {b.status_names[-1]}")
        width = max([0, *map(len, self.largest)])
        lines += [
            f"{name:{width}s}  differs by at most {d:.3g}" for name, d in self.largest.items()
        ]
        lines += [f"only in the first: {', '.join(self.only[0])}"] if self.only[0] else []
        lines += [f"only in the second: {', '.join(self.only[1])}"] if self.only[1] else []
        return "\n".join([*lines, *self.scenario, *self.versions])

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw the errors of both, and how far their joints are apart.

        Raises:
            KeyError: a log has no joints.
            OSError: the file cannot be written.
            ValueError: matplotlib does not know the file's type.
        """
        figure = new_figure(9, 7)
        above, below = figure.subplots(2, 1, sharex=True)
        for log, label, style in zip(self.logs, ("first", "second"), ("-", "--")):
            if "error_after" in log:
                length = 100 * np.linalg.norm(log.error_after[:, -3:], axis=1)
                above.plot(log.time, length, style, label=label)
        above.set_ylabel("error [cm]")
        above.legend()
        rows = [_at(log, self._times()) for log in self.logs]
        if self.logs[0].q.shape[1] == self.logs[1].q.shape[1]:
            apart = self.logs[1].q[rows[1]] - self.logs[0].q[rows[0]]
            for i, column in enumerate(apart.T, start=1):
                below.plot(self._times(), column, label=f"$q_{{{i}}}$", linewidth=1)
            below.legend(ncols=8, fontsize=8)
        below.set_ylabel("second less first [rad or m]")
        below.set_xlabel("time [s]")
        for axes in (above, below):
            axes.grid(alpha=0.3)
        if path is not None:
            save_figure(figure, path)
        return figure

    def _times(self) -> np.ndarray:
        return _common(*self.logs)


def compare(a: RunLog, b: RunLog) -> Comparison:
    """Compare two logs at the times that both have."""
    times = _common(a, b)
    here, there = _at(a, times), _at(b, times)
    both = [n for n in a.names if n in b and a.info.columns[n] == b.info.columns[n]]
    largest = {}
    for name in both:
        apart = np.abs(a[name][here] - b[name][there])
        unequal = np.isnan(a[name][here]) != np.isnan(b[name][there])
        largest[name] = np.inf if unequal.any() else float(np.nan_to_num(apart).max(initial=0.0))
    diff = difflib.unified_diff(
        a.info.scenario.splitlines(), b.info.scenario.splitlines(), n=0, lineterm=""
    )
    lines = [line for line in diff if line[:1] in "+-" and line[:3] not in ("+++", "---")]
    versions = [
        f"{name}: {a.info.versions.get(name)} and {b.info.versions.get(name)}"
        for name in sorted(a.info.versions.keys() | b.info.versions.keys())
        if a.info.versions.get(name) != b.info.versions.get(name)
    ]
    only = ([n for n in a.names if n not in both], [n for n in b.names if n not in both])
    return Comparison((a, b), len(times), largest, only, lines, versions)


def _common(a: RunLog, b: RunLog) -> np.ndarray:
    """Times that both have, to a nanosecond."""
    ticks = np.intersect1d(np.rint(a.time * 1e9), np.rint(b.time * 1e9))
    return ticks * 1e-9


def _at(log: RunLog, times: np.ndarray) -> np.ndarray:
    """Rows of a log at times that it has."""
    return np.searchsorted(np.rint(log.time * 1e9), np.rint(times * 1e9))
