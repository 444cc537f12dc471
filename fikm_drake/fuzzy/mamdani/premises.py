"""How strongly the rules fire."""

from collections.abc import Callable, Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.fuzzy_variable import NOT, FuzzyVariable
from fikm_drake.fuzzy.mamdani.mamdani_config import FuzzyRule
from fikm_drake.fuzzy.membership_stack import MembershipStack


def _probabilistic_sum(a: Array, b: Array) -> Array:
    return a + b - a * b


_OPERATORS: dict[tuple[str, str], Callable[[Array, Array], Array]] = {
    ("minimum", "and"): np.minimum,
    ("minimum", "or"): np.maximum,
    ("product", "and"): np.multiply,
    ("product", "or"): _probabilistic_sum,
}


class Premises:
    """The premises of all rules, compiled: grades once, then one operation for rules alike."""

    def __init__(
        self, inputs: Sequence[FuzzyVariable], rules: Sequence[FuzzyRule], norm: str
    ) -> None:
        """Compiles valid rules about valid inputs."""
        rows = [(variable, label) for variable in inputs for label in variable.labels]
        index = {(variable.name, label): row for row, (variable, label) in enumerate(rows)}
        self._stack = MembershipStack([variable.memberships[label] for variable, label in rows])
        self._input = np.array([inputs.index(variable) for variable, _ in rows])
        self._lower = np.array([[variable.lower] for variable in inputs])
        self._upper = np.array([[variable.upper] for variable in inputs])
        self._negates = any(label.startswith(NOT) for rule in rules for label in rule.when.values())

        alike: dict[tuple[str, int], list[int]] = {}
        for number, rule in enumerate(rules):
            alike.setdefault((rule.join, len(rule.when)), []).append(number)
        self._order = np.argsort(np.concatenate([*alike.values()]))
        self._groups = []
        for (join, _), numbers in alike.items():
            operands = np.array(
                [
                    [
                        index[name, label.removeprefix(NOT)] + len(rows) * label.startswith(NOT)
                        for name, label in rules[number].when.items()
                    ]
                    for number in numbers
                ]
            ).T
            self._groups.append((operands, _OPERATORS[norm, join]))

    def strengths(self, x: Array) -> Array:
        """Strengths of the rules.

        Args:
            x: inputs, shape (inputs, N); outside its range one counts as the nearest end of it.

        Returns:
            Strengths in [0, 1], shape (rules, N); 0 where a premise has an input that is NaN.
        """
        x = np.minimum(np.maximum(x, self._lower), self._upper)
        grades = self._stack.grades(x[self._input])
        if self._negates:
            grades = np.concatenate([grades, 1.0 - grades])
        groups = []
        for operands, operator in self._groups:
            group = grades[operands[0]]
            for operand in operands[1:]:
                group = operator(group, grades[operand])
            groups.append(group)
        strengths = groups[0] if len(groups) == 1 else np.concatenate(groups)[self._order]
        strengths[np.isnan(strengths)] = 0.0
        return strengths
