"""What a controller finds in a robot's file: its joints, what is odd, how many targets it reaches."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from math import isinf
from pathlib import Path

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.checks import check_counts
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.experiments.reach_targets import Drive, drive, random_targets
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant
from fikm_drake.kinematics.angles import middle_of_limits
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.robot_file import MakeRobotPlant, check_robot_file
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.tasks import make_task

RATE, SECONDS = 100.0, 6.0
USUAL_REACH = (0.05, 20.0)
"""Outside it a model's lengths are asked about [m]."""
CONFIG = FuzzyIkConfig(task="pose", control_rate=RATE, restart_search=True).for_reaching()


@dataclass(frozen=True)
class JointReport:
    """A joint of the chain."""

    name: str
    kind: str
    lower: float
    """[rad or m]"""
    upper: float
    velocity_limit: float
    """[rad/s or m/s]"""


@dataclass(frozen=True)
class RobotReport:
    """See `check_robot`."""

    frame: str
    joints: list[JointReport]
    reach: float
    """[m]"""
    odd: list[str]
    """What is odd, and what to do."""
    poses: int
    """Random ones, with restart search, in `SECONDS` at `RATE`."""
    reached_from_default: int
    reached_from_middle: int
    false_converged: int
    """False converged of both."""
    microseconds_a_cycle: float
    """Microseconds a cycle of CPU time [µs]."""


def check_robot(
    path: str | Path,
    frame: str = "tool",
    *,
    joints: Sequence[str] | None = None,
    base: str | None = None,
    poses: int = 50,
) -> RobotReport:
    """Look at a robot as a controller will see it, and drive it to random poses.

    Args:
        path: of a URDF, SDF or MJCF file; or one of our arms by name, or a table (.yaml).
        frame: the tool's, in a robot file.
        joints: which joints on the way to it move; None: all that can.
        base: the frame from which the chain starts; None: the world.
        poses: how many random poses are driven to, from two starts.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: naming what is wrong with the file, the frame or the joints, and what to do.
    """
    check_counts(poses=poses)
    if Path(path).suffix in ("", ".yaml", ".yml"):
        chain, odd = load_arm(path).chain, []
    else:
        findings = check_robot_file(path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of speeds of zero, which are findings
            chain = SerialChain.from_plant(MakeRobotPlant(path), frame, joints=joints, base=base)
        odd = [str(finding) for finding in findings if finding.joint in chain.joint_names]
        others = sum(finding.joint not in chain.joint_names for finding in findings)
        odd += [f"{others} more oddities at joints outside the chain"] * (others > 0)
    odd += _oddities(chain)
    targets = random_targets(chain, poses, seed=0)
    arm = PlantArm(MakeChainPlant(chain), "tool")
    cycle = ControlCycle(make_task(arm, "pose"), CONFIG)
    ends: list[list[Drive]] = []
    for start in (chain.default_position, _middle(chain)):
        cycles = round(SECONDS * RATE)
        ends.append([drive(cycle, chain, target, np.array(start), cycles) for target in targets])
    every = [one for several in ends for one in several]
    return RobotReport(
        chain.name,
        [
            JointReport(name, kind, float(low), float(high), float(speed))
            for name, kind, low, high, speed in zip(
                chain.joint_names, chain.kinds, chain.lower, chain.upper, chain.velocity_limits
            )
        ],
        chain.reach,
        odd,
        poses,
        sum(one.reached for one in ends[0]),
        sum(one.reached for one in ends[1]),
        sum(not one.honest for one in every),
        1e6 * sum(one.seconds for one in every) / sum(one.cycles for one in every),
    )


def _middle(chain: SerialChain) -> Array:
    return np.clip(middle_of_limits(chain.lower, chain.upper), chain.lower, chain.upper)


def _oddities(chain: SerialChain) -> list[str]:
    """Oddities of the chain itself."""
    odd = []
    if not USUAL_REACH[0] <= chain.reach <= USUAL_REACH[1]:
        odd.append(f"the arm reaches {chain.reach:.3g} m: are its lengths in metres?")
    if chain.num_joints < 6:
        odd.append(
            f"{chain.num_joints} joints cannot take every pose: choose a task of fewer rows, such as "
            "position"
        )
    singular = np.linalg.svd(chain.jacobian(chain.default_position), compute_uv=False)
    if chain.num_joints >= 6 and singular[-1] < 1e-3 * singular[0]:
        odd.append(
            "the default posture is singular: start elsewhere (SetPositions), or set singularity_nudge"
        )
    at_limit = [
        name
        for name, q, low, high in zip(
            chain.joint_names, chain.default_position, chain.lower, chain.upper
        )
        if q in (low, high)
    ]
    if at_limit:
        odd.append(f"the default posture is at a limit of {at_limit}: start elsewhere")
    if any(isinf(speed) for speed in chain.velocity_limits):
        odd.append("joints without a limit of speed: set FuzzyIkConfig.velocity_limits")
    return odd
