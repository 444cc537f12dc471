"""An adaptive-network-based fuzzy inference system."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.yaml import yaml_dump_typed

from fikm_drake.arrays import Array
from fikm_drake.files import write_whole
from fikm_drake.fuzzy.anfis.anfis_data import ORDERS, AnfisData
from fikm_drake.fuzzy.anfis.inputs import InputScale, checked_inputs, checked_rows
from fikm_drake.fuzzy.anfis.membership_kinds import KINDS
from fikm_drake.fuzzy.anfis.network import Network, even_network, readable_rules
from fikm_drake.fuzzy.anfis.one_blas_thread import one_blas_thread
from fikm_drake.fuzzy.anfis.projection import LeastSquares
from fikm_drake.fuzzy.anfis.training import METHODS, first_networks
from fikm_drake.resources import load_yaml

RIDGE = 1e-12
BLOCK = 1 << 16
"""Intermediate numbers of a prediction that are held at a time, so that they stay in the cache."""


class Anfis:
    """An adaptive-network-based fuzzy inference system (Jang 1993) of any number of inputs.

    Rules "IF x is A_i AND y is B_j THEN z = p + q x + r y", one for every choice of a membership of each
    input, with the product as AND and the weighted average as output. Memberships and coefficients are
    learned. Inputs are scaled to [−1, 1] by the range of the training data; values further than a
    twentieth of that range outside count as the nearest that are not.

        anfis = fd.Anfis(memberships=(8, 8)).fit(X, Y, method="variable_projection")
        anfis.predict([[1.0, 2.0]])

    Args:
        memberships: how many each input has, one number an input.
        kind: shape of the memberships, `gaussian` or `bell`.
        order: 0: the rules have constants (r = q = 0); 1: linear functions.
        names: of the inputs and of the output, for `rules`; by default x1 … xd and y.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        memberships: Sequence[int] = (8, 8),
        kind: str = "gaussian",
        order: int = 1,
        *,
        names: Sequence[str] | None = None,
    ) -> None:
        counts = tuple(memberships) if isinstance(memberships, Iterable) else ()
        if not counts or not all(isinstance(m, (int, np.integer)) and m > 0 for m in counts):
            raise ValueError(
                f"memberships must be positive integers, one an input, got {memberships!r}"
            )
        if kind not in KINDS:
            raise ValueError(f"kind must be one of {tuple(KINDS)}, got {kind!r}")
        if order not in ORDERS:
            raise ValueError(f"order must be one of {ORDERS}, got {order!r}")
        usual = [*(f"x{k}" for k in range(1, len(counts) + 1)), "y"]
        self._names = usual if names is None else list(names)
        if len(self._names) != len(counts) + 1:
            raise ValueError(f"names must be {len(counts) + 1}, the output's last, got {names!r}")
        self._kind = kind
        self._network = even_network(KINDS[kind], counts, order)
        self._coefficients: Array | None = None
        self._scale = InputScale(np.full(len(counts), -1.0), np.ones(len(counts)))
        self._errors: list[float] = []
        self._validation_errors: list[float] = []

    @property
    def memberships(self) -> tuple[int, ...]:
        """How many memberships each input has."""
        return self._network.shape

    @property
    def kind(self) -> str:
        """Shape of the memberships."""
        return self._kind

    @property
    def order(self) -> int:
        """0 or 1: constants or linear functions."""
        return self._network.order

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs, then of the output."""
        return tuple(self._names)

    @property
    def num_rules(self) -> int:
        """The number of rules."""
        return int(np.prod(self.memberships))

    @property
    def input_range(self) -> tuple[Array, Array]:
        """Least and greatest value of each input in the training data, two (d,)."""
        return self._scale.lower.copy(), self._scale.upper.copy()

    @property
    def training_error(self) -> Array:
        """Root mean square error over the training data after each epoch."""
        return np.array(self._errors)

    @property
    def validation_error(self) -> Array:
        """Root mean square error over the validation data after each epoch; empty without them."""
        return np.array(self._validation_errors)

    def __repr__(self) -> str:
        *inputs, output = self._names
        size = " x ".join(map(str, self.memberships))
        state = "not trained" if self._coefficients is None else f"{len(self._errors)} epochs"
        return f"<Anfis {output}({', '.join(inputs)}), {size} {self._kind} rules, {state}>"

    @one_blas_thread()
    def fit(
        self,
        X: ArrayLike,
        Y: ArrayLike,
        *,
        epochs: int = 150,
        method: str = "hybrid",
        ridge: float = RIDGE,
        starts: int = 1,
        seed: int = 0,
        validation: tuple[ArrayLike, ArrayLike] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Anfis:
        """Learn from data, from evenly spaced memberships on; the same data give the same result.

        The best epoch of all starts is kept: that of the least error over the validation data if there
        are any, else over the training data. If it is interrupted, the best so far stays. Memory is
        bounded by a copy of the data, however many rows there are.

        Args:
            X: inputs (N,d), finite, none of them constant.
            Y: wanted outputs (N,), finite.
            epochs: how many.
            method: `hybrid`: least squares and a step down the gradient (Jang 1993);
                `variable_projection`: Levenberg-Marquardt steps, twice the time and far more progress.
            ridge: how much large coefficients are avoided [-]. Rules where there are no data need a
                little; the less the data cover, the more.
            starts: from how many partitions, since training ends in a local minimum: the even one, then
                others with their memberships moved at random.
            seed: of the random partitions.
            validation: inputs and wanted outputs that are not learned from.
            progress: called after each epoch with the fraction done.

        Returns:
            This object.

        Raises:
            ValueError: naming the bad value.
        """
        X, Y = checked_rows("X", X, "Y", Y, len(self.memberships))
        if validation is not None:
            validation = checked_rows(
                "validation X", validation[0], "validation Y", validation[1], len(self.memberships)
            )
        if method not in METHODS:
            raise ValueError(f"method must be one of {tuple(METHODS)}, got {method!r}")
        for option, value in (("epochs", epochs), ("starts", starts)):
            if not isinstance(value, (int, np.integer)) or value < 1:
                raise ValueError(f"{option} must be a positive integer, got {value!r}")
        if not 0.0 < ridge < np.inf:
            raise ValueError(f"ridge must be finite and positive, got {ridge!r}")
        lower, upper = X.min(axis=0), X.max(axis=0)
        for name, low, high in zip(self._names, lower, upper):
            if not low < high:
                raise ValueError(f"input {name!r} is always {low}: leave it out")

        scale = InputScale(lower, upper)
        unit = float(np.abs(Y).max()) or 1.0  # first step and damping are for outputs of about 1
        data = LeastSquares(scale.scaled(X), Y / unit, ridge)
        best = np.inf
        even = even_network(KINDS[self._kind], self.memberships, self.order)
        for k, network in enumerate(first_networks(even, starts, seed)):
            errors: list[float] = []
            validation_errors: list[float] = []
            for epoch, state in zip(range(1, epochs + 1), METHODS[method](data, network)):
                error = unit * data.rms_error(*state)
                errors.append(error)
                coefficients = unit * state.coefficients
                if validation is not None:
                    x, y = validation
                    output = self._output(scale.scaled(x), state.network, coefficients)
                    error = float(np.sqrt(np.mean((output - y) ** 2)))
                    validation_errors.append(error)
                if error < best:
                    best = error
                    self._scale, self._network = scale, state.network
                    self._coefficients = coefficients
                    self._errors, self._validation_errors = errors, validation_errors
                if progress:
                    progress((k + epoch / epochs) / starts)
        return self

    def predict(self, X: ArrayLike) -> Array:
        """The outputs (N,) for inputs (N,d); NaN where an input is NaN.

        Raises:
            ValueError: the inputs have another shape, or nothing has been learned yet.
        """
        X = checked_inputs("X", X, len(self.memberships))
        return self._output(self._scale.scaled(X), self._network, self._trained())

    def grades(self, k: int, values: ArrayLike) -> Array:
        """Grades (m_k,N) of the memberships of input k (from 0) at values (N,) of it."""
        x = (np.asarray(values, dtype=float) - self._scale.middle[k]) / self._scale.half[k]
        return np.exp(self._network.kind.log_grades(x, self._network.premises[k]))

    def rules_at(self, point: ArrayLike) -> tuple[Array, Array]:
        """What every rule says at one point (d,): weights that add up to 1, and outputs, (m_1,…,m_d) each.

        Raises:
            ValueError: the point has another shape, or nothing has been learned yet.
        """
        x = self._scale.scaled(checked_inputs("point", np.atleast_2d(point), len(self.memberships)))
        return self._network.rules_at(x[:, 0], self._trained())

    def rules(self) -> list[str]:
        """Readable rules, the last input running fastest; a membership goes by its center.

        Raises:
            ValueError: nothing has been learned yet.
        """
        return readable_rules(self._network, self._trained(), self._scale, self._names)

    def to_data(self) -> AnfisData:
        """Everything, as what is written to a file.

        Raises:
            ValueError: nothing has been learned yet.
        """
        return AnfisData(
            names=list(self._names),
            kind=self._kind,
            order=self.order,
            lower=self._scale.lower.tolist(),
            upper=self._scale.upper.tolist(),
            premises=[premise.tolist() for premise in self._network.premises],
            coefficients=self._trained().reshape(self.num_rules, -1).tolist(),
            training_error=list(self._errors),
            validation_error=list(self._validation_errors),
        )

    @classmethod
    def from_data(cls, data: AnfisData) -> Anfis:
        """The trained ANFIS that the data describe.

        Raises:
            ValueError: naming the bad value.
        """
        data.validate()
        counts = [len(premise[0]) for premise in data.premises]
        anfis = cls(counts, data.kind, data.order, names=data.names)
        premises = tuple(np.array(premise) for premise in data.premises)
        anfis._network = Network(KINDS[data.kind], premises, data.order)
        anfis._coefficients = np.array(data.coefficients).ravel()
        anfis._scale = InputScale(np.array(data.lower), np.array(data.upper))
        anfis._errors, anfis._validation_errors = data.training_error, data.validation_error
        return anfis

    def save(self, path: str | Path) -> None:
        """Write a YAML file that `load` reads, to the last bit.

        Raises:
            OSError: the file cannot be written.
            ValueError: nothing has been learned yet.
        """
        write_whole(path, yaml_dump_typed(self.to_data()))

    @classmethod
    def load(cls, path: str | Path) -> Anfis:
        """Read a file that `save` wrote.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is not such a file; the message says what is wrong.
        """
        data = load_yaml(AnfisData, Path(path), kind="ANFIS")
        try:
            return cls.from_data(data)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    def _trained(self) -> Array:
        if self._coefficients is None:
            raise ValueError("nothing has been learned yet: call fit first")
        return self._coefficients

    @staticmethod
    def _output(x: Array, network: Network, coefficients: Array) -> Array:
        """Output (N,), a block of columns after the other."""
        output = np.empty(x.shape[1])
        columns = max(BLOCK * network.shape[0] // network.num_coefficients, 1)
        for start in range(0, output.size, columns):
            block = slice(start, start + columns)
            output[block] = network.output(x[:, block], coefficients)
        return output
