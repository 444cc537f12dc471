"""Bounds of the redundant joint, learned by two ANFIS."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from pathlib import Path

from numpy.typing import ArrayLike
from pydrake.common.yaml import yaml_dump_typed

from fikm_drake.arrays import Array
from fikm_drake.checks import check_joint
from fikm_drake.files import write_whole
from fikm_drake.fuzzy.anfis.anfis import Anfis
from fikm_drake.fuzzy.anfis.anfis_data import AnfisData
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhTable
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.task import Task
from fikm_drake.resources import find_model, load_yaml, model_names
from fikm_drake.solvers.redundancy.bounds_inputs import BoundsInputs
from fikm_drake.solvers.redundancy.tool_targets import checked_points


@dataclass
class BoundsData:
    """Learned bounds, as YAML."""

    arm: DhTable = field(default_factory=DhTable)
    """The arm that they are of."""
    task: str = "xy"
    """What the points fix: `xy` or `pose`."""
    joint: int = 0
    """Whose bounds they are, from 0."""
    inputs: str = "polar"
    """`xy` or `polar`."""
    lower: AnfisData = field(default_factory=AnfisData)
    """Learned lower bound of the joint [rad]."""
    upper: AnfisData = field(default_factory=AnfisData)
    """Learned upper bound of the joint [rad]."""


FOLDER = "bounds"
"""Where in `models/` the bounds are that come with the library."""


class LearnedBounds:
    """Bounds of a joint of a planar arm as functions of the point or pose, learned.

    Args:
        arm: the arm that they are of, with three revolute joints for the task `xy`, four for `pose`.
        inputs: what `lower` and `upper` take, `xy` or `polar`; see `BoundsInputs`.
        lower: the lower bound [rad].
        upper: the upper bound [rad].
        task: what the points fix: `xy` or `pose`.
        joint: whose bounds they are, from 0.

    Raises:
        ValueError: naming the bad value and the valid ones.
    """

    def __init__(
        self,
        arm: DhArm,
        inputs: str,
        lower: Anfis,
        upper: Anfis,
        *,
        task: str = "xy",
        joint: int = 0,
    ) -> None:
        self._inputs_of = BoundsInputs(arm, task, inputs)
        count = len(self._inputs_of.names)
        for name, anfis in (("lower", lower), ("upper", upper)):
            if len(anfis.memberships) != count:
                raise ValueError(f"{name} must have {count} inputs, got {len(anfis.memberships)}")
        check_joint(joint, arm.num_joints)
        self.arm, self.inputs, self.lower, self.upper = arm, inputs, lower, upper
        self.task, self.joint = task, joint

    def predict(self, points: ArrayLike) -> tuple[Array, Array]:
        """Lower and upper bound of the joint (N,) [rad] for points (N,2) [m] or poses (N,4,4).

        NaN for NaN.

        Raises:
            ValueError: the points have another shape.
        """
        X = self._inputs_of(checked_points(points, Task(self.task))[0])
        return self.lower.predict(X), self.upper.predict(X)

    def check_are_of(self, arm: DhArm | SerialChain, task: str, joint: int) -> None:
        """Raise ValueError unless the bounds are of this arm, task and joint."""
        if not isinstance(arm, DhArm) or self.arm.table != arm.table:
            raise ValueError(
                f"the bounds are of arm {self.arm.name!r} with another table, not of {arm.name!r}"
            )
        if (self.task, self.joint) != (task, joint):
            raise ValueError(
                f"the bounds are of joint {self.joint} for task {self.task!r}, not of joint {joint} for "
                f"task {task!r}"
            )

    def save(self, path: str | Path) -> None:
        """Write a YAML file that `load` reads, with the arm's table.

        Raises:
            OSError: the file cannot be written.
        """
        data = BoundsData(
            self.arm.table,
            self.task,
            self.joint,
            self.inputs,
            self.lower.to_data(),
            self.upper.to_data(),
        )
        write_whole(path, yaml_dump_typed(data))

    @classmethod
    def load(cls, name_or_path: str | Path) -> "LearnedBounds":
        """Read bounds that come with the library, by their name, or your own, by the path of the file.

        Raises:
            FileNotFoundError: there is no such file; the message lists those that come with the library.
            ValueError: it is not such a file; the message says what is wrong.
        """
        path = find_model(name_or_path, folder=FOLDER, kind="learned bounds")
        data = load_yaml(BoundsData, path, kind="learned bounds")
        try:
            lower, upper = Anfis.from_data(data.lower), Anfis.from_data(data.upper)
            return cls(DhArm(data.arm), data.inputs, lower, upper, task=data.task, joint=data.joint)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    @classmethod
    def find(cls, arm: DhArm, task: str = "xy", joint: int = 0) -> "LearnedBounds | None":
        """The bounds of an arm that come with the library; None if there are none.

        `train_bounds` or `fikm-drake train` makes others.
        """
        if arm.name not in model_names(FOLDER):
            return None
        bounds = cls.load(arm.name)
        fits = bounds.arm.table == arm.table and (bounds.task, bounds.joint) == (task, joint)
        return bounds if fits else None
