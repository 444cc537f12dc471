"""Rule bases with random singletons."""

import numpy as np
import pytest

from fikm_drake.fuzzy.integer import IntegerPartition, IntegerRuleBase


def make_rules(labels=(3, 3), outputs=4, *, seed=0, x=(0, 400), y=(0, 300), **options):
    """Rules over x and y whose singletons fill the 16 bits of the C tables."""
    first, second = IntegerPartition.even(*x, labels[0]), IntegerPartition.even(*y, labels[1])
    rng = np.random.default_rng(seed)
    singletons = rng.integers(-30000, 35536, (*labels, outputs))
    return IntegerRuleBase(first, second, singletons, **options)


@pytest.fixture(scope="session")
def rules_of():
    return make_rules
