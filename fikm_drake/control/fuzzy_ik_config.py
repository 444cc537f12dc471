"""All that can be set of a fuzzy IK controller."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
import dataclasses
from dataclasses import dataclass, field
from math import inf

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import (
    check_below_one,
    check_flag,
    check_not_negative,
    check_number,
    check_positive,
    check_positive_finite,
)
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.control.jerk_limit import JerkLimit, smooth_accelerations
from fikm_drake.control.status import following_distance
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.task import CHARACTERISTIC_LENGTH
from fikm_drake.kinematics.tasks import check_task_name
from fikm_drake.laws import LAWS, LawConfig
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

DEFAULT_VELOCITY_LIMIT = 10.0
"""Above what industrial arms do (2 to 8 rad/s), and what the paper's runs ask for [rad/s or m/s]."""


@dataclass
class FuzzyIkConfig:
    """Configuration of `AddFuzzyIkController`; Drake's typed YAML loads and dumps it.

    Attributes:
        law: maps Jacobian and error to a joint step; in YAML by a tag, `law: !DampedLeastSquares
            {damping: 0.05}`, without a tag `FuzzyMapping`. More `iterations` are sharper and dearer;
            for poses take `FuzzyMapping.iterated()`, in YAML `{iterations: 6, damping: 0.02,
            error_damping: 3, row_floor: 0.05}`; for targets far away all of `for_reaching`: there
            `row_floor: 1`, and beside the law `limit_retreat: 0.06`, for positions 0.15.
        frame: name of the tool's frame in the plant; `instance::name` where several arms have one.
        task: what counts: `position`, axes such as `xy`, `orientation`, `pose`, `pointing`.
        characteristic_length: for tasks with orientation a turn of 1 rad counts as this much [m];
            more makes turns matter more, beside positions.
        control_rate: cycles a second [Hz]; the paper's 50. More follows closer and costs more.
        fused: one LeafSystem in place of the Diagram: the same results and ports at less cost.
        measured_position: take the joints from the port `estimated_position` in place of the command
            itself. Whatever the robot is late by is then in the loop: one cycle's delay is stable for
            gains below 1 only, so lower those of `supervisor` for a robot that is late.
        error_limit: a longer task error counts as this long [m], which bounds the first step to a far
            target; infinite (`.inf` in YAML): no limit, as in the paper.
        max_joint_step: a longer joint step of a cycle is shortened to this length [rad or m]. The
            paper's law stays far below; sharper laws near a singular posture need it.
        singularity_nudge: joint motion aside at a dead point, such as a stretched arm whose target
            lies straight inward, over the amplified error [rad/m]; 0: the arm stays there, as in the
            paper.
        limit_margin: distance from a joint limit within which a joint that moves toward it counts
            less [rad or m]; 0: the command is only cut off at the limit.
        limit_retreat: how strongly joints near their limits draw back to the middle of them while the tool is
            far from its target [-]; see `control.limit_retreat`. More leaves fewer targets unreached in
            corners of the limits, too much stops before targets near them. 0: they do not; see
            `for_reaching`.
        posture_rate: fraction of the way to its nominal posture that a redundant arm goes in a
            second, as far as the task leaves it free [1/s]; 0: it does not.
        nominal_position: the nominal posture (n) [rad or m]; empty: the middle of the joint limits,
            the plant's default for joints without.
        velocity_limits: largest joint speeds (n) where the plant's own limits are not lower, or one
            for all [rad/s or m/s]; empty: the plant's own.
        default_velocity_limit: speed of a joint that neither the plant nor `velocity_limits` bounds
            [rad/s or m/s]; infinite (`.inf` in YAML): none, as in the paper.
        acceleration_limits: largest joint accelerations, likewise [rad/s² or m/s²].
        jerk_limits: largest joint jerks (n), or one for all [rad/s³ or m/s³]; empty: none. The command
            that goes out is then the mean of the loop's last ones, see `control.jerk_limit`: less makes it
            smoother and later. Not together with a collision checker.
        restart_search: search for another posture where the law comes to rest before the target: out
            of dead points and local minima at joint limits; see `control.restart_search`. The arm may
            then move far, and not along the task.
        restart_speed: of the fastest joint on the way to that posture [rad/s or m/s].
        following_time: status NOT_FOLLOWING where a measured joint is further from its command than
            it moves in this time at its limit of speed [s]; more bears a slower robot.
        clearance: distances from obstacles, and the rules of the approach; they count where the controller
            is given a collision checker.
        null_space_motion: whether there is the input port `null_space_motion`, for what the joints
            should do beside the task; see `NullSpaceMotion`.
        tolerance: a task error up to this counts as converged [m].
        gain_smoothing: weight of the last gain in equation 30 [-]; 0: no filter, quicker.
        error_smoothing: weight of the last error in equation 31 [-]; 0: no filter, quicker.
        supervisor: the constants of section 2.7 and of the calm.
    """

    law: LawConfig = field(default_factory=FuzzyMapping)
    frame: str = "tool"
    task: str = "position"
    characteristic_length: float = CHARACTERISTIC_LENGTH
    control_rate: float = 50.0
    fused: bool = False
    measured_position: bool = False
    error_limit: float = 0.2
    max_joint_step: float = 0.5
    singularity_nudge: float = 0.01
    limit_margin: float = 0.1
    limit_retreat: float = 0.0
    posture_rate: float = 0.0
    nominal_position: list[float] = field(default_factory=list)
    velocity_limits: list[float] = field(default_factory=list)
    default_velocity_limit: float = DEFAULT_VELOCITY_LIMIT
    acceleration_limits: list[float] = field(default_factory=list)
    jerk_limits: list[float] = field(default_factory=list)
    restart_search: bool = False
    restart_speed: float = 1.5
    following_time: float = 0.25
    clearance: ClearanceConfig = field(default_factory=ClearanceConfig)
    null_space_motion: bool = False
    tolerance: float = 1e-3
    gain_smoothing: float = 2.0 / 3.0
    error_smoothing: float = 2.0 / 3.0
    supervisor: GainSupervisorConfig = field(default_factory=GainSupervisorConfig)

    def as_in_paper(self) -> "FuzzyIkConfig":
        """This config as Xu & Nechyba's controller: without what calms and bounds ours.

        Example:
            >>> import fikm_drake as fd
            >>> fd.FuzzyIkConfig(control_rate=100.0).as_in_paper().error_limit
            inf
        """
        return dataclasses.replace(
            self,
            error_limit=inf,
            max_joint_step=inf,
            default_velocity_limit=inf,
            jerk_limits=[],
            limit_margin=0.0,
            limit_retreat=0.0,
            singularity_nudge=0.0,
            supervisor=dataclasses.replace(self.supervisor, calming=1.0),
        )

    def resolved_rate(self) -> "FuzzyIkConfig":
        """This config as a plain resolved-rate loop: gain 1, no filters; the law's step as it is.

        For laws that take the whole error at once, such as `FuzzyRateControl`, `PseudoInverse` or
        `DampedLeastSquares`: the gain and the filters of Xu & Nechyba 1993 would slow them down.

        Example:
            >>> import fikm_drake as fd
            >>> fd.FuzzyIkConfig(law=fd.PseudoInverse()).resolved_rate().supervisor.gains
            [1.0, 1.0, 1.0]
        """
        return dataclasses.replace(
            self,
            gain_smoothing=0.0,
            error_smoothing=0.0,
            singularity_nudge=0.0,
            supervisor=dataclasses.replace(
                self.supervisor, gains=[1.0] * 3, oscillating_gains=[1.0] * 3, calming=1.0
            ),
        )

    def for_tracking(self) -> "FuzzyIkConfig":
        """This config for targets that move fast and smoothly: hardly any lag.

        The law is `FuzzyMapping.iterated()`, in which no direction is slow; the gain is 1, there are no
        filters. Calm, limits and the nudge stay. The default lags behind, but passes on less of a target's
        noise: `fikm-drake reproduce fikm --only default` shows both.

        Example:
            >>> import fikm_drake as fd
            >>> fd.FuzzyIkConfig(task="pose").for_tracking().law.iterations
            6
        """
        return dataclasses.replace(
            self,
            law=FuzzyMapping.iterated(),
            gain_smoothing=0.0,
            error_smoothing=0.0,
            supervisor=dataclasses.replace(self.supervisor, gains=[1.0] * 3),
        )

    def for_reaching(self) -> "FuzzyIkConfig":
        """This config for targets that may be anywhere: of those in reach it comes to rest before the fewest.

        As `for_tracking`, with rows that count alike, so that every step brings the tool nearer in one and
        the same measure, and with joints that draw back from their limits on the way. It stays local: it
        looks at no other posture, as `restart_search` does, and sets out at once. How many targets of 36
        public arms that gains, `fikm-drake benchmark arms` shows.

        Example:
            >>> import fikm_drake as fd
            >>> fd.FuzzyIkConfig(task="pose").for_reaching().limit_retreat
            0.06
        """
        tracking = self.for_tracking()
        law = dataclasses.replace(FuzzyMapping.iterated(), row_floor=1.0)
        # A task of all six rows has fewer joints to spare: a stronger pull would hold up more than it frees.
        strength = 0.06 if self.task in ("pose", "pointing") else 0.15
        return dataclasses.replace(tracking, law=law, limit_retreat=strength)

    @property
    def period(self) -> float:
        """Period of the control cycle [s]."""
        return 1.0 / self.control_rate

    def speeds(self, arm: PlantArm) -> Array:
        """Limits of speed (n,), the arm's too, by default where there is none [rad/s or m/s]."""
        speeds = _least("velocity_limits", self.velocity_limits, arm.velocity_limits)
        return np.where(np.isfinite(speeds), speeds, self.default_velocity_limit)

    def accelerations(self, arm: PlantArm) -> Array:
        """Limits of acceleration (n,), the arm's too, and what jerk leaves of them [rad/s² or m/s²]."""
        own = _least("acceleration_limits", self.acceleration_limits, arm.acceleration_limits)
        return smooth_accelerations(self.jerks(arm), self.speeds(arm), own)

    def jerks(self, arm: PlantArm) -> Array:
        """Limits of jerk (n,), inf for none [rad/s³ or m/s³]."""
        return _least("jerk_limits", self.jerk_limits, np.full(arm.num_joints, inf))

    def smoothing(self, arm: PlantArm, *, among_obstacles: bool = False) -> JerkLimit | None:
        """What keeps the limits of jerk; None where there are none.

        Raises:
            ValueError: see `JerkLimit`; or there are obstacles too: what goes out is between the positions
                that were looked at.
        """
        jerks = self.jerks(arm)
        if not np.isfinite(jerks).any():
            return None
        if among_obstacles:
            raise ValueError(
                "jerk_limits can't be kept together with a collision checker, since the smoothed way is not "
                f"looked at: leave one of them out, got jerk_limits {self.jerk_limits!r}"
            )
        return JerkLimit(
            jerks,
            period=self.period,
            velocity_limits=self.speeds(arm),
            acceleration_limits=self.accelerations(arm),
            num_joints=arm.num_joints,
        )

    def following(self, arm: PlantArm) -> Array:
        """How far a robot that follows may be from its command (n,) [rad or m]."""
        smoothing = self.smoothing(arm)
        late = smoothing.late * self.period if smoothing else 0.0
        return following_distance(self.speeds(arm), self.following_time + late)

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if type(self.law) not in LAWS.values() and not (
            callable(self.law) or hasattr(self.law, "step")
        ):
            raise ValueError(f"law must be one of {tuple(LAWS)} or callable, got {self.law!r}")
        if type(self.law) in LAWS.values():
            dataclasses.replace(self.law)  # checks what YAML wrote into it
        if not isinstance(self.frame, str):
            raise ValueError(f"frame must be the name of a frame, got {self.frame!r}")
        check_task_name(self.task)
        for name in ("fused", "measured_position", "restart_search", "null_space_motion"):
            check_flag(name, getattr(self, name))
        check_positive_finite("characteristic_length", self.characteristic_length, "m")
        check_positive_finite("control_rate", self.control_rate, "Hz")
        for name in ("error_limit", "tolerance", "max_joint_step", "default_velocity_limit"):
            check_positive(name, getattr(self, name))
        for name in ("restart_speed", "following_time"):
            check_positive(name, getattr(self, name))
        for name in ("singularity_nudge", "limit_margin", "limit_retreat"):
            check_not_negative(name, getattr(self, name))
        check_number(
            "posture_rate",
            self.posture_rate,
            f"from 0 to control_rate = {self.control_rate:g} [1/s]",
            lambda rate: 0.0 <= rate <= self.control_rate,
        )
        for name in ("gain_smoothing", "error_smoothing"):
            check_below_one(name, getattr(self, name))
        if not isinstance(self.clearance, ClearanceConfig):
            raise ValueError(f"clearance must be a ClearanceConfig, got {self.clearance!r}")
        self.clearance.validate()
        if not isinstance(self.supervisor, GainSupervisorConfig):
            raise ValueError(f"supervisor must be a GainSupervisorConfig, got {self.supervisor!r}")
        self.supervisor.validate()


def _least(name: str, values: list[float], own: Array) -> Array:
    """The lower of an arm's limits and those of a config; ValueError unless it has 0, 1 or n."""
    limits = np.atleast_1d(np.asarray(values, dtype=float))
    if limits.size not in (0, 1, len(own)) or limits.ndim > 1 or not (limits > 0.0).all():
        raise ValueError(
            f"{name} must be empty or positive, one number or {len(own)}, got {values!r}"
        )
    return np.minimum(own, limits) if limits.size else own
