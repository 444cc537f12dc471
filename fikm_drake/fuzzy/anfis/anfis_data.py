"""What a trained ANFIS is made of, as YAML."""

from dataclasses import dataclass, field

import numpy as np

from fikm_drake.fuzzy.anfis.membership_kinds import KINDS

ORDERS = (0, 1)


@dataclass
class AnfisData:
    """A trained ANFIS of d inputs with m_1 x … x m_d rules."""

    names: list[str] = field(default_factory=list)
    """Names of the inputs, then of the output (d + 1)."""
    kind: str = "gaussian"
    """Shape of the memberships: one of `KINDS`."""
    order: int = 1
    """0: rules have constants; 1: linear functions of the inputs."""
    lower: list[float] = field(default_factory=list)
    """Least value of each input in the training data, scaled to −1 (d)."""
    upper: list[float] = field(default_factory=list)
    """Greatest value of each input in the training data, scaled to 1 (d)."""
    premises: list[list[list[float]]] = field(default_factory=list)
    """For each input the p parameters of its m_k memberships (d,p,m_k), see `MembershipKind`."""
    coefficients: list[list[float]] = field(default_factory=list)
    """For each rule, the last input running fastest: a constant, then the slopes by the scaled inputs."""
    training_error: list[float] = field(default_factory=list)
    """Root mean square error of each epoch."""
    validation_error: list[float] = field(default_factory=list)
    """The same over the validation data; empty if there were none."""

    def validate(self) -> None:
        """Raise ValueError, naming the bad value, unless this is an ANFIS."""
        if self.kind not in KINDS:
            raise ValueError(f"kind must be one of {tuple(KINDS)}, got {self.kind!r}")
        if self.order not in ORDERS:
            raise ValueError(f"order must be one of {ORDERS}, got {self.order!r}")
        d = len(self.premises)
        if not d or not (len(self.names) - 1 == len(self.lower) == len(self.upper) == d):
            raise ValueError(
                f"{d} inputs need as many bounds and one name more, got {len(self.lower)} and "
                f"{len(self.upper)} bounds, names {self.names}"
            )
        p, rules = len(KINDS[self.kind].names), 1
        for name, premise in zip(self.names, self.premises):
            counts = {len(row) for row in premise}
            if len(premise) != p or len(counts) != 1 or 0 in counts:
                raise ValueError(f"premises of {name!r} must be {p} rows of equal length")
            rules *= counts.pop()
        terms = 1 + self.order * d
        if len(self.coefficients) != rules or {len(row) for row in self.coefficients} != {terms}:
            raise ValueError(f"coefficients must be {rules} rows of {terms}")
        numbers = [row for premise in self.premises for row in premise] + self.coefficients
        numbers += [self.lower, self.upper, self.training_error, self.validation_error]
        if not np.isfinite(np.concatenate(numbers)).all():
            raise ValueError("an ANFIS must be made of finite numbers")
        for name, low, high in zip(self.names, self.lower, self.upper):
            if not low < high:
                raise ValueError(f"bounds of {name!r} must increase, got {low} and {high}")
