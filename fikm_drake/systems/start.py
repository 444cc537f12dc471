"""Start where the robot is: what the blocks that keep a joint command share."""

import warnings
from collections.abc import Callable

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    InputPort,
    LeafSystem,
)

from fikm_drake.arrays import Array, all_finite

_PLACED = 0  # the numeric parameter that says that somebody has set the positions


def declare_start(
    system: LeafSystem,
    port: InputPort,
    start: Callable[[DiscreteValues, Array], None],
    *,
    warns: bool = True,
) -> None:
    """Declare the initialization event that starts a command at what a port measures.

    Where nothing is connected or the measurement is not finite the command starts where
    `SetPositions` put it; without that at the plant's default posture, with a warning.

    Args:
        system: the block; it has no numeric parameters of its own.
        port: the measured joint positions (n), connected or not [rad or m].
        start: writes joint positions (n,) into the block's discrete state, at rest.
        warns: False where another block warns of the same start.
    """
    system.DeclareNumericParameter(BasicVector([0.0]))

    def initialize(context: Context, discrete_state: DiscreteValues) -> EventStatus:
        measured = port.Eval(context) if port.HasValue(context) else None
        if measured is not None and all_finite(measured):
            start(discrete_state, measured)
        elif warns and context.get_numeric_parameter(_PLACED)[0] == 0.0:
            warnings.warn(
                f"{system.get_name() or type(system).__name__} starts at the plant's default "
                "posture, wherever the robot is: connect its port estimated_position, or call "
                "SetPositions(context, q) first",
                stacklevel=2,
            )
        return EventStatus.Succeeded()

    system.DeclareInitializationDiscreteUpdateEvent(initialize)


def mark_placed(context: Context) -> None:
    """Remember in a block's context that somebody has set its positions."""
    context.get_mutable_numeric_parameter(_PLACED).SetAtIndex(0, 1.0)
