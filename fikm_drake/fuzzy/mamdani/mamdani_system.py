"""Mamdani inference."""

import copy
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.yaml import yaml_dump_typed

from fikm_drake.arrays import Array, Bools
from fikm_drake.files import write_whole
from fikm_drake.fuzzy.mamdani.conclusion import Conclusion
from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig
from fikm_drake.fuzzy.mamdani.premises import Premises
from fikm_drake.fuzzy.mamdani.rule_text import rule_grid, rule_lines, rule_table
from fikm_drake.resources import load_model

CHUNK = 100_000
"""Numbers in the largest array of one pass over a batch: few enough for the cache."""


class Inference(NamedTuple):
    """What a Mamdani system infers."""

    values: Array
    """Outputs, shape (..., outputs), each in its unit; never NaN."""
    fired: Bools
    """Whether a rule fired for the output, same shape; where not, the value is the default."""


class MamdaniSystem:
    """Rules "IF x is A AND y is B THEN z is C" whose conclusions are memberships.

    A rule's strength is its grades joined by the norm; it cuts off or scales the membership of its
    conclusion; the conclusions are united, and the united membership is made a number. All is
    compiled to arrays when the system is built: one point and a million take the same path and give
    the same numbers. An instance never changes.
    """

    def __init__(self, config: MamdaniConfig) -> None:
        """Compiles a config, of which it keeps a copy.

        Raises:
            ValueError: the config is not valid; the message names the value and the valid ones.
        """
        config.validate()
        self._config = copy.deepcopy(config)
        self._premises = Premises(self._config.inputs, self._config.rules, config.norm)
        self._conclusions = [
            Conclusion(variable, self._config) for variable in self._config.outputs
        ]
        self._chunk = max(1, CHUNK // max(conclusion.size for conclusion in self._conclusions))

    @property
    def config(self) -> MamdaniConfig:
        """A copy of the variables, the rules and the choices."""
        return copy.deepcopy(self._config)

    def __repr__(self) -> str:
        config = self._config
        inputs, outputs = (
            ", ".join(v.name for v in variables) for variables in (config.inputs, config.outputs)
        )
        return f"<{type(self).__name__} {outputs}({inputs}), {len(config.rules)} rules>"

    def __call__(self, inputs: ArrayLike) -> Inference:
        """Infers the outputs of one point or of many.

        Args:
            inputs: shape (..., inputs), such as (2,) or (N, 2), each in its unit. Outside its range
                an input counts as the nearest end of it. A rule with an input that is NaN does not
                fire.

        Returns:
            Outputs and whether a rule fired for each, both of shape (..., outputs).

        Raises:
            ValueError: the last dimension is not the number of inputs.
        """
        columns, shape = self._columns(inputs)
        values = np.empty((len(self._conclusions), columns.shape[1]))
        fired = np.empty(values.shape, dtype=bool)
        for start in range(0, columns.shape[1], self._chunk):
            part = slice(start, start + self._chunk)
            strengths = self._premises.strengths(columns[:, part])
            for row, conclusion in enumerate(self._conclusions):
                values[row, part], fired[row, part] = conclusion(strengths)
        shape = (*shape, len(self._conclusions))
        return Inference(values.T.reshape(shape), fired.T.reshape(shape))

    def strengths(self, inputs: ArrayLike) -> Array:
        """How strongly each rule fires, in [0, 1].

        Args:
            inputs: shape (..., inputs), as for a call.

        Returns:
            Strengths, shape (..., rules).

        Raises:
            ValueError: the last dimension is not the number of inputs.
        """
        columns, shape = self._columns(inputs)
        return self._premises.strengths(columns).T.reshape(*shape, len(self._config.rules))

    def rules(self) -> list[str]:
        """Readable rules, such as `IF x is A AND y is not B THEN z is C`."""
        return rule_lines(self._config)

    def table(self) -> str:
        """The rules as a table with a column for each variable."""
        return rule_table(self._config)

    def grid(self, output: str | None = None) -> str:
        """The rules of two inputs as a grid: rows follow the first input, `-` is a hole.

        Args:
            output: name of an output; None: the only one there is.

        Raises:
            ValueError: there are not two inputs, or no such output.
        """
        return rule_grid(self._config, output)

    def holes(self, output: str | None = None) -> list[dict[str, str]]:
        """Combinations of input labels about which no rule concludes on an output.

        Where memberships overlap, the rule of a neighbour may fire in a hole; `fired` tells.

        Args:
            output: name of an output; None: the only one there is.

        Raises:
            ValueError: there is no such output.
        """
        return self._config.holes(output)

    def save(self, path: str | Path) -> None:
        """Write the config as YAML, which `load_mamdani` reads.

        Raises:
            OSError: the file cannot be written.
        """
        write_whole(path, yaml_dump_typed(self._config))

    def _columns(self, inputs: ArrayLike) -> tuple[Array, tuple[int, ...]]:
        """Inputs as columns (inputs, N), and the shape of the points."""
        x = np.asarray(inputs, dtype=float)
        size = len(self._config.inputs)
        if x.ndim == 0 or x.shape[-1] != size:
            names = ", ".join(variable.axis for variable in self._config.inputs)
            raise ValueError(f"inputs must have shape (..., {size}): {names}; got {x.shape}")
        return x.reshape(-1, size).T, x.shape[:-1]


def load_mamdani(name_or_path: str | Path) -> MamdaniSystem:
    """Load a Mamdani system by the name of one of ours or from a YAML file of your own.

    Args:
        name_or_path: such as `labvolt_theta3`, or a path that ends in .yaml.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file does not describe a Mamdani system; the message says what is wrong.
    """
    config = load_model(MamdaniConfig, name_or_path, folder="fuzzy", kind="fuzzy system")
    return MamdaniSystem(config)
