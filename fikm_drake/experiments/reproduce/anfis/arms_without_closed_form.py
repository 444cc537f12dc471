"""Redundancy resolution of arms without a closed form: a planar 4R by learned bounds, an iiwa14 by traces."""

import time

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.reproduce.anfis.samples import rms_and_max
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import Resolution, ResolutionStatus
from fikm_drake.solvers.redundancy.workspace_points import random_tool_poses
from fikm_drake.solvers.self_motion.generate_feasibility_data import generate_feasibility_data

ARM = "hassantabar4r"
SEVEN_JOINTS, JOINT = "iiwa14", 2
SEED = 1
"""Training has another."""
FRESH, TRACED, TRACED_7 = 1000, 100, 4
"""Poses to resolve; those of them that are traced too; poses of the 7-joint arm."""
RAW = 97.0
"""Postures from learned bounds that must respect all limits before any repair [%]."""
EXACT = 1e-12
"""What an element of the tool's pose may be off [m, -]."""
FASTER = 100.0
"""Times that learned bounds with Newton's method must be faster than tracing."""


def no_closed_form() -> Section:
    """Fresh poses of both arms: limits, where the tool is, time against tracing."""
    bounds = LearnedBounds.load(ARM)
    resolver = RedundancyResolver(bounds.arm, bounds, task="pose")
    poses = random_tool_poses(bounds.arm, FRESH, SEED, near_limits=0.0)
    found = resolver.resolve(poses)
    learned = found.status == ResolutionStatus.SOLVED
    raw = 100.0 * float(np.mean(learned))

    traced = poses[:TRACED]
    start = time.process_time()
    data = generate_feasibility_data(bounds.arm, traced, task="pose")
    tracing = (time.process_time() - start) / len(traced)
    rms = [rms_and_max(p - e) for p, e in zip(bounds.predict(traced), (data.lower, data.upper))]
    start = time.process_time()
    resolver.resolve(poses[learned])
    resolving = (time.process_time() - start) / np.count_nonzero(learned)
    start = time.process_time()
    resolver.resolve(poses)
    repairing = (time.process_time() - start) / len(poses)

    seven = load_arm(SEVEN_JOINTS)
    targets = random_tool_poses(seven, TRACED_7, SEED, near_limits=0.0)
    of_seven = RedundancyResolver(seven, task="pose", joint=JOINT).resolve(targets)
    cells = [
        Cell(f"lower: rms error, {TRACED} traced poses [rad]", None, rms[0][0]),
        Cell(f"upper: rms error, {TRACED} traced poses [rad]", None, rms[1][0]),
        Cell("limits respected, learned bounds alone [%]", None, raw, raw >= RAW),
        *_verified(bounds.arm, poses, found),
        Cell("CPU time of tracing a pose [ms]", None, 1e3 * tracing),
        Cell("of learned bounds and Newton's method, in a batch [ms]", None, 1e3 * resolving),
        Cell("times faster", None, tracing / resolving, bool(tracing >= FASTER * resolving)),
        Cell("of all poses, with repairs [ms]", None, 1e3 * repairing),
        *_verified(seven, targets, of_seven),
    ]
    notes = [
        f"{ARM}, task pose, joint 1: 125 rules of 4000 traced poses, `fikm-drake train traced-bounds {ARM}`.",
        f"{FRESH} fresh poses of random postures, seed {SEED}.",
        f"{SEVEN_JOINTS}: joint {JOINT + 1}, {TRACED_7} poses, traced: nothing is learned over poses.",
    ]
    return Section(
        "no closed form", "redundancy resolution where there is no closed form", cells, notes
    )


def _verified(arm: DhArm, poses: Array, found: Resolution) -> list[Cell]:
    """Limits and the tool's place, checked without the resolver's own figures."""
    inside = 100.0 * float(np.mean(((found.q >= arm.lower) & (found.q <= arm.upper)).all(axis=1)))
    away = np.abs(arm.forward_kinematics(found.q) - poses).max(axis=(1, 2))
    largest = float(np.max(away, initial=0.0, where=found.success))
    return [
        Cell(f"{arm.name}: limits respected after repair [%]", None, inside, inside == 100.0),
        Cell(
            f"{arm.name}: elements of the tool's pose off, at most [m, -]",
            None,
            largest,
            largest <= EXACT,
        ),
    ]
