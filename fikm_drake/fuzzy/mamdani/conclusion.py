"""From the strengths of the rules to one output."""

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani.aggregate import Aggregate
from fikm_drake.fuzzy.mamdani.defuzzification import DEFUZZIFY
from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig

LEAST_STRENGTH = 1e-100
"""Least strength of a rule that fires; what is less could underflow in an area."""


class Conclusion:
    """Implication, aggregation and defuzzification of one output.

    Rules with the same label are united by their strengths, before any membership is looked at.
    Only where cut-off conclusions are added has each rule a conclusion of its own.
    """

    def __init__(self, variable: FuzzyVariable, config: MamdaniConfig) -> None:
        """Prepares an output of a valid config."""
        self._bounds = variable.lower, variable.upper
        middle = 0.5 * (variable.lower + variable.upper)
        self._default = middle if variable.default is None else variable.default
        cuts_off, adds = config.implication == "minimum", config.aggregation == "sum"

        name = variable.name
        concluding = [n for n, rule in enumerate(config.rules) if name in rule.then]
        concluding.sort(key=lambda n: variable.labels.index(config.rules[n].then[name]))
        labels = [config.rules[n].then[name] for n in concluding]
        if cuts_off and adds:
            starts = list(range(len(labels)))
        else:
            starts = [n for n, label in enumerate(labels) if n == 0 or label != labels[n - 1]]
        self._rules, self._starts = np.array(concluding), np.array(starts)
        self._unite = np.add if adds else np.maximum
        self._aggregate = Aggregate(
            [variable.memberships[labels[n]] for n in starts],
            self._bounds,
            cuts_off=cuts_off,
            adds=adds,
            samples=config.samples,
        )
        self._defuzzify = DEFUZZIFY[config.defuzzification]

    @property
    def size(self) -> int:
        """Numbers in the largest array that a point needs."""
        return self._aggregate.size

    def __call__(self, strengths: Array) -> tuple[Array, Array]:
        """The output and whether a rule fired.

        Args:
            strengths: of all rules, shape (rules, N).

        Returns:
            The output, shape (N,), in the unit of the variable, inside its range; the default where
            no rule fired. Whether one did, shape (N,).
        """
        united = self._unite.reduceat(strengths[self._rules], self._starts, axis=0)
        fired = np.maximum.reduce(united) > LEAST_STRENGTH
        if fired.all():
            return self._value(united), fired
        values = np.full(fired.shape, self._default)
        if fired.any():
            values[fired] = self._value(united[:, fired])
        return values, fired

    def _value(self, strengths: Array) -> Array:
        value = self._defuzzify(self._aggregate, strengths)
        return np.minimum(np.maximum(value, self._bounds[0]), self._bounds[1])
