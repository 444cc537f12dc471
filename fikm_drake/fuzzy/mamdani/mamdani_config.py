"""A Mamdani system as data: what its YAML file holds."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from itertools import product

from fikm_drake.checks import check_counts
from fikm_drake.fuzzy.fuzzy_variable import NOT, FuzzyVariable

JOINS = ("and", "or")
NORMS = ("minimum", "product")
AGGREGATIONS = ("maximum", "sum")
DEFUZZIFICATIONS = (
    "centroid",
    "bisector",
    "mean_of_maximum",
    "smallest_of_maximum",
    "largest_of_maximum",
    "height",
)


@dataclass
class FuzzyRule:
    """IF x is A AND y is B THEN z is C; an input that is left out may be anything.

    Attributes:
        when: label by the name of an input, at least one; `not A` is one minus the grade of A.
        then: label by the name of an output, at least one.
        join: between the parts of `when`: `and`, or `or`.
    """

    when: dict[str, str] = field(default_factory=dict)
    then: dict[str, str] = field(default_factory=dict)
    join: str = "and"

    def holds(self, labels: dict[str, str]) -> bool:
        """Whether the premise holds where each input has just one label, with grade one."""
        parts = (
            labels[name] != label.removeprefix(NOT)
            if label.startswith(NOT)
            else labels[name] == label
            for name, label in self.when.items()
        )
        return all(parts) if self.join == "and" else any(parts)


@dataclass
class MamdaniConfig:
    """Variables, rules and the five choices of a Mamdani system.

    Attributes:
        name: what it is.
        inputs: inputs, in the order of the columns of the input array.
        outputs: outputs, in the order of the columns of the result.
        rules: rules; where none fires the output has its default.
        norm: AND: `minimum`, or `product`; OR is its dual, the maximum, or a + b - ab.
        implication: a rule cuts its conclusion off at its strength (`minimum`), or scales it
            (`product`).
        aggregation: conclusions are united by their `maximum`, or by their `sum`.
        defuzzification: `centroid` or `bisector` of the area, `mean_of_maximum`,
            `smallest_of_maximum` or `largest_of_maximum` of where it is highest, or `height`: the
            mean of cores weighted by strengths.
        samples: points of an output's range at which areas are sampled, if they are not exact.
    """

    name: str = ""
    inputs: list[FuzzyVariable] = field(default_factory=list)
    outputs: list[FuzzyVariable] = field(default_factory=list)
    rules: list[FuzzyRule] = field(default_factory=list)
    norm: str = "minimum"
    implication: str = "minimum"
    aggregation: str = "maximum"
    defuzzification: str = "centroid"
    samples: int = 201

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        for kind, variables in (("input", self.inputs), ("output", self.outputs)):
            if not variables:
                raise ValueError(f"needs at least one {kind}")
            for variable in variables:
                variable.validate()
        names = [variable.name for variable in [*self.inputs, *self.outputs]]
        if len(set(names)) != len(names):
            raise ValueError(f"names of variables must differ from one another, got {names}")
        for option, choices in (
            ("norm", NORMS),
            ("implication", NORMS),
            ("aggregation", AGGREGATIONS),
            ("defuzzification", DEFUZZIFICATIONS),
        ):
            if getattr(self, option) not in choices:
                raise ValueError(
                    f"{option} must be one of {choices}, got {getattr(self, option)!r}"
                )
        check_counts(2, samples=self.samples)
        if not self.rules:
            raise ValueError("needs at least one rule")
        for number, rule in enumerate(self.rules, start=1):
            if rule in self.rules[: number - 1]:
                raise ValueError(f"rule {number} is the same as an earlier one: {rule}")
            if rule.join not in JOINS:
                raise ValueError(f"rule {number}: join must be one of {JOINS}, got {rule.join!r}")
            _check_labels(f"rule {number}, when", rule.when, self.inputs, NOT)
            _check_labels(f"rule {number}, then", rule.then, self.outputs, "")
        concluded = {name for rule in self.rules for name in rule.then}
        for variable in self.outputs:
            if variable.name not in concluded:
                raise ValueError(f"no rule concludes on output {variable.name!r}")

    def output(self, name: str | None) -> FuzzyVariable:
        """The output of that name; None: the only one there is.

        Raises:
            ValueError: there is none, or there are several and no name.
        """
        found = [variable for variable in self.outputs if name in (None, variable.name)]
        if len(found) != 1:
            names = ", ".join(variable.name for variable in self.outputs)
            raise ValueError(f"output must be one of: {names}, got {name!r}")
        return found[0]

    def holes(self, output: str | None = None) -> list[dict[str, str]]:
        """Pairs (triples, …) of input labels about which no rule concludes on an output.

        Where memberships overlap a neighbouring rule may fire in a hole; `fired` of an inference
        tells.
        """
        name = self.output(output).name
        rules = [rule for rule in self.rules if name in rule.then]
        return [labels for labels in self._cases() if not any(r.holds(labels) for r in rules)]

    def _cases(self) -> list[dict[str, str]]:
        """All combinations of one label an input, the last input running fastest."""
        names = [variable.name for variable in self.inputs]
        labels = product(*(variable.labels for variable in self.inputs))
        return [dict(zip(names, case)) for case in labels]


def _check_labels(
    where: str, labels: dict[str, str], variables: list[FuzzyVariable], negation: str
) -> None:
    known = {variable.name: variable.labels for variable in variables}
    if not labels:
        raise ValueError(f"{where}: needs at least one of: {', '.join(known)}")
    for name, label in labels.items():
        if name not in known:
            raise ValueError(f"{where}: no variable {name!r}; there are: {', '.join(known)}")
        if label not in known[name] and label not in [negation + own for own in known[name]]:
            raise ValueError(
                f"{where}: {name!r} has no label {label!r}; there are: {', '.join(known[name])}"
            )
