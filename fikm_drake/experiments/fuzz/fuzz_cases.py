"""Many random cases, counted (`fikm-drake fuzz`)."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from fikm_drake.checks import check_counts
from fikm_drake.experiments.fuzz.block_fuzz import (
    command_supervisor_case,
    law_case,
    supervised_ik_case,
)
from fikm_drake.experiments.fuzz.controller_fuzz import Violation, controller_case
from fikm_drake.experiments.fuzz.native_fuzz import native_case

KINDS: dict[str, Callable[[np.random.Generator], Iterator[list[Violation]]]] = {
    "controller": controller_case,
    "law": law_case,
    "command supervisor": command_supervisor_case,
    "supervised differential IK": supervised_ik_case,
    "native cycle": native_case,
}
"""What is run in a case, by name."""
EVERY = {
    "law": (10, 3),
    "command supervisor": (20, 7),
    "supervised differential IK": (20, 15),
    "native cycle": (10, 9),
}
"""Of so many cases the one at this index is of this kind; the others are of controllers."""
MOST_EXAMPLES = 3
"""Examples that are kept of a kind of violation."""


@dataclass
class FuzzReport:
    """What came out."""

    seed: int
    """Seed of the random numbers."""
    cases: Counter[str] = field(default_factory=Counter)
    """How many of each of `KINDS`."""
    cycles: int = 0
    """Cycles of all cases."""
    refused: int = 0
    """Cases whose options a constructor refused with a ValueError."""
    violations: Counter[str] = field(default_factory=Counter)
    """How many cases violated what, by kind."""
    examples: dict[str, list[str]] = field(default_factory=dict)
    """The first of each kind of violation, with the index of its case."""

    def __str__(self) -> str:
        total = sum(self.cases.values())
        lines = [f"{total} cases, {self.cycles} cycles, seed {self.seed}"]
        lines += [f"  {count:6d} {name}" for name, count in self.cases.items()]
        lines += [
            f"  {self.refused:6d} refused with a ValueError",
            f"violations: {len(self.violations)}",
        ]
        for kind, count in self.violations.most_common():
            lines.append(f"  {count:6d} {kind}")
            lines += [f"         {example}" for example in self.examples[kind]]
        return "\n".join(lines)


def fuzz(
    cases: int,
    *,
    seed: int = 0,
    first: int = 0,
    progress: Callable[[float], None] | None = None,
) -> FuzzReport:
    """Run cases; each is made from the seed and its index alone.

    Args:
        cases: how many.
        seed: of the random numbers.
        first: index of the first case, to run one again.
        progress: called with the fraction done.

    Raises:
        ValueError: cases is not a positive integer, seed or first is negative.

    Example:
        >>> print(fuzz(20, seed=1).violations)
        Counter()
    """
    check_counts(cases=cases)
    check_counts(0, seed=seed, first=first)
    report = FuzzReport(seed)
    for index in range(first, first + cases):
        _run(report, index)
        if progress:
            progress((index - first + 1) / cases)
    return report


def _run(report: FuzzReport, index: int) -> None:
    rng = np.random.default_rng([report.seed, index])
    name = next((name for name, (every, at) in EVERY.items() if index % every == at), "controller")
    report.cases[name] += 1
    found: dict[str, str] = {}
    before = report.cycles
    try:
        with np.errstate(all="ignore"):
            for k, violations in enumerate(KINDS[name](rng)):
                report.cycles += 1
                for kind, what in violations:
                    found.setdefault(kind, f"cycle {k}: {what}")
    except ValueError as error:
        if report.cycles == before:
            report.refused += 1
        else:
            found.setdefault("raises ValueError", str(error))
    except (Exception, SystemExit) as error:  # whatever it is, it is counted
        found.setdefault(f"raises {type(error).__name__}", str(error))
    for kind, what in found.items():
        report.violations[kind] += 1
        kept = report.examples.setdefault(kind, [])
        if len(kept) < MOST_EXAMPLES:
            kept.append(f"case {index}, {name}, {what}"[:400])
