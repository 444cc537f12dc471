"""Public arms, driven to random targets: ours, ours with restart search, Drake's integrator, Pink, SNOPT.

All have the same chain, limits, start (the default posture), rate and time; a model without a limit of a
position or speed gets one. SNOPT, a local optimiser from the same start, needs no time: what it reaches tells
what can be reached without a look at other postures. Where the packages of the extra `peers` are not
installed, our own models stand in.
"""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from pydrake.math import RigidTransform

from fikm_drake.arrays import Array
from fikm_drake.control.cycle import ControlCycle
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.experiments.benchmarks.arms_peers import Run, drakes_integrator, pinks, snopts
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.experiments.benchmarks.public_arms import ARMS, public_chain, public_plant
from fikm_drake.experiments.benchmarks.quiet_drake import quiet_drake
from fikm_drake.experiments.reach_targets import MET, Drive, drive, errors, random_targets
from fikm_drake.kinematics.add_dh_arm import MakeChainPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.kinematics.plant_arm import PlantArm
from fikm_drake.kinematics.serial_chain import SerialChain
from fikm_drake.kinematics.tasks import make_task
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping

RATE, SECONDS = 100.0, 6.0
CYCLES = round(RATE * SECONDS)
OURS = ("arm7", "iiwa14", "panda", "puma560")
SHARP = FuzzyMapping.iterated()
POSITION = FuzzyIkConfig(control_rate=RATE)
POSE = FuzzyIkConfig(control_rate=RATE, task="pose", law=SHARP)


@dataclass(frozen=True)
class ArmRow:
    """Targets reached, out of `targets`, for one arm."""

    arm: str
    joints: int
    targets: int
    position: int
    """By the default controller, position only."""
    position_reaching: int
    """By `for_reaching`, without a search."""
    position_searched: int
    """By `for_reaching` with restart search."""
    position_pink: int | None
    """None where it is not installed."""
    position_snopt: int
    """By a local optimiser from the same start."""
    pose: int
    """By `FuzzyMapping.iterated`."""
    pose_reaching: int
    """By `for_reaching`, without a search."""
    pose_searched: int
    """By `for_reaching` with restart search."""
    drake: int
    """Poses by Drake's integrator."""
    pink: int | None
    """Poses; None where it is not installed."""
    pose_snopt: int
    """By a local optimiser from the same start."""
    false_converged: int
    """False converged of all of our drives: CONVERGED, but not there."""
    largest_speed: float
    """Largest speed of all of our drives, over the limits [-]."""
    outside: float
    """How far beyond the limits of position [rad or m]."""


def table(targets: int, progress: Callable[[float], None]) -> str:
    """The table for `targets` targets an arm."""
    chains = dict(_chains())
    rows = []
    with quiet_drake():
        for i, (name, chain) in enumerate(chains.items()):
            rows.append(_row(name, chain, targets))
            progress((i + 1) / len(chains))
    return BenchmarkTable(_lines(rows), rows)


def _chains() -> Iterator[tuple[str, SerialChain]]:
    with quiet_drake():
        found = []
        for arm in ARMS:
            plant = public_plant(arm)
            if plant is not None:
                found.append((arm.name, public_chain(arm, plant)))
    yield from found or [(name, load_arm(name).chain) for name in OURS]


def _row(name: str, chain: SerialChain, count: int) -> ArmRow:
    plant, start = MakeChainPlant(chain), np.array(chain.default_position)
    arm = PlantArm(plant, "tool")
    targets = random_targets(chain, count, seed=7)
    reached: dict[str, int] = {}
    every: list[Drive] = []
    for task, plain in (("position", POSITION), ("pose", POSE)):
        for label, config in (
            (task, plain),
            (f"{task}_reaching", plain.for_reaching()),
            (
                f"{task}_searched",
                dataclasses.replace(plain.for_reaching(), restart_search=True),
            ),
        ):
            cycle = ControlCycle(make_task(arm, config.task), config)
            drives = [drive(cycle, chain, target, start, CYCLES) for target in targets]
            reached[label] = sum(one.reached for one in drives)
            every += drives

    def met(run: Run, *, pose: bool = True) -> int:
        return sum(_met(chain, run(target), target, pose) for target in targets)

    timing = {"rate": RATE, "seconds": SECONDS}
    here = find_spec("pink") is not None
    return ArmRow(
        arm=name,
        joints=chain.num_joints,
        targets=count,
        **reached,
        position_pink=met(pinks(chain, start, **timing, pose=False), pose=False) if here else None,
        position_snopt=met(snopts(chain, start, pose=False), pose=False),
        drake=met(drakes_integrator(chain, start, **timing)),
        pink=met(pinks(chain, start, **timing, pose=True)) if here else None,
        pose_snopt=met(snopts(chain, start, pose=True)),
        false_converged=sum(not one.honest for one in every),
        largest_speed=max(one.largest_speed for one in every),
        outside=max(one.outside for one in every),
    )


def _met(chain: SerialChain, q: Array, target: RigidTransform, pose: bool) -> bool:
    inside = (q >= chain.lower - 1e-6) & (q <= chain.upper + 1e-6)
    distance, angle = errors(chain.forward_kinematics(q), target)
    return bool(inside.all() and distance <= MET[0] and (angle <= MET[1] or not pose))


def _lines(rows: list[ArmRow]) -> Iterator[str]:
    columns = "position position_reaching position_searched position_pink position_snopt pose "
    columns += "pose_reaching pose_searched drake pink pose_snopt false_converged"
    heads = "position reaching searched Pink SNOPT pose reaching searched Drake Pink SNOPT false"
    yield f"{'arm':34s}{'n':>3s}" + "".join(f"{head:>9s}" for head in heads.split())
    for row in rows:
        values = [getattr(row, name) for name in columns.split()]
        cells = "".join(f"{'-' if value is None else value:>9}" for value in values)
        yield f"{row.arm:34s}{row.joints:3d}{cells}"
    total = sum(row.targets for row in rows)
    yield f"{len(rows)} arms, {total} targets, from the default posture, {SECONDS:g} s at {RATE:g} Hz"
    for task in ("position", "pose"):
        plain, reaching, searched, snopt = (
            sum(getattr(row, task + part) for row in rows)
            for part in ("", "_reaching", "_searched", "_snopt")
        )
        yield (
            f"{task}: plain {plain}, for_reaching {reaching}, with restart search {searched}; "
            f"a local optimiser (SNOPT) {snopt}"
        )
    peers = [row for row in rows if row.pink is not None]
    if peers:
        yield f"Pink: position {sum(r.position_pink or 0 for r in peers)}, pose " + str(
            sum(row.pink or 0 for row in peers)
        )
        least = {
            "with restart search": sum(row.pose_searched >= (row.pink or 0) for row in peers),
            "by for_reaching": sum(row.pose_reaching >= (row.pink or 0) for row in peers),
            "by the plain law": sum(row.pose >= (row.pink or 0) for row in peers),
        }
        told = ", ".join(f"on {count} arms {how}" for how, count in least.items())
        yield f"pose, at least as many as Pink: {told}"
    yield f"false CONVERGED: {sum(row.false_converged for row in rows)}"
    speed, outside = max(row.largest_speed for row in rows), max(row.outside for row in rows)
    yield f"largest speed over its limit: {speed:.4f}; farthest outside limits: {outside:.1e}"
