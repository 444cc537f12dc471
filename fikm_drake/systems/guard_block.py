"""The block that has the last word on a joint step."""

from math import inf

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.control.guard import Guard
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.systems.valid_port import declare_valid_port


class GuardBlock(LeafSystem):
    """Lets a joint step through as far as limits allow; stands right before `JointIntegrator`.

    .. pydrake_system::

        name: GuardBlock
        input_ports:
        - joint_step
        - command
        - command_velocity
        - limited
        output_ports:
        - joint_step
        - valid
        - limited

    - **joint_step** (n) [rad or m] in: what is asked for; anything.
    - **command** (n) [rad or m], **command_velocity** (n) [rad/s or m/s]: of `JointIntegrator`.
    - **limited** (1) in: 1 if limits took a part away before this block; may stay unconnected.
    - **joint_step** (n) [rad or m] out: finite, inside the limits of position, speed and acceleration,
      at most `max_joint_step` long; see `control.guard`.
    - **valid** (1): 1 while every input is finite, else 0. A step that is not finite counts as none,
      with limits of acceleration the joints then brake.
    - **limited** (1) out: 1 if this block or one before it took a part of the step away, else 0.

    Args:
        limits: of the joints.
        max_joint_step: a longer joint step is shortened to this length [rad or m].

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> limits = fd.JointLimits(-np.ones(2), np.ones(2), period=0.01, velocity_limits=2.0)
        >>> guard = fd.GuardBlock(limits)
        >>> context = guard.CreateDefaultContext()
        >>> for name, value in (("joint_step", [9, 0.01]), ("command", [0, 0])):
        ...     _ = guard.GetInputPort(name).FixValue(context, value)
        >>> _ = guard.GetInputPort("command_velocity").FixValue(context, [0, 0])
        >>> guard.GetOutputPort("joint_step").Eval(context).tolist()
        [0.02, 0.01]
    """

    def __init__(self, limits: JointLimits, *, max_joint_step: float = inf) -> None:
        super().__init__()
        self._limits, self._guard = limits, Guard(max_joint_step)
        n = len(limits.lower)
        step = self.DeclareVectorInputPort("joint_step", n)
        command = self.DeclareVectorInputPort("command", n)
        velocity = self.DeclareVectorInputPort("command_velocity", n)
        self._step, self._command, self._velocity = step.Eval, command.Eval, velocity.Eval
        inputs = {step.ticket(), command.ticket(), velocity.ticket()}
        self.DeclareVectorOutputPort("joint_step", n, self._calc, prerequisites_of_calc=inputs)
        declare_valid_port(self)
        self._before = self.DeclareVectorInputPort("limited", 1)
        self.DeclareVectorOutputPort(
            "limited",
            1,
            self._calc_limited,
            prerequisites_of_calc={*inputs, self._before.ticket()},
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        step, box = self._step(context), StepBox(self._limits, self._command(context))
        if not self._guard.surely_passes(step, box):
            step = self._guard(step, *box.bounds(self._velocity(context)))
        output.set_value(step)

    def _calc_limited(self, context: Context, output: BasicVector) -> None:
        taken = self.get_output_port(0).Eval(context)
        cut = not np.array_equal(taken, self._step(context))
        output[0] = cut or (self._before.HasValue(context) and self._before.Eval(context)[0] != 0.0)
