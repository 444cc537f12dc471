"""A paper's figures beside ours, as text."""

from collections.abc import Callable
from dataclasses import dataclass, field

from matplotlib.figure import Figure

Value = float | str | None


@dataclass(frozen=True)
class Cell:
    """One figure of a paper and ours."""

    label: str
    """What is compared, with its unit."""
    paper: Value
    """The paper's; None: it gives none."""
    ours: Value
    """Ours, measured or computed by this run."""
    reached: bool | None = None
    """Whether ours reaches what we claim; None: nothing is claimed."""


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

    @property
    def reached(self) -> bool:
        """False if a claimed cell fails."""
        return all(cell.reached is not False for cell in self.cells)

    def __str__(self) -> str:
        rows = [("", "paper", "ours", "")]
        rows += [(c.label, _text(c.paper), _text(c.ours), _verdict(c)) for c in self.cells]
        widths = [max(len(row[i]) for row in rows) for i in range(4)]
        lines = [f"{self.key}: {self.title}"]
        lines += [
            f"  {label:{widths[0]}s}  {paper:>{widths[1]}s}  {ours:>{widths[2]}s}  {verdict}".rstrip()
            for label, paper, ours, verdict in rows
        ]
        return "\n".join(lines + [f"  {note}" for note in self.notes])


Experiment = Callable[[], Section]


def at_most(label: str, paper: float, ours: float) -> Cell:
    """A cell that claims to be at or under the paper's figure."""
    return Cell(label, paper, ours, reached=ours <= paper)


def equal(label: str, paper: Value, ours: Value) -> Cell:
    """A cell that claims to equal the paper's figure."""
    return Cell(label, paper, ours, reached=paper == ours)


def _text(value: Value) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return str(value) if isinstance(value, int) else f"{value:.4g}"


def _verdict(cell: Cell) -> str:
    return {None: "", True: "ok", False: "NOT REACHED"}[cell.reached]
