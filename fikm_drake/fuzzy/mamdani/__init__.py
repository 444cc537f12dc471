"""Mamdani inference: rules whose conclusions are memberships.

`MamdaniConfig` is a system as data, `MamdaniSystem` the same compiled to arrays. An inference has
three steps, in that order: `Premises` (how strongly each rule fires), `Conclusion` (implication,
aggregation, defuzzification, once an output), and the default where no rule fires.
"""

from fikm_drake.fuzzy.mamdani.mamdani_config import FuzzyRule, MamdaniConfig
from fikm_drake.fuzzy.mamdani.mamdani_system import Inference, MamdaniSystem, load_mamdani
from fikm_drake.fuzzy.mamdani.parse_rules import parse_rules

__all__ = [
    "FuzzyRule",
    "Inference",
    "MamdaniConfig",
    "MamdaniSystem",
    "load_mamdani",
    "parse_rules",
]
