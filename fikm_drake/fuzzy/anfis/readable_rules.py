"""Learned rules as text."""

from collections.abc import Sequence

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.fuzzy.anfis.input_scale import InputScale
from fikm_drake.fuzzy.anfis.network import Network


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
