"""What rules say at one point, in the form that all engines share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from fikm_drake.arrays import Array


@dataclass(frozen=True)
class ViewedVariable:
    """An input or an output of a fuzzy system."""

    name: str
    """Such as `x`."""
    unit: str
    """Such as `m`; empty: none."""
    lower: float
    """Lower end of what is shown, in the unit."""
    upper: float
    """Upper end."""
    labels: tuple[str, ...] = ()
    """Labels of its memberships, in the order of their cores; empty for numbers."""
    grades: Callable[[Array], Array] | None = None
    """Values (N,) to grades (N,m) in the order of the labels; None for numbers."""
    tops: tuple[float, ...] = ()
    """Where memberships have their greatest grades, so that a picture does not miss them."""
    step: float = 0.0
    """Distance of values that it can have, such as 1 for integers; 0: any."""

    @property
    def axis(self) -> str:
        """Name and unit, such as `x [m]`."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class ViewedRule:
    """A rule at one point."""

    text: str
    """`IF x is A AND y is B THEN z is C`."""
    when: dict[str, tuple[str, bool]]
    """By name of an input: its label, and whether the premise is that it is *not* that."""
    strength: float
    """How strongly it fires, in [0, 1]."""
    conclusion: float | Array
    """A number; or the grades (K,) of its membership over `Explanation.span`."""
    said: Array | None = None
    """The membership as this rule says it here, cut off or scaled (K,); None for a number."""


@dataclass(frozen=True)
class Explanation:
    """Every rule of a fuzzy system at one point, and what comes of them.

    For people: `print(explanation)` lists the rules that fire, the strongest first.
    """

    point: dict[str, float]
    """The inputs by name."""
    output: ViewedVariable
    """The output that is explained."""
    rules: tuple[ViewedRule, ...]
    """All rules that conclude on it."""
    value: float
    """The output, in its unit."""
    fired: bool
    """False: no rule fired, and the value is the default."""
    method: str
    """How the number came about, such as `centroid`."""
    span: Array | None = None
    """Where memberships of the output are given (K,); None for numbers."""
    united: Array | None = None
    """The united memberships (K,); None for numbers."""
    cuts_off: bool = True
    """Whether a strength cuts a membership off, or scales it."""
    adds: bool = False
    """Whether memberships are united by their sum, or their maximum."""

    def strongest(self, most: int | None = None) -> tuple[ViewedRule, ...]:
        """The rules that fire, the strongest first, at most so many."""
        firing = [rule for rule in self.rules if rule.strength > 0.0]
        return tuple(sorted(firing, key=lambda rule: -rule.strength)[:most])

    def __str__(self) -> str:
        at = ", ".join(f"{name} = {value:.4g}" for name, value in self.point.items())
        lines = [f"{rule.strength:6.3f}  {rule.text}" for rule in self.strongest()]
        end = f"{self.output.axis} = {self.value:.4g}"
        how = f"by {self.method}" if self.fired else "the default: no rule fires"
        return "\n".join([f"at {at}:", *lines, f"{end}, {how}"])


class FuzzyView(Protocol):
    """A fuzzy system as what the pictures need."""

    @property
    def inputs(self) -> Sequence[ViewedVariable]:
        """The d inputs."""

    @property
    def outputs(self) -> Sequence[ViewedVariable]:
        """The outputs."""

    def values(self, points: Array) -> Array:
        """Outputs (…,outputs) at points (…,d); NaN where no rule fires."""

    def explain(self, point: Array, output: int = 0) -> Explanation:
        """The rules at a point (d,), for one output by its number."""
