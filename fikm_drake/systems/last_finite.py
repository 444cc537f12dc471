"""The block that keeps NaN from a system that cannot bear it."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.checks import check_counts, check_period
from fikm_drake.systems.valid_port import declare_valid_port


class LastFinite(LeafSystem):
    """Passes a signal on, and the last finite sample of it while it is not finite.

    .. pydrake_system::

        name: LastFinite
        input_ports:
        - signal
        output_ports:
        - finite_signal
        - valid

    - **signal** (n).
    - **finite_signal** (n), same unit: the signal, or its last sample that was finite.
    - **valid** (1): 1 while the input is finite, else 0.

    For what stands before a MultibodyPlant: positions that are NaN end the process there.

    Args:
        size: n.
        period: of the samples [s].

    Raises:
        ValueError: naming the bad value.
    """

    def __init__(self, size: int, *, period: float) -> None:
        super().__init__()
        check_counts(size=size)
        signal = self.DeclareVectorInputPort("signal", size)
        self._signal = signal.Eval
        self.DeclareDiscreteState(size)
        self.DeclareVectorOutputPort(
            "finite_signal",
            size,
            self._calc,
            prerequisites_of_calc={signal.ticket(), self.xd_ticket()},
        )
        declare_valid_port(self)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def SetLast(self, context: Context, value: ArrayLike) -> None:
        """Set the value (n,) for a signal that has not been finite yet; zeros by default.

        Raises:
            ValueError: it is not n finite numbers.
            RuntimeError: the context is another system's.
        """
        self.ValidateContext(context)
        value = np.array(value, dtype=float)
        size = self.get_input_port(0).size()
        if value.shape != (size,) or not np.isfinite(value).all():
            raise ValueError(f"value must be {size} finite numbers, got {value.tolist()}")
        context.SetDiscreteState(value)

    def _calc(self, context: Context, output: BasicVector) -> None:
        signal = self._signal(context)
        good = all_finite(signal)
        output.set_value(signal if good else context.get_discrete_state_vector().value())

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        signal = self._signal(context)
        if all_finite(signal):
            discrete_state.set_value(signal)
