"""A discrete low-pass filter without a line of Python at run time."""

import numpy as np
from pydrake.systems.primitives import LinearSystem

from fikm_drake.checks import check_below_one, check_counts, check_finite, check_period


class LowPassFilter(LinearSystem):
    """First-order discrete low-pass filter with feedthrough (Xu & Nechyba 1993, equations 30, 31).

    .. pydrake_system::

        name: LowPassFilter
        input_ports:
        - u0
        output_ports:
        - y0

    - **u0** (m): the signal.
    - **y0** (m), same unit: (1 − smoothing) · u0 + smoothing · its last value, of this very cycle.

    It is Drake's C++ LinearSystem, so it costs no Python call, converts to AutoDiffXd and
    symbolic Expression, and, like every linear filter, keeps a NaN that is fed to it: the block
    before it (`VariableGain`, `GainSupervisor`) lets none out.

    Args:
        size: m.
        period: of the control cycle [s].
        smoothing: weight of the last value [-]; 0 filters nothing. The paper's is 2/3.
        initial_value: the last value before the first cycle.

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(
        self,
        size: int,
        *,
        period: float,
        smoothing: float = 2.0 / 3.0,
        initial_value: float = 0.0,
    ) -> None:
        check_counts(size=size)
        start = check_finite("initial_value", initial_value)
        keep = check_below_one("smoothing", smoothing) * np.eye(size)
        new = np.eye(size) - keep
        super().__init__(keep, new, keep, new, check_period(period))
        self.configure_default_state(np.full(size, start))
