"""How many targets ended how, as text."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


def count_statuses(status: NDArray[np.int_], kind: type[IntEnum]) -> str:
    """Such as `3 solved, 1 unreachable`; empty for no targets.

    Args:
        status: (N,) values of `kind`.
        kind: the statuses there are, in the order of the text.
    """
    return ", ".join(
        f"{np.count_nonzero(status == value)} {value.name.lower()}"
        for value in kind
        if (status == value).any()
    )
