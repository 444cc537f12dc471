"""One control cycle, told once (Xu & Nechyba 1993, figure 1 and section 2.7).

In tick k the joints are at q, their command is θ, and

    e = task error at q                      what is wrong, m rows [m]
    K = gain(|e|, last errors, last dθ)      Table I, times the calm
    K' = ⅓ K + ⅔ K'                          equation 30
    d = ⅓ K' e + ⅔ d                         equation 31, e first shortened to the error limit
    dθ = law(J(q), d)                        near joint limits with weights; at a dead point a nudge;
                                             what a joint at its bound may not do the others do;
                                             what it leaves free of the null-space motion is added;
                                             on the way to another posture that way instead
    dθ = clearance(q, dθ)                    the nearest one that keeps clear of obstacles; where they are
                                             near it sees to the limits too
    dθ = guard(dθ)                           the last word: finite, not too long, inside the limits of
                                             position, speed and acceleration; nothing is added after it
    θ = θ + dθ                               with limits of jerk the mean of the last θ goes out

⅔ stands for the two smoothings. The fused block and `rollout` run `ControlCycle`; the Diagram's blocks
call its parts one by one.
"""

from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.control.clearance import ClearanceInfo, make_clearance
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.guard import Guard
from fikm_drake.control.joint_limits import JointLimits, StepBox
from fikm_drake.control.make_safe_step import make_safe_step
from fikm_drake.control.native_safe_step import native_safe_step
from fikm_drake.control.null_space import null_space_step
from fikm_drake.control.restart_search import make_restart_search
from fikm_drake.control.restart_state import RestartState
from fikm_drake.control.status import ControllerStatus, controller_status, follows
from fikm_drake.control.steps import amplify, length, low_pass
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.laws import Law, LawLike, checked_law
from fikm_drake.laws.fuzzy_mapping import fit_to_range
from fikm_drake.laws.law import takes_damping

UNTOUCHED = ClearanceInfo()
"""Nothing is near."""


class CycleState(NamedTuple):
    """What a tick hands on to the next; vectors, changed in place by `ControlCycle.advance`."""

    command: Array
    """θ, commanded joint positions (n,) [rad or m]."""
    velocity: Array
    """Last change of the command over the period (n,) [rad/s or m/s]."""
    gain: Array
    """K', the filtered gain (1,) [-]."""
    error: Array
    """d, the filtered error (m,) [m]."""
    supervision: Array
    """The memory of `GainSupervision`."""
    restart: Array
    """The memory of `RestartSearch`; empty without one."""
    others: Array
    """Where obstacles that move were in the last tick (p,); NaN before the first, empty without any."""


class Tick(NamedTuple):
    """What one tick computes."""

    valid: bool
    """Every input is finite; else the joints hold."""
    error: Array
    """e (m,) [m]; zeros if not valid."""
    error_length: float
    """|e| [m]."""
    gain: float
    """K [-]."""
    filtered_gain: float
    """K' [-]."""
    filtered_error: Array
    """d (m,) [m]."""
    joint_step: Array
    """dθ (n,) [rad or m], what the guard lets through."""
    command: Array
    """θ + dθ (n,) [rad or m], the command after the tick."""
    asked: Array
    """What the guard was asked for (n,) [rad or m]."""
    limited: bool
    """A limit of the joints took a part of dθ away, before the guard."""
    cleared: ClearanceInfo
    """What obstacles did to it."""


class ControlCycle:
    """The tick of a fuzzy IK controller as pure functions of a state, a target and the joints.

    Args:
        task: what counts.
        config: see `FuzzyIkConfig`; its frame and task have been used to make `task`.
        law: another law than the config's.
        collision_checker: of a world with the task's arm, such as of `MakeCollisionChecker`; None: obstacles
            are not seen, which costs nothing.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import numpy as np, fikm_drake as fd
        >>> task = fd.PositionTask(fd.PlantArm(fd.MakeDhArmPlant(fd.load_arm("arm7"))))
        >>> cycle = fd.ControlCycle(task, fd.FuzzyIkConfig())
        >>> state, target = cycle.start(np.full(7, 0.3)), np.array([0.5, 0.5, 0.2])
        >>> for _ in range(200):
        ...     cycle.advance(state, target, state.command, cycle.tick(state, target, state.command))
        >>> bool(np.linalg.norm(task.error(target, state.command)) < 1e-6)
        True
    """

    def __init__(
        self,
        task: TaskKinematics,
        config: FuzzyIkConfig,
        law: LawLike | None = None,
        *,
        collision_checker: CollisionChecker | None = None,
    ) -> None:
        config.validate()
        arm = task.arm
        self.task, self.config, self.law = task, config, make_law(task, config, law)
        self.damped = takes_damping(self.law)
        self.supervision = GainSupervision(
            task.size,
            arm.num_joints,
            config.supervisor,
            num_coordinates=task.num_coordinates,
            error_limit=config.error_limit,
            tolerance=config.tolerance,
            damped=self.damped,
        )
        self.safe_step = make_safe_step(
            arm,
            self.law,
            max_joint_step=config.max_joint_step,
            limit_margin=config.limit_margin,
            posture_gain=config.posture_rate * config.period,
            nominal_position=config.nominal_position,
            singularity_nudge=config.singularity_nudge,
            limit_retreat=config.limit_retreat,
            num_rows=task.size,
        )
        self.limits, self.guard = make_limits(config, arm), Guard(config.max_joint_step)
        # The kernel's as in the block `DifferentialIk`, so that both round alike.
        self.native_step = native_safe_step(task, self.law, self.safe_step, self.limits)
        self.clearance = None
        if collision_checker is not None:
            self.clearance = make_clearance(arm, collision_checker, config.clearance, config.period)
        self.restart = None
        if config.restart_search:
            self.restart = make_restart_search(
                task,
                tolerance=config.tolerance,
                speed=config.restart_speed,
                period=config.period,
                limits=self.limits,
                clearance=self.clearance,
            )
        self.jerk_limit = config.smoothing(arm, among_obstacles=collision_checker is not None)
        self.distance = config.following(arm)
        self._rate = 1.0 / config.period  # rounded as in JointIntegrator
        self._no_error, self._hold = np.zeros(task.size), np.zeros(arm.num_joints)

    @property
    def num_others(self) -> int:
        """Positions in the collision checker's plant that are not the arm's, p."""
        return len(self.clearance.default_others) if self.clearance else 0

    def start(self, position: Array) -> CycleState:
        """The state before the first tick, at rest at joint positions (n,)."""
        return CycleState(
            command=np.array(position, dtype=float),
            velocity=np.zeros(len(position)),
            gain=np.array([self.config.supervisor.initial_gain]),
            error=np.zeros(self.task.size),
            supervision=self.supervision.initial_memory(),
            restart=self.restart.initial_memory() if self.restart else np.zeros(0),
            others=np.full(self.num_others, np.nan),
        )

    def tick(
        self,
        state: CycleState,
        target: Any,
        q: Array,
        *,
        others: Array | None = None,
        null_space_motion: Array | None = None,
    ) -> Tick:
        """One tick; nothing is changed.

        Args:
            state: of the last tick.
            target: as the task takes it.
            q: joint positions (n,): the command, or measured [rad or m].
            others: where obstacles are (p,), as of `Clearance`; None: where they are by default.
            null_space_motion: joint velocity that is wished for beside the task (n,) [rad/s or m/s].
        """
        config, supervision = self.config, self.supervision
        error, J = self.task.error_and_jacobian(target, q)
        size = length(error)
        valid = isfinite(size)
        if not valid:
            error, size = self._no_error, 0.0
        gain = supervision.gain(state.supervision, size)
        filtered_gain = low_pass(gain, float(state.gain[0]), config.gain_smoothing)
        amplified = amplify(filtered_gain, error, size, config.error_limit)
        filtered_error = low_pass(amplified, state.error, config.error_smoothing)
        box = StepBox(self.limits, state.command)
        step, limited, cleared = self._hold, False, UNTOUCHED
        around = self.clearance.around(q, others) if self.clearance else None
        if valid:
            damping = supervision.damping(state.supervision) if self.damped else None
            done, alone = None, around is None or around.pairs == 0
            if self.native_step:
                inputs = q, filtered_error, state.command, damping or 0.0
                done = self.native_step(*inputs, resolved=alone)
            step, limited = done or self.safe_step.inside(
                q, J, filtered_error, box, damping, resolved=alone
            )
            if null_space_motion is not None:
                step = step + null_space_step(J, config.period * null_space_motion)
            if self.restart:
                step = self.restart.step(state.restart, q, step)
        elif around:  # what comes is evaded while the target is lost
            J = self.task.jacobian(q)
        if self.clearance:
            step, cleared = self.clearance.keep_inside(
                around, step, J=J, box=box, velocity=state.velocity, others_before=state.others
            )
        if self.guard.surely_passes(step, box):
            taken, command = step, state.command + step
        else:
            taken = self.guard(step, *box.bounds(state.velocity))
            command = self.limits.add(state.command, taken)
        so_far = valid, error, size, gain, filtered_gain, filtered_error
        return Tick(*so_far, taken, command, step, limited, cleared)

    def advance(
        self, state: CycleState, target: Any, q: Array, tick: Tick, others: Array | None = None
    ) -> None:
        """Write a tick into the state; the arguments are those of `tick`."""
        if others is not None:
            state.others[:] = others
        if self.restart and tick.valid:
            self.restart.remember(state.restart, target, q, tick.error_length, others)
        elif self.restart:
            state.restart[:] = self.restart.initial_memory()
        watched = self.supervision.remember_turns(
            state.supervision, tick.error, tick.joint_step, tick.error_length
        )
        if watched:
            self.supervision.remember_motion(
                state.supervision,
                watched,
                tick.error,
                self.task.target_coordinates(target),
                q - state.command if self.config.measured_position else None,
            )
        velocity, command = state.velocity, state.command
        np.subtract(tick.command, command, velocity)
        velocity *= self._rate
        command[:] = tick.command
        state.gain[0], state.error[:] = tick.filtered_gain, tick.filtered_error

    def status(
        self,
        state: CycleState,
        tick: Tick,
        measured: Array | None = None,
        *,
        settled: bool = True,
    ) -> ControllerStatus:
        """The status of a tick.

        Args:
            state: before the tick.
            tick: the tick.
            measured: the robot's joints (n,) where they are known [rad or m].
            settled: what goes out is at the target too; see `controller_status`.
        """
        return controller_status(
            valid=tick.valid,
            error=tick.error_length,
            tolerance=self.config.tolerance,
            limited=tick.limited or not np.array_equal(tick.joint_step, tick.asked),
            oscillating=self.supervision.oscillating(state.supervision),
            calmed=self.supervision.calmed(state.supervision),
            restart_search=self.restart.state(state.restart) if self.restart else RestartState.NONE,
            blocked=tick.cleared.blocked,
            following=measured is None or follows(state.command, measured, self.distance),
            settled=settled,
        )


def make_law(task: TaskKinematics, config: FuzzyIkConfig, law: LawLike | None = None) -> Law:
    """The law of a config, or `law`, checked; one of rules is fitted to the task's Jacobian."""
    chosen = config.law if law is None else law
    return checked_law(fit_to_range(chosen, task), task.size, task.arm.num_joints)


def make_limits(config: FuzzyIkConfig, arm: PlantArm) -> JointLimits:
    """The limits of a cycle's steps: the arm's and the config's."""
    return JointLimits(
        *(arm.lower, arm.upper),
        period=config.period,
        velocity_limits=config.speeds(arm),
        acceleration_limits=config.accelerations(arm),
    )
