"""A scene run by Pink with its collision barrier, where it is installed (`pip install pin-pink`)."""

import importlib
import importlib.util
import re
import time
from typing import Any

import numpy as np
from pydrake.geometry import Box, Capsule, Cylinder, Shape, Sphere
from pydrake.multibody.tree import RigidBody
from pydrake.planning import CollisionChecker

from fikm_drake.arrays import Array
from fikm_drake.control.clearance_config import ClearanceConfig
from fikm_drake.experiments.benchmarks.obstacle_scenes import ObstacleScene
from fikm_drake.experiments.benchmarks.obstacle_settings import PinkSettings
from fikm_drake.kinematics.load_arm import load_arm

PAIRS = 12
"""Of the barrier: pairs that it looks at, the nearest [-]."""


def has_pink() -> bool:
    """True if Pink, Pinocchio and a solver for it are installed."""
    return all(importlib.util.find_spec(x) for x in ("pink", "pinocchio", "coal", "quadprog"))


def run_pink(
    scene: ObstacleScene,
    checker: CollisionChecker,
    *,
    rate: float,
    seconds: float,
    clearance: ClearanceConfig,
    settings: PinkSettings,
) -> tuple[Array, Array]:
    """Commands (N,n) of Pink's `solve_ik` and the CPU time of each cycle (N,) [s].

    Its model is the arm's URDF, its collision shapes and pairs are those of Drake's checker, its
    barrier keeps the same safe distance; its QP is solved by quadprog. A cycle that it cannot solve holds the
    joints.
    """
    pin, pink = (importlib.import_module(x) for x in ("pinocchio", "pink"))
    barriers = importlib.import_module("pink.barriers")
    arm = load_arm(scene.arm)
    urdf = re.sub(
        r"<collision.*?</collision>", "", arm.to_urdf(), flags=re.DOTALL
    )  # the checker has them
    model = pin.buildModelFromXML(urdf)
    shapes = _geometry(pin, model, checker, arm.name)
    configuration = pink.Configuration(
        model,
        model.createData(),
        scene.start,
        collision_model=shapes,
        collision_data=pin.GeometryData(shapes),
    )
    turns = 0.0 if scene.task == "position" else 1.0
    tool = pink.tasks.FrameTask(
        "tool",
        position_cost=1.0,
        orientation_cost=turns,
        gain=settings.gain,
        lm_damping=settings.damping,
    )
    tool.set_target(pin.SE3(scene.target[:3, :3], scene.target[:3, 3]))
    posture = pink.tasks.PostureTask(cost=settings.posture)
    posture.set_target(scene.start)
    barrier = barriers.SelfCollisionBarrier(
        n_collision_pairs=min(PAIRS, len(shapes.collisionPairs)),
        gain=settings.barrier,
        d_min=clearance.safe_distance,
    )
    positions, times = [], []
    for _ in range(round(rate * seconds)):
        begin = time.process_time()
        try:
            velocity = pink.solve_ik(
                configuration, [tool, posture], 1.0 / rate, solver="quadprog", barriers=[barrier]
            )
            configuration.integrate_inplace(velocity, 1.0 / rate)
        except (pink.exceptions.PinkError, ValueError):  # no solution, or a joint at its limit
            pass
        times.append(time.process_time() - begin)
        positions.append(configuration.q.copy())
    return np.array(positions), np.array(times)


def _geometry(pin: Any, model: Any, checker: CollisionChecker, arm: str) -> Any:
    """Pinocchio's collision model of a checker's shapes and pairs; what is not the arm is fixed."""
    plant = checker.plant()
    context = plant.CreateDefaultContext()
    inspector = checker.model().scene_graph().model_inspector()
    robot = plant.GetModelInstanceByName(arm)
    shapes = pin.GeometryModel()
    bodies: list[RigidBody] = []
    for geometry in inspector.GetAllGeometryIds():
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        if body is None or inspector.GetProximityProperties(geometry) is None:
            continue
        X = inspector.GetPoseInFrame(geometry)
        joint, frame, before = 0, 0, pin.SE3.Identity()
        if body.model_instance() == robot:
            frame = model.getFrameId(body.name())
            joint, before = model.frames[frame].parentJoint, model.frames[frame].placement
        else:
            X = plant.EvalBodyPoseInWorld(context, body) @ X
        placed = before * pin.SE3(X.rotation().matrix(), X.translation())
        name = f"{body.scoped_name().get_full()}#{len(bodies)}"
        shape = _shape(inspector.GetShape(geometry))
        shapes.addGeometryObject(pin.GeometryObject(name, joint, frame, placed, shape))
        bodies.append(body)
    for i, one in enumerate(bodies):
        for k in range(i):
            ours = robot in (one.model_instance(), bodies[k].model_instance())
            if ours and not checker.IsCollisionFilteredBetween(one, bodies[k]):
                shapes.addCollisionPair(pin.CollisionPair(k, i))
    return shapes


def _shape(shape: Shape) -> Any:
    """Coal's shape for Drake's."""
    coal = importlib.import_module("coal")
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius())
    if isinstance(shape, Box):
        return coal.Box(shape.width(), shape.depth(), shape.height())
    if isinstance(shape, Capsule):
        return coal.Capsule(shape.radius(), shape.length())
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius(), shape.length())
    raise ValueError(f"no shape of Pink's for {shape!r}")
