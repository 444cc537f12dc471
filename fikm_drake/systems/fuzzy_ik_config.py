"""All that can be set of a fuzzy IK controller."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np

from fikm_drake.checks import (
    check_below_one,
    check_not_negative,
    check_number,
    check_positive,
    check_positive_finite,
)
from fikm_drake.control.gain_supervisor_config import GainSupervisorConfig
from fikm_drake.kinematics.task import Task
from fikm_drake.laws.fuzzy_mapping import METHODS
from fikm_drake.systems.tool_kinematics import ToolKinematics


@dataclass
class FuzzyIkConfig:
    """Configuration of `AddFuzzyIkController`; Drake's typed YAML loads and dumps it."""

    method: str = "indirect"
    """Form of the mapping: `indirect` (equations 32-34) or `direct` (rule bases, equation 29)."""
    frame: str = "tool"
    """Name of the tool's frame in the plant; `instance::name` where several arms have one."""
    task: str = "position"
    """The coordinates that count: `position`, axes such as `xy`, `orientation` or `pose`."""
    characteristic_length: float = 0.3
    """For tasks with orientation: a turn of 1 rad counts as this much [m]."""
    control_rate: float = 50.0
    """Cycles a second [Hz]; the paper's 50."""
    fused: bool = False
    """One LeafSystem in place of the Diagram: the same results and ports at less cost."""
    measured_position: bool = False
    """Take the joints from the port `estimated_position` in place of the command itself. Whatever
    the robot is late by is then in the loop: one cycle's delay is stable for gains below 1 only, so
    lower those of `supervisor` for a robot that is late."""
    error_limit: float = 0.2
    """A longer task error counts as this long [m], which bounds the first step to a far target;
    infinite (`.inf` in YAML): no limit, as in the paper."""
    max_joint_step: float = 0.5
    """A longer joint step of a cycle is shortened to this length [rad or m]. The paper's law stays
    far below; `iterations` near a singular posture need it."""
    singularity_nudge: float = 0.01
    """Joint motion aside at a dead point, such as a stretched arm whose target lies straight inward, over
    the amplified error [rad/m]; 0: the arm stays there, as in the paper."""
    limit_margin: float = 0.1
    """Distance from a joint limit within which a joint that moves toward it counts less [rad or m];
    0: the command is only cut off at the limit."""
    posture_gain: float = 0.0
    """Rate at which a redundant arm goes to its nominal posture, as far as the task leaves it free
    [1/s]; 0: it does not."""
    nominal_position: list[float] = field(default_factory=list)
    """The nominal posture (n) [rad or m]; empty: the middle of the joint limits, the plant's default
    for joints without."""
    velocity_limits: float = inf
    """Largest joint speed, if the plant's own limits are not lower [rad/s or m/s]."""
    acceleration_limits: float = inf
    """Largest joint acceleration, if the plant's own limits are not lower [rad/s² or m/s²]."""
    restart_search: bool = False
    """Search for another posture where the law comes to rest before the target: out of dead points and
    local minima at joint limits; see `control.restart_search`. The arm may then move
    far, and not along the task."""
    restart_speed: float = 1.5
    """Of the fastest joint on the way to that posture [rad/s or m/s]."""
    tolerance: float = 1e-3
    """A task error up to this counts as converged [m]."""
    gain_smoothing: float = 2.0 / 3.0
    """Weight of the last gain in equation 30 [-]; 0: no filter."""
    error_smoothing: float = 2.0 / 3.0
    """Weight of the last error in equation 31 [-]; 0: no filter."""
    iterations: int = 1
    """Of conjugate gradients on the scaled Jacobian a cycle; 1: the paper's law, the number of task
    coordinates: a pseudo-inverse."""
    damping: float = 0.0
    """Of the scaled Jacobian [-], with `iterations` of 2 or more."""
    row_floor: float = 0.0
    """Floor of the row sums as a fraction of the largest [-]; 0 as in the paper."""
    column_floor: float = 0.0
    """Floor of the column sums as a fraction of the largest [-]; 0 as in the paper."""
    zero_threshold: float = 1e-9
    """Row and column sums up to this fraction of the largest count as zero [-]."""
    supervisor: GainSupervisorConfig = field(default_factory=GainSupervisorConfig)
    """The constants of section 2.7."""

    @classmethod
    def as_in_paper(cls, **changes: Any) -> "FuzzyIkConfig":
        """Xu & Nechyba's controller, without what calms and bounds ours; `changes` by field name."""
        changes.setdefault("supervisor", GainSupervisorConfig(calming=1.0))
        return cls(
            **{
                "error_limit": inf,
                "max_joint_step": inf,
                "limit_margin": 0.0,
                "singularity_nudge": 0.0,
            }
            | changes
        )

    @classmethod
    def resolved_rate(cls, **fields: Any) -> "FuzzyIkConfig":
        """The config of a plain resolved-rate loop: gain 1, no filters; the law's step as it is.

        For laws that take the whole error at once, such as `FuzzyRateControl`, `PseudoInverse` or
        `DampedLeastSquares`: the gain and the filters of Xu & Nechyba 1993 would slow them down.

        Args:
            fields: any other fields, such as `control_rate=100.0`.
        """
        plain: dict[str, Any] = {
            "gain_smoothing": 0.0,
            "error_smoothing": 0.0,
            "singularity_nudge": 0.0,
            "supervisor": GainSupervisorConfig(
                gains=[1.0] * 3, oscillating_gains=[1.0] * 3, calming=1.0
            ),
        }
        return cls(**(plain | fields))

    @property
    def period(self) -> float:
        """Of the control cycle [s]."""
        return 1.0 / self.control_rate

    def make_task(self) -> Task:
        """The task.

        Raises:
            ValueError: naming the bad value and the valid ones.
        """
        return Task(self.task, self.characteristic_length)

    def step_options(self) -> dict[str, Any]:
        """Options of `DifferentialIk` by name."""
        return {
            "max_joint_step": self.max_joint_step,
            "limit_margin": self.limit_margin,
            "posture_gain": self.posture_gain * self.period,
            "nominal_position": self.nominal_position,
            "singularity_nudge": self.singularity_nudge,
        }

    def rates(self, kinematics: ToolKinematics) -> dict[str, Any]:
        """Limits of speed and acceleration, the plant's too, as options of `JointIntegrator`."""
        return {
            "velocity_limits": np.minimum(kinematics.velocity_limits, self.velocity_limits),
            "acceleration_limits": np.minimum(
                kinematics.acceleration_limits, self.acceleration_limits
            ),
        }

    def restart_options(self) -> dict[str, float]:
        """Options of `RestartPlanner` by name."""
        return {
            "period": self.period,
            "tolerance": self.tolerance,
            "speed": self.restart_speed,
        }

    def validate(self) -> None:
        """Raise ValueError, naming the bad value and the valid ones."""
        if self.method not in METHODS:
            raise ValueError(f"method must be one of {METHODS}, got {self.method!r}")
        self.make_task()
        check_positive_finite("control_rate", self.control_rate, "Hz")
        for name in ("error_limit", "tolerance", "max_joint_step"):
            check_positive(name, getattr(self, name))
        for name in ("velocity_limits", "acceleration_limits", "restart_speed"):
            check_positive(name, getattr(self, name))
        for name in ("singularity_nudge", "limit_margin"):
            check_not_negative(name, getattr(self, name))
        check_number(
            "posture_gain",
            self.posture_gain,
            f"from 0 to control_rate = {self.control_rate:g} [1/s]",
            lambda gain: 0.0 <= gain <= self.control_rate,
        )
        for name in ("gain_smoothing", "error_smoothing"):
            check_below_one(name, getattr(self, name))
        self.supervisor.validate()
