"""Inference and derivatives of an ANFIS on scaled inputs, a block of columns at a time.

Arrays run over the N values last (structure of arrays), so that numpy works on long rows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.inputs import InputScale
from fikm_drake.fuzzy.anfis.membership_kinds import MembershipKind


@dataclass(frozen=True)
class Network:
    """Premises of an ANFIS of d inputs: the memberships of each, and what a rule's output is made of.

    With the product as AND, the truth of rule (i, j, …) over the sum of all is a product of shares
    a_i b_j …, a_i = A_i(x) / Σ A(x): the grid of rules needs memberships only, never a sum over rules.
    """

    kind: MembershipKind
    """Shape of the memberships."""
    premises: tuple[Array, ...]
    """Parameters (p,m_k) of the memberships of input k."""
    order: int
    """0: a rule's output is a constant; 1: it is linear in the inputs."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of memberships (m_1, …, m_d)."""
        return tuple(parameters.shape[1] for parameters in self.premises)

    @property
    def num_terms(self) -> int:
        """Coefficients of a rule: 1, or 1 + d."""
        return 1 + self.order * len(self.premises)

    @property
    def num_coefficients(self) -> int:
        """Coefficients of all rules."""
        return int(np.prod(self.shape)) * self.num_terms

    @property
    def parameters(self) -> Array:
        """All premise parameters in one row (P,)."""
        return np.concatenate([parameters.ravel() for parameters in self.premises])

    def with_parameters(self, parameters: Array) -> "Network":
        """The same network with other premise parameters (P,)."""
        ends = np.cumsum([premise.size for premise in self.premises])[:-1]
        parts = np.split(parameters, ends)
        return replace(
            self, premises=tuple(part.reshape(old.shape) for part, old in zip(parts, self.premises))
        )

    def shares(self, x: Array) -> list[Array]:
        """Normalised memberships (m_k,N) of every input, from inputs (d,N)."""
        return [
            _normalised(self.kind.log_grades(row, premise))
            for row, premise in zip(x, self.premises)
        ]

    def regressors(self, x: Array) -> Array:
        """What the coefficients multiply (num_coefficients,N): the output is their sum."""
        shares = self.shares(x)
        weights = shares[0]
        for share in shares[1:]:
            weights = (weights[:, None, :] * share).reshape(-1, x.shape[1])
        return (weights[:, None, :] * self.terms(x)).reshape(-1, x.shape[1])

    def weigh(self, x: Array, values: Array) -> Array:
        """The regressors times values (N,), summed over the N (num_coefficients,)."""
        shares = self.shares(x)
        weighted = self.terms(x) * values
        for share in reversed(shares[1:]):
            weighted = (share[:, None, :] * weighted).reshape(-1, x.shape[1])
        return np.asarray(shares[0] @ weighted.T, dtype=float).ravel()

    def output(self, x: Array, coefficients: Array) -> Array:
        """Output (N,): one input is summed out after the other."""
        shares = self.shares(x)
        count = x.shape[1]
        left = coefficients.reshape(self.shape[0], -1).T @ shares[0]
        for share in shares[1:]:
            left = np.einsum("mrn,mn->rn", left.reshape(len(share), -1, count), share)
        return np.einsum("tn,tn->n", left, self.terms(x))

    def rules_at(self, x: Array, coefficients: Array) -> tuple[Array, Array]:
        """Weight and output of every rule (m_1,…,m_d) at one point (d,): their products add up."""
        x = x[:, None]
        weights = np.ones(1)
        for share in self.shares(x):
            weights = weights[..., None] * share[:, 0]
        outputs = coefficients.reshape(-1, self.num_terms) @ self.terms(x)[:, 0]
        return weights.reshape(self.shape), outputs.reshape(self.shape)

    def output_and_slopes(self, x: Array, coefficients: Array) -> tuple[Array, Array]:
        """Output (N,) and its derivatives (P,N) by the premise parameters, coefficients held."""
        shares = self.shares(x)
        rules = np.einsum("rt,tn->rn", coefficients.reshape(-1, self.num_terms), self.terms(x))
        rules = rules.reshape(*self.shape, -1)
        slopes = []
        for k, (row, premise) in enumerate(zip(x, self.premises)):
            outputs = rules  # of the memberships of input k: the others are summed out
            for j in reversed(range(len(shares))):
                if j != k:
                    share = shares[j].reshape((-1,) + (1,) * (outputs.ndim - j - 2) + (x.shape[1],))
                    outputs = (outputs * share).sum(axis=j)
            output = (shares[k] * outputs).sum(axis=0)
            by_log_grade = shares[k] * (outputs - output)
            slopes.append(self.kind.log_slopes(row, premise) * by_log_grade)
        return output, np.concatenate([slope.reshape(-1, x.shape[1]) for slope in slopes])

    def terms(self, x: Array) -> Array:
        """What a rule's coefficients multiply (num_terms,N): 1, then the inputs."""
        ones = np.ones((1, x.shape[1]))
        return np.concatenate([ones, x]) if self.order else ones


def even_network(kind: MembershipKind, memberships: tuple[int, ...], order: int) -> Network:
    """A network whose memberships divide each scaled input evenly."""
    return Network(kind, tuple(kind.start(count) for count in memberships), order)


def _normalised(log_grades: Array) -> Array:
    """Grades (m,N) over their sum; safe where every grade underflows."""
    grades = np.exp(log_grades - log_grades.max(axis=0))
    grades /= grades.sum(axis=0)
    return grades


def readable_rules(
    network: Network, coefficients: Array, scale: InputScale, names: Sequence[str]
) -> list[str]:
    """Rules in the units of the inputs, the last input running fastest; a membership goes by its center."""
    *inputs, output = names
    table = coefficients.reshape(-1, network.num_terms)
    slopes = table[:, 1:]
    constants = table[:, 0]
    if network.order:
        slopes = slopes / scale.half
        constants = constants - slopes @ scale.middle
    lines = []
    for r, rule in enumerate(np.ndindex(network.shape)):
        premise = " AND ".join(
            f"{name} is about {scale.middle[k] + scale.half[k] * network.premises[k][0, i]:.4g}"
            for k, (name, i) in enumerate(zip(inputs, rule))
        )
        terms = [f"{constants[r]:.4g}"]
        terms += [f"{'+-'[int(q < 0)]} {abs(q):.4g} {name}" for q, name in zip(slopes[r], inputs)]
        lines.append(f"IF {premise} THEN {output} = {' '.join(terms)}")
    return lines
