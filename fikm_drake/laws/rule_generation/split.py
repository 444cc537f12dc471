"""The record of one new membership."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Split:
    """A membership that the generator added (figure 5 of Xu and Nechyba, 1993).

    Attributes:
        epoch: number of sweeps over the data made before it.
        input: "dr" or "J".
        knot: peak of the new membership in the positive half of the range [unit of the input]; its
            mirror image -knot is added with it.
        error_before: inference error of the last sweep before it [unit of the output].
    """

    epoch: int
    input: str
    knot: float
    error_before: float
