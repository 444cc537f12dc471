"""The differential-IK block: a task error in, a joint step out."""

from collections.abc import Sequence
from math import inf

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.arrays import Array, all_finite
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.control.make_safe_step import make_safe_step
from fikm_drake.control.native_safe_step import native_safe_step
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws import LawLike, checked_law
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.law import takes_damping
from fikm_drake.systems.valid_port import declare_valid_port

MOST_DAMPING = 1e154
"""Beyond this a number counts as not finite, since its square is not."""


class DifferentialIk(LeafSystem):
    """Differential inverse kinematics by any law, by default the fuzzy mapping.

    .. pydrake_system::

        name: DifferentialIk
        input_ports:
        - task_error
        - position
        - guard
        - damping
        - command
        - obstacles_near
        output_ports:
        - joint_step
        - valid
        - limited

    - **task_error** (m) [m]: as of `TaskError`, amplified and filtered as the user likes.
    - **position** (n) [rad or m]: the joints.
    - **guard**, only if `guarded`: the target, as of `TaskError`, which must be finite too; else the
      filters before `task_error` would let the arm coast after the target is lost.
    - **damping** (1) [-], only if `damped`: as of `GainSupervisor`, for a law that takes it.
    - **command** (n) [rad or m], only with `limits`: of `JointIntegrator`, which adds the step to it.
    - **obstacles_near** (1), only if `yields`: of `ClearanceFilter`; while it is 1 limits are left to that.
    - **joint_step** (n) [rad or m]: dθ of this cycle; zeros while an input is not finite.
    - **valid** (1): 1 while every input is finite, else 0.
    - **limited** (1), only with `limits`: 1 while they take away a part of the step, else 0.

    Args:
        plant: a finalized plant; it is not copied.
        law: the mapping (J, dr) to a joint step, see `Law`; by default the paper's.
        frame: name of the tool's frame.
        task: a name, see `FuzzyIkConfig.task`, or an object, see `TaskKinematics`.
        guarded: whether there is the port `guard`.
        damped: whether there is the port `damping`; the law must take it, see `Law`.
        max_joint_step: a longer joint step is shortened to this length [rad or m].
        limit_margin: distance from a joint limit within which a joint that moves toward it counts less
            [rad or m], see `control.limit_weights`; 0: limits are not seen.
        posture_gain: fraction of the way to the nominal posture that a cycle takes, as far as the
            task leaves the joints free [-].
        nominal_position: that posture (n) [rad or m]; empty: the middle of the joint limits.
        singularity_nudge: joint motion aside at a dead point, over the length of `task_error` [rad/m], see
            `control.safe_step`; 0: the arm stays there.
        limit_retreat: how strongly joints near their limits draw back from them while the error is long
            [-], see `control.limit_retreat`; only with `limits`. 0: not.
        limits: of the joints; what one at its bound may not do the others do, see
            `control.saturation`. None: they are not seen.
        yields: whether there is the port `obstacles_near`.

    Raises:
        ValueError: naming the bad value; see `PlantArm` and `TaskKinematics` too.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("planar4"))
        >>> fd.DifferentialIk(plant, law=fd.DampedLeastSquares(), task="xy").num_input_ports()
        2
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        law: LawLike | None = None,
        frame: str = "tool",
        task: str | TaskKinematics = "position",
        guarded: bool = False,
        damped: bool = False,
        max_joint_step: float = inf,
        limit_margin: float = 0.0,
        posture_gain: float = 0.0,
        nominal_position: Sequence[float] = (),
        singularity_nudge: float = 0.0,
        limit_retreat: float = 0.0,
        limits: JointLimits | None = None,
        yields: bool = False,
    ) -> None:
        super().__init__()
        self._task = as_task(plant, frame, task)
        arm, m = self._task.arm, self._task.size
        law = checked_law(law or FuzzyMapping(), m, arm.num_joints)
        if damped and not takes_damping(law):
            raise ValueError(f"damped needs a law that takes damping, {law!r} does not")
        self._safe_step = make_safe_step(
            arm,
            law,
            max_joint_step=max_joint_step,
            limit_margin=limit_margin,
            posture_gain=posture_gain,
            nominal_position=nominal_position,
            singularity_nudge=singularity_nudge,
            limit_retreat=limit_retreat,
            num_rows=m,
        )
        self._native = None
        if limits:
            self._native = native_safe_step(self._task, law, self._safe_step, limits)
        n = arm.num_joints
        self._hold = np.zeros(n)
        self._error = self.DeclareVectorInputPort("task_error", m).Eval
        self._position = self.DeclareVectorInputPort("position", n).Eval
        self._guard = None
        if guarded:
            self._guard = self._task.declare_target(self, "guard").Eval
        self._damping = self.DeclareVectorInputPort("damping", 1).Eval if damped else None
        self._limits = limits
        if limits:
            self._command = self.DeclareVectorInputPort("command", n).Eval
        self._near = self.DeclareVectorInputPort("obstacles_near", 1).Eval if yields else None
        self.DeclareVectorOutputPort(
            "joint_step",
            n,
            self._calc_step,
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )
        declare_valid_port(self)
        if limits:
            self.DeclareVectorOutputPort(
                "limited",
                1,
                self._calc_limited,
                prerequisites_of_calc={self.all_input_ports_ticket()},
            )

    def _calc_step(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._limited_step(context)[0])

    def _calc_limited(self, context: Context, output: BasicVector) -> None:
        output[0] = self._limited_step(context)[1]

    def _limited_step(self, context: Context) -> tuple[Array, bool]:
        error = self._error(context)
        damping = float(self._damping(context)[0]) if self._damping else None
        lost = self._guard is not None and not self._task.is_finite(self._guard(context))
        lost = lost or (damping is not None and not abs(damping) < MOST_DAMPING)
        if lost:
            return self._hold, False
        q = self._position(context)
        alone = self._near is None or self._near(context)[0] == 0.0
        if self._native:
            command = self._command(context)
            done = self._native(q, error, command, damping or 0.0, resolved=alone)
            if done:
                return done
        if not (all_finite(error) and all_finite(q)):
            return self._hold, False
        J = self._task.jacobian(q)
        if self._limits is None:
            return self._safe_step(q, J, error, damping), False
        box = StepBox(self._limits, self._command(context))
        return self._safe_step.inside(q, J, error, box, damping, resolved=alone)
