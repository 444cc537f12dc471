"""A paper's figures beside ours, as text."""

from collections.abc import Callable
from dataclasses import dataclass, field

from matplotlib.figure import Figure

Value = float | str | None
CLAIMED = {None: "", True: "ok", False: "NOT REACHED"}
TOLD = {None: "", True: "meets", False: "misses"}
"""Verdicts on the column that is claimed, and on the other."""


@dataclass(frozen=True)
class Cell:
    """One figure of a paper and ours.

    A tracking error stands twice: `ours` after the step of the cycle, `before` before it, both to that
    cycle's target. Each is judged by the paper's figure; one of them is claimed.
    """

    label: str
    """What is compared, with its unit."""
    paper: Value
    """The paper's; None: it gives none."""
    ours: Value
    """Ours, measured or computed by this run; a tracking error after the step."""
    reached: bool | None = None
    """Whether ours reaches what we claim; None: nothing is claimed."""
    before: Value = None
    """A tracking error before the step."""
    before_reached: bool | None = None
    """Whether that reaches the same."""
    claimed: str = "ours"
    """Which of the two counts, `ours` or `before`; the other is only told."""

    @property
    def claims(self) -> bool:
        """True if something is claimed."""
        return (self.before_reached if self.claimed == "before" else self.reached) is not None

    @property
    def failed(self) -> bool:
        """True if the claim is not reached."""
        return (self.before_reached if self.claimed == "before" else self.reached) is False

    @property
    def verdicts(self) -> tuple[str, str]:
        """Verdicts of ours and of the error before the step, in a word."""
        words = (CLAIMED, TOLD) if self.claimed == "ours" else (TOLD, CLAIMED)
        return words[0][self.reached], words[1][self.before_reached]


@dataclass(frozen=True)
class Section:
    """One table, figure or claim of a paper."""

    key: str
    """Such as `table 6`; what `--only` takes."""
    title: str
    """One line."""
    cells: list[Cell]
    """The comparison."""
    notes: list[str] = field(default_factory=list)
    """What a reader has to know."""
    pictures: dict[str, Figure] = field(default_factory=dict)
    """Pictures by the stem of their file."""
    beside: str = "paper"
    """Heads the first column: `paper`, or whose values stand there."""

    @property
    def reached(self) -> bool:
        """False if a claimed cell fails."""
        return not any(cell.failed for cell in self.cells)

    def __str__(self) -> str:
        both = any(cell.before is not None for cell in self.cells)
        head = ("", self.beside, "after step", "", "before step", "")
        if not both:
            head = ("", self.beside, "ours", "", "", "")
        rows = [head]
        for c in self.cells:
            ours, told = c.verdicts
            before = _text(c.before) if c.before is not None else ""
            rows.append((c.label, _text(c.paper), _text(c.ours), ours, before, told))
        widths = [max(len(row[i]) for row in rows) for i in range(6)]
        lines = [f"{self.key}: {self.title}"]
        for label, paper, ours, verdict, before, told in rows:
            line = f"  {label:{widths[0]}s}  {paper:>{widths[1]}s}  {ours:>{widths[2]}s}"
            line += f"  {verdict:{widths[3]}s}  {before:>{widths[4]}s}  {told}"
            lines.append(line.rstrip())
        return "\n".join(lines + [f"  {note}" for note in self.notes])


Experiment = Callable[[], Section]


def at_most(label: str, paper: float, ours: float, before: float | None = None) -> Cell:
    """A cell that claims to be at or under the paper's figure; beside it the error before the step."""
    told = None if before is None else before <= paper
    return Cell(label, paper, ours, reached=ours <= paper, before=before, before_reached=told)


def equal(label: str, paper: Value, ours: Value) -> Cell:
    """A cell that claims to equal the paper's figure."""
    return Cell(label, paper, ours, reached=paper == ours)


def _text(value: Value) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return str(value) if isinstance(value, int) else f"{value:.4g}"
