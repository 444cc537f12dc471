"""Numbers of memberships that are none."""

import pytest

import fikm_drake as fd


@pytest.mark.parametrize("memberships", [3, (), (0, 4), (2.5, 2), None])
def test_memberships_are_named(memberships):
    with pytest.raises(ValueError, match="memberships must be positive integers, one an input"):
        fd.Anfis(memberships=memberships)
