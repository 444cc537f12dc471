"""Many ticks one after the other, without a Simulator."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle


class Rollout(NamedTuple):
    """N cycles of a controller whose robot does what it is told."""

    q: Array
    """What goes out after each cycle (N,n) [rad or m]."""
    joint_step: Array
    """dθ of each cycle (N,n) [rad or m]."""
    error: Array
    """e of each cycle, before its step (N,m) [m]."""
    gain: Array
    """K of each cycle (N,) [-]."""


def rollout(cycle: ControlCycle, targets: Sequence[Any], start: Array) -> Rollout:
    """Run the cycle along N targets from joint positions (n,), without a Simulator.

    Args:
        cycle: the tick.
        targets: N targets, one a cycle, as the task takes them.
        start: joint positions (n,) [rad or m].
    """
    state, smoothing = cycle.start(start), cycle.jerk_limit
    memory = smoothing.start(start) if smoothing else None
    ticks, commands = [], []
    for target in targets:
        q = state.command.copy()
        tick = cycle.tick(state, target, q)
        cycle.advance(state, target, q, tick)
        ticks.append(tick)
        if smoothing and memory is not None:
            smoothing.remember(memory, q)
            commands.append(smoothing.command(memory, state.command))
        else:
            commands.append(state.command.copy())
    return Rollout(
        np.array(commands),
        np.array([tick.joint_step for tick in ticks]),
        np.array([tick.error for tick in ticks]),
        np.array([tick.gain for tick in ticks]),
    )
