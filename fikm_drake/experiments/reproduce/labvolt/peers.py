"""Ordinary ways to the same solution, for comparison."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import MathematicalProgram, SnoptSolver, SolverOptions

from fikm_drake.arrays import Array
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.labvolt.geometry import MODEL, labvolt
from fikm_drake.solvers.labvolt.program import make_solver

Solver = Callable[[Array, Array], Array]
"""A target in the base frame (3,) [m] and a start (4,) to joint positions (4,) [rad]."""
SNOPT_TOLERANCE = 1e-10
"""Drake's defaults stop micrometres away."""


def python_callback() -> Solver:
    """Equation 5 as one would write it in numpy: in absolute angles, built anew for each target.

    The solver and its tolerances are those of our program.
    """
    geometry = labvolt()
    solver, options = make_solver("slsqp")
    lengths = np.array(geometry.lengths)

    def solve(target: Array, start: Array) -> Array:
        x = float(np.hypot(target[0], target[1])) - geometry.offset
        y = float(target[2]) - geometry.height

        def cost(angles: Array) -> Any:
            dx = lengths @ np.cos(angles) - x
            dy = lengths @ np.sin(angles) - y
            return dx**2 + dy**2

        program = MathematicalProgram()
        angles = program.NewContinuousVariables(3, "theta")
        program.AddBoundingBoxConstraint(geometry.lower[0], geometry.upper[0], angles[0])
        for i in (1, 2):
            bend = angles[i] - angles[i - 1]
            program.AddLinearConstraint(bend, geometry.lower[i], geometry.upper[i])
        program.AddCost(cost, vars=angles)
        result = solver.Solve(program, np.cumsum(start[1:]), options)
        relative = np.diff(result.GetSolution(angles), prepend=0.0)
        return np.array([np.arctan2(target[1], target[0]), *relative])

    return solve


def drake_inverse_kinematics() -> Solver:
    """Drake's `InverseKinematics` on the same arm, a position constraint, SNOPT; the plant is built once."""
    plant = MakeDhArmPlant(load_arm(MODEL))
    tool, world = plant.GetFrameByName("tool"), plant.world_frame()
    solver, options = SnoptSolver(), SolverOptions()
    for kind in ("Major optimality", "Major feasibility", "Minor feasibility"):
        options.SetOption(solver.solver_id(), f"{kind} tolerance", SNOPT_TOLERANCE)

    def solve(target: Array, start: Array) -> Array:
        ik = InverseKinematics(plant)
        ik.AddPositionConstraint(tool, np.zeros(3), world, target, target)
        result = solver.Solve(ik.prog(), start, options)
        return result.GetSolution(ik.q())

    return solve
