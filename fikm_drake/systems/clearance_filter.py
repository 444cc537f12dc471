"""The block that keeps a joint step clear of obstacles."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.control.clearance import Clearance, ClearanceInfo
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.systems.valid_port import declare_valid_port

FAR = 1e6
"""What `clearance` reads where nothing is within the influence distance [m]."""


class ClearanceFilter(LeafSystem):
    """Turns a joint step into the nearest one that keeps clear, see `Clearance`.

    .. pydrake_system::

        name: ClearanceFilter
        input_ports:
        - asked_step
        - position
        - command
        - command_velocity
        - obstacle_position
        output_ports:
        - cleared
        - joint_step
        - clearance
        - blocked
        - blocking_bodies
        - obstacles_near
        - valid

    - **asked_step** (n) [rad or m]: of a law, or another's velocity command times the period.
    - **position** (n) [rad or m]: the joints.
    - **command** (n) [rad or m], **command_velocity** (n) [rad/s or m/s], only with `limits`: of
      `JointIntegrator`; the bounds of this cycle's step follow from them.
    - **obstacle_position** (p): positions of all in the checker's plant that is not the arm, in its order.
      The port exists if there is any such; unconnected: where they are by default.
    - **cleared** (n + 4): the four outputs that follow, side by side.
    - **joint_step** (n) [rad or m]: zeros while an input is not finite.
    - **clearance** (1) [m]: of the nearest pair before the step; 1e6 if none is as near as the influence
      distance.
    - **blocked** (1): 1 while obstacles take away half of the step or more, else 0.
    - **blocking_bodies** (2): indices in the checker's plant of the pair that pushes most, −1 for none;
      `BlockingPair(context)` gives their names.
    - **obstacles_near** (1): 1 while something is as near as the influence distance, else 0.
    - **valid** (1): 1 while every input is finite, else 0.

    Args:
        clearance: what keeps clear; its period is the block's.
        task: what counts: joints that are left free make up for what obstacles take of it; None: nothing.
        limits: of the joints; None: they are not seen.

    Example:
        >>> import fikm_drake as fd
        >>> arm = fd.load_arm("panda")
        >>> clearance = fd.Clearance(fd.MakeCollisionChecker(arm), period=0.01)
        >>> fd.ClearanceFilter(clearance).GetOutputPort("joint_step").size()
        7
    """

    def __init__(
        self,
        clearance: Clearance,
        *,
        task: TaskKinematics | None = None,
        limits: JointLimits | None = None,
    ) -> None:
        super().__init__()
        n = clearance.num_joints
        self._clearance, self._task, self._limits = clearance, task, limits
        self._hold = np.zeros(n)
        self._step = self.DeclareVectorInputPort("asked_step", n).Eval
        position = self.DeclareVectorInputPort("position", n)
        self._position = position.Eval
        if limits:
            self._command = self.DeclareVectorInputPort("command", n).Eval
            self._velocity = self.DeclareVectorInputPort("command_velocity", n).Eval
        self._others = None
        count = len(clearance.default_others)
        if count:
            self._others = self.DeclareVectorInputPort("obstacle_position", count)
        # One computation for all outputs: Drake caches this port.
        self._all = self.DeclareVectorOutputPort(
            "cleared",
            n + 4,
            self._calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )
        for name, part in (
            ("joint_step", slice(0, n)),
            ("clearance", slice(n, n + 1)),
            ("blocked", slice(n + 1, n + 2)),
            ("blocking_bodies", slice(n + 2, n + 4)),
        ):
            self._declare_part(name, part)
        seen = {position.ticket()}
        if self._others is not None:
            seen.add(self._others.ticket())
        self.DeclareVectorOutputPort(
            "obstacles_near", 1, self._calc_near, prerequisites_of_calc=seen
        )
        declare_valid_port(self)
        if count:
            self.DeclareDiscreteState(np.full(count, np.nan))
            self.DeclarePeriodicDiscreteUpdateEvent(clearance.period, 0.0, self._update)

    def BlockingPair(self, context: Context) -> tuple[str, str]:
        """Scoped names of the bodies that push most in this block's context; empty for none."""
        one, two = self.GetOutputPort("blocking_bodies").Eval(context)
        return self._clearance.names((int(one), int(two)))

    def _declare_part(self, name: str, part: slice) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.set_value(self._all.Eval(context)[part])

        self.DeclareVectorOutputPort(
            name,
            part.stop - part.start,
            calc,
            prerequisites_of_calc={self.all_input_ports_ticket(), self.xd_ticket()},
        )

    def _calc(self, context: Context, output: BasicVector) -> None:
        q, step = self._position(context), self._step(context)
        others, low, high, J = None, None, None, None
        before = None
        finite = all_finite(q) and all_finite(step)
        if self._limits is not None:
            command, velocity = self._command(context), self._velocity(context)
            finite = finite and all_finite(command) and all_finite(velocity)
            if finite:
                low, high = self._limits.step_bounds(command, velocity)
        if self._others is not None and self._others.HasValue(context):
            others = self._others.Eval(context)
            before = context.get_discrete_state_vector().value()
        info = ClearanceInfo()
        if finite:
            J = self._task.jacobian(q) if self._task is not None else None
            step, info = self._clearance(
                q, step, J=J, low=low, high=high, others=others, others_before=before
            )
        else:
            step = self._hold
        output.set_value([*step, min(info.distance, FAR), info.blocked, *info.pair])

    def _calc_near(self, context: Context, output: BasicVector) -> None:
        others = None
        if self._others is not None and self._others.HasValue(context):
            others = self._others.Eval(context)
        around = self._clearance.around(self._position(context), others)
        output[0] = around is not None and around.pairs > 0

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        if self._others is not None and self._others.HasValue(context):
            discrete_state.set_value(self._others.Eval(context))
