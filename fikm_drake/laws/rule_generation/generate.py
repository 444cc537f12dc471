"""One entrance to the methods of rule generation."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from fikm_drake.laws.rule_generation.araki import generate_araki
from fikm_drake.laws.rule_generation.generated_rule_base import GeneratedRuleBase
from fikm_drake.laws.rule_generation.least_squares import generate_least_squares

METHODS: dict[str, Callable[..., GeneratedRuleBase]] = {
    "araki": generate_araki,
    "least_squares": generate_least_squares,
}
"""Generators by name."""


def generate_rule_base(
    j_max: float,
    *,
    method: str = "araki",
    max_error: float = 0.0013,
    dr_max: float = 0.1,
    **options: float,
) -> GeneratedRuleBase:
    """Generates the rules for dθ ≈ dr / J (sections 2.4 and 2.5 of Xu and Nechyba, 1993).

    Results are cached: an arm has several Jacobian elements of the same range, and a rule base
    never changes.

    Args:
        j_max: half the range of J, equation 11; finite, positive.
        method: "araki", the paper's generator, which compares its in-sweep error with max_error; or
            "least_squares", the fewest rules whose error over the whole table is below it.
        max_error: e_max, absolute [unit of dθ]; finite, positive.
        dr_max: half the range of dr; finite, positive. To stretch the range at the same relative
            accuracy, scale the result instead: `.scaled(k, k)`.
        **options: for "araki" the further keywords of `generate_araki`; none for "least_squares".

    Returns:
        The rule base, a function dθ(dr, J).

    Raises:
        ValueError: an argument is out of its range.
        TypeError: the method has no such option.
    """
    if method not in METHODS:
        raise ValueError(f"method must be one of {sorted(METHODS)}, got {method!r}")
    return _generate(
        method, float(j_max), float(max_error), float(dr_max), tuple(sorted(options.items()))
    )


@lru_cache(maxsize=256)
def _generate(
    method: str,
    j_max: float,
    max_error: float,
    dr_max: float,
    options: tuple[tuple[str, float], ...],
) -> GeneratedRuleBase:
    return METHODS[method](j_max, max_error=max_error, dr_max=dr_max, **dict(options))
