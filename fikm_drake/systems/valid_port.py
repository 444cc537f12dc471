"""The `valid` port that blocks share."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem, OutputPort

from fikm_drake.arrays import Array, all_finite


def is_finite(value: Array | RigidTransform) -> bool:
    """True if no number of a port's vector or pose is NaN or infinite."""
    if isinstance(value, RigidTransform):
        return bool(np.isfinite(value.GetAsMatrix34()).all())
    return all_finite(value)


def declare_valid_port(system: LeafSystem) -> OutputPort:
    """Declare an output `valid` (1): 1 while every input of `system` is finite, else 0.

    Call it after the inputs are declared. An input that is not connected counts as finite.
    """
    ports = [system.get_input_port(i) for i in range(system.num_input_ports())]

    def calc(context: Context, output: BasicVector) -> None:
        output[0] = float(all(is_finite(p.Eval(context)) for p in ports if p.HasValue(context)))

    return system.DeclareVectorOutputPort(
        "valid", 1, calc, prerequisites_of_calc={port.ticket() for port in ports}
    )
