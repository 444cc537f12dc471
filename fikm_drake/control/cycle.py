"""One control cycle, told once (Xu & Nechyba 1993, figure 1 and section 2.7).

In tick k the joints are at q, their command is θ, and

    e = task error at q                      what is wrong, m rows [m]
    K = gain(|e|, last errors, last dθ)      Table I, times the calm
    K' = ⅓ K + ⅔ K'                          equation 30
    d = ⅓ K' e + ⅔ d                         equation 31, e first shortened to the error limit
    dθ = law(J(q), d)                        near joint limits with weights; at a dead point a nudge;
                                             on the way to another posture that way instead
    θ = θ + dθ                               as far as the limits of position, speed, acceleration allow

⅔ stands for the two smoothings. The fused block and `rollout` run `ControlCycle`; the Diagram's blocks
call its parts one by one.
"""

from collections.abc import Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.control.gain_supervision import GainSupervision
from fikm_drake.control.joint_limits import JointLimits
from fikm_drake.control.restart_search import RestartState, make_restart_search
from fikm_drake.control.safe_step import make_safe_step
from fikm_drake.control.status import (
    ControllerStatus,
    controller_status,
    following_distance,
    follows,
)
from fikm_drake.control.steps import amplify, length, low_pass
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.laws import Law, LawLike, checked_law
from fikm_drake.laws.fuzzy_mapping import fit_to_range
from fikm_drake.laws.law import takes_damping


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
    """dθ (n,) [rad or m], before the joint limits."""


class ControlCycle:
    """The tick of a fuzzy IK controller as pure functions of a state, a target and the joints.

    Args:
        task: what counts.
        config: see `FuzzyIkConfig`; its frame and task have been used to make `task`.
        law: another law than the config's.

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
        self, task: TaskKinematics, config: FuzzyIkConfig, law: LawLike | None = None
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
        )
        self.restart = None
        if config.restart_search:
            self.restart = make_restart_search(
                task, tolerance=config.tolerance, pace=config.restart_speed * config.period
            )
        self.limits = JointLimits(
            arm.lower,
            arm.upper,
            period=config.period,
            velocity_limits=config.speeds(arm),
            acceleration_limits=config.accelerations(arm),
        )
        self.distance = following_distance(config.speeds(arm), config.following_time)
        self._no_error, self._hold = np.zeros(task.size), np.zeros(arm.num_joints)

    def start(self, position: Array) -> CycleState:
        """The state before the first tick, at rest at joint positions (n,)."""
        return CycleState(
            command=np.array(position, dtype=float),
            velocity=np.zeros(len(position)),
            gain=np.array([self.config.supervisor.initial_gain]),
            error=np.zeros(self.task.size),
            supervision=self.supervision.initial_memory(),
            restart=self.restart.initial_memory() if self.restart else np.zeros(0),
        )

    def tick(self, state: CycleState, target: Any, q: Array) -> Tick:
        """One tick; nothing is changed.

        Args:
            state: of the last tick.
            target: as the task takes it.
            q: joint positions (n,): the command, or measured [rad or m].
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
        step = self._hold
        if valid:
            damping = supervision.damping(state.supervision) if self.damped else None
            step = self.safe_step(q, J, filtered_error, damping)
            if self.restart:
                step = self.restart.step(state.restart, q, step)
        return Tick(valid, error, size, gain, filtered_gain, filtered_error, step)

    def advance(self, state: CycleState, target: Any, q: Array, tick: Tick) -> None:
        """Write a tick into the state."""
        if self.restart and tick.valid:
            self.restart.remember(state.restart, target, q, tick.error_length)
        elif self.restart:
            state.restart[:] = self.restart.initial_memory()
        after = self.limits.integrate(state.command, tick.joint_step, state.velocity)
        motion = after - state.command
        state.velocity[:] = motion * self.config.control_rate
        state.command[:] = after
        state.gain[0], state.error[:] = tick.filtered_gain, tick.filtered_error
        coordinates = self.task.target_coordinates(target)
        self.supervision.remember(state.supervision, tick.error, motion, coordinates)

    def status(
        self, state: CycleState, tick: Tick, measured: Array | None = None
    ) -> ControllerStatus:
        """The status of a tick.

        Args:
            state: before the tick.
            tick: the tick.
            measured: the robot's joints (n,) where they are known [rad or m].
        """
        return controller_status(
            valid=tick.valid,
            error=tick.error_length,
            tolerance=self.config.tolerance,
            limited=self.limits.limits(state.command, tick.joint_step, state.velocity),
            oscillating=self.supervision.oscillating(state.supervision),
            calmed=self.supervision.calmed(state.supervision),
            restart_search=self.restart.state(state.restart) if self.restart else RestartState.NONE,
            following=measured is None or follows(state.command, measured, self.distance),
        )


class Rollout(NamedTuple):
    """N cycles of a controller whose robot does what it is told."""

    q: Array
    """Commands after each cycle (N,n) [rad or m]."""
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
    state = cycle.start(start)
    ticks, commands = [], []
    for target in targets:
        q = state.command.copy()
        tick = cycle.tick(state, target, q)
        cycle.advance(state, target, q, tick)
        ticks.append(tick)
        commands.append(state.command.copy())
    return Rollout(
        np.array(commands),
        np.array([tick.joint_step for tick in ticks]),
        np.array([tick.error for tick in ticks]),
        np.array([tick.gain for tick in ticks]),
    )


def make_law(task: TaskKinematics, config: FuzzyIkConfig, law: LawLike | None = None) -> Law:
    """The law of a config, or `law`, checked; one of rules is fitted to the task's Jacobian."""
    chosen = config.law if law is None else law
    return checked_law(fit_to_range(chosen, task), task.size, task.arm.num_joints)
