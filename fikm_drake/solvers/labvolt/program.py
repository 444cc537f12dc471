"""Equation 5 as a MathematicalProgram that is built once and solved for every target."""

from functools import cache
from itertools import accumulate
from math import atan2, hypot, inf, isfinite
from typing import Any, NamedTuple

import numpy as np
from pydrake.solvers import (
    MathematicalProgram,
    NloptSolver,
    SnoptSolver,
    SolverInterface,
    SolverOptions,
)
from pydrake.symbolic import cos, sin

from fikm_drake.arrays import Array
from fikm_drake.solvers.labvolt.geometry import Geometry

SOLVERS = ("slsqp", "snopt")
TOLERANCE, FEASIBILITY = 1e-10, 1e-12
"""Tolerances of the solvers, on angles [rad] and gradients [-]; on constraints, lengths over reach [-]."""
MOST_EVALUATIONS = 300
STRAIGHT = 0.02
"""An arm bent by less than this [rad] counts as straight: no step is downhill from there to a target
that lies on its line."""
BEND = -0.1
"""The elbow of a start that is straight is bent by this, upward [rad]."""


class LabVoltProgram:
    """Sequential quadratic programming for the arm in its plane, equation 5 of the paper.

    In the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2 the limits are bounds, lengths are divided by the
    reach, and the cost is symbolic, so that Drake evaluates it in C++. A new target only moves bounds
    and the program is never built again: the plane is turned until the target lies on the x axis, its
    bearing moves the bounds of θ_1, and its distance is a decision variable that bounds hold.

    `is_success()` of either solver is true in local minima too: check what comes out by
    `forward_kinematics`, as `solve` does.

    Args:
        geometry: of the arm.
        solver: `slsqp` of NLopt, or `snopt`.
        absolute: the paper's form, for comparison: variables are the absolute angles, so two of the
            limits are linear constraints. It has more local minima.

    Raises:
        ValueError: an unknown solver, or one that this build of Drake lacks.
    """

    def __init__(
        self, geometry: Geometry, *, solver: str = "slsqp", absolute: bool = False
    ) -> None:
        self._geometry = geometry
        self._lower, self._upper = np.array(geometry.lower), np.array(geometry.upper)
        self._solver, self._options = make_solver(solver)
        self._absolute = absolute
        self._reach = _reach_program(geometry, absolute)
        self._settle: _Program | None = None

    def reach(self, target: Array, start: Array) -> Array:
        """The posture nearest to a target that is found from a start.

        Args:
            target: in the arm's plane (2,), finite [m].
            start: relative angles (3,) [rad].

        Returns:
            Relative angles (3,) inside the limits [rad].
        """
        x, y = target.tolist()
        start = self._inside(start)
        if abs(start[1]) + abs(start[2]) < STRAIGHT:
            start[1] = BEND
        bearing, distance = atan2(y, x), hypot(x, y) / self._geometry.reach
        if not self._absolute:
            return self._run(self._reach, start, bearing, [distance])
        turned = np.cumsum(start) - bearing
        lower = [self._lower[0] - bearing, -inf, -inf, distance]
        upper = [self._upper[0] - bearing, inf, inf, distance]
        self._reach.box.set_bounds(lower, upper)
        found = self._solve(self._reach, np.array([*turned, distance])) + bearing
        return self._inside(np.diff(found, prepend=0.0))

    def settle(self, target: Array, start: Array, wish: Array) -> Array:
        """Among the postures that reach a target, the one nearest to a wish by |q − wish|².

        Args:
            target: in the arm's plane (2,), finite [m].
            start: relative angles (3,) that reach it [rad].
            wish: relative angles (3,) [rad].

        Returns:
            Relative angles (3,) inside the limits [rad].
        """
        if self._settle is None:
            self._settle = _settle_program(self._geometry)
        x, y = target.tolist()
        bearing, distance = atan2(y, x), hypot(x, y) / self._geometry.reach
        parameters = [distance, wish[0] - bearing, wish[1], wish[2]]
        return self._run(self._settle, self._inside(start), bearing, parameters)

    def _run(
        self, program: "_Program", start: Array, bearing: float, parameters: list[float]
    ) -> Array:
        box = np.empty((3, 3 + len(parameters)))  # bounds and the guess
        box[0, :3], box[1, :3], box[2, :3] = self._lower, self._upper, start
        box[:, 0] -= bearing
        box[:, 3:] = parameters
        program.box.set_bounds(box[0], box[1])
        found = self._solve(program, box[2])
        found[0] += bearing
        return self._inside(found)

    def _solve(self, program: "_Program", guess: Array) -> Array:
        """The three angles; those of the guess where SLSQP's quadratic program breaks down to NaN."""
        found = self._solver.Solve(program.prog, guess, self._options).get_x_val()
        return (found if isfinite(found.dot(found)) else guess)[:3].copy()

    def _inside(self, relative: Array) -> Array:
        return np.minimum(np.maximum(relative, self._lower), self._upper)


class _Program(NamedTuple):
    prog: MathematicalProgram
    box: Any
    """Bounds of all decision variables: three angles, then the parameters, which it holds."""


def _reach_program(geometry: Geometry, absolute: bool) -> _Program:
    program, q, (distance,) = _variables(1)
    dx, dy = _miss(geometry, q if absolute else list(accumulate(q)), distance)
    if absolute:
        for i in (1, 2):
            bend = q[i] - q[i - 1]
            program.prog.AddLinearConstraint(bend, geometry.lower[i], geometry.upper[i])
    program.prog.AddCost(dx**2 + dy**2)
    return program


def _settle_program(geometry: Geometry) -> _Program:
    program, q, (distance, *wish) = _variables(4)
    dx, dy = _miss(geometry, list(accumulate(q)), distance)
    program.prog.AddConstraint(dx == 0.0)
    program.prog.AddConstraint(dy == 0.0)
    program.prog.AddCost(sum((a - b) ** 2 for a, b in zip(q, wish)))
    return program


def _variables(parameters: int) -> tuple[_Program, Any, Any]:
    """A program with three angles and some parameters."""
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(3 + parameters, "x")
    zeros = np.zeros(len(x))
    box = prog.AddBoundingBoxConstraint(zeros, zeros, x).evaluator()
    return _Program(prog, box), x[:3], x[3:]


def _miss(geometry: Geometry, angles: Any, distance: Any) -> tuple[Any, Any]:
    """The tool minus a target on the x axis, over the reach."""
    lengths = np.array(geometry.lengths) / geometry.reach
    dx = sum(a * cos(angle) for a, angle in zip(lengths, angles)) - distance
    return dx, sum(a * sin(angle) for a, angle in zip(lengths, angles))


@cache
def make_solver(name: str) -> tuple[SolverInterface, SolverOptions]:
    """A solver and its options.

    Raises:
        ValueError: an unknown solver, or one that this build of Drake lacks.
    """
    if name not in SOLVERS:
        raise ValueError(f"solver must be one of {SOLVERS}, got {name!r}")
    solver = NloptSolver() if name == "slsqp" else SnoptSolver()
    if not solver.available():
        raise ValueError(f"solver {name!r} is not in this build of Drake; one of {SOLVERS} may be")
    options, key = SolverOptions(), solver.solver_id()
    if name == "slsqp":
        options.SetOption(key, NloptSolver.AlgorithmName(), "LD_SLSQP")
        options.SetOption(key, NloptSolver.MaxEvalName(), MOST_EVALUATIONS)
        options.SetOption(key, NloptSolver.XAbsoluteToleranceName(), TOLERANCE)
        options.SetOption(key, NloptSolver.XRelativeToleranceName(), TOLERANCE)
        options.SetOption(key, NloptSolver.ConstraintToleranceName(), FEASIBILITY)
    else:
        options.SetOption(key, "Major optimality tolerance", TOLERANCE)
        options.SetOption(key, "Major feasibility tolerance", FEASIBILITY)
        options.SetOption(key, "Minor feasibility tolerance", FEASIBILITY)
    return solver, options
