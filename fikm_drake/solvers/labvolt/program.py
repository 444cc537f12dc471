"""Equation 5 as a MathematicalProgram that is built once and solved for every target."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.solvers import (
    MathematicalProgram,
    NloptSolver,
    SnoptSolver,
    SolverInterface,
    SolverOptions,
)
from pydrake.symbolic import cos, sin

from fikm_drake.solvers.labvolt.geometry import Geometry

Array = NDArray[np.float64]
SOLVERS = ("slsqp", "snopt")
TOLERANCE = 1e-12
"""Of the solvers' tests, on angles [rad] and lengths over the reach [-]."""
MOST_EVALUATIONS = 300
STRAIGHT = 0.02
"""An arm bent by less than this [rad] counts as straight: no step is downhill from there to a target
that lies on its line."""
BEND = -0.1
"""The elbow of a start that is straight is bent by this, upward [rad]."""


class LabVoltProgram:
    """Sequential quadratic programming for the arm in its plane, equation 5 of the paper.

    In the relative angles θ_1, θ_2 − θ_1, θ_3 − θ_2 the limits are bounds, lengths are divided by the
    reach, and the cost is symbolic, so that Drake evaluates it in C++. The target is two decision
    variables that a bounding box holds; a new target moves the box, and the program is never
    built again.

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
        self._solver, self._options = make_solver(solver)
        self._absolute = absolute
        self._reach = _Program(geometry, absolute=absolute)
        self._settle: _Program | None = None

    def reach(self, target: Array, start: Array) -> Array:
        """The posture nearest to a target that is found from a start.

        Args:
            target: in the arm's plane (2,), finite [m].
            start: relative angles (3,) [rad].

        Returns:
            Relative angles (3,) inside the limits [rad].
        """
        start = self._inside(start)
        if abs(start[1]) + abs(start[2]) < STRAIGHT:
            start[1] = BEND
        if self._absolute:
            angles = self._run(self._reach, np.cumsum(start), target / self._geometry.reach)
            return self._inside(np.diff(angles, prepend=0.0))
        return self._inside(self._run(self._reach, start, target / self._geometry.reach))

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
            self._settle = _Program(self._geometry, posture=True)
        parameters = np.array([*(target / self._geometry.reach), *wish])
        return self._inside(self._run(self._settle, start, parameters))

    def _run(self, program: "_Program", start: Array, parameters: Array) -> Array:
        program.held.set_bounds(parameters, parameters)
        guess = np.array([*start, *parameters])
        found = self._solver.Solve(program.prog, guess, self._options).get_x_val()[:3]
        # SLSQP gives NaN where its quadratic program breaks down.
        return found if np.isfinite(found).all() else start

    def _inside(self, relative: Array) -> Array:
        return self._geometry.clip(relative[:, None])[:, 0]


class _Program:
    """Angles as decision variables, and parameters: the target and, with a posture, the wish."""

    def __init__(
        self, geometry: Geometry, *, absolute: bool = False, posture: bool = False
    ) -> None:
        self.prog = MathematicalProgram()
        q = self.prog.NewContinuousVariables(3, "q")
        parameters = self.prog.NewContinuousVariables(5 if posture else 2, "p")
        zeros = np.zeros(len(parameters))
        self.held: Any = self.prog.AddBoundingBoxConstraint(zeros, zeros, parameters).evaluator()
        if absolute:
            angles = q
            for i, relative in enumerate(np.diff(q, prepend=0.0)):
                self.prog.AddLinearConstraint(relative, geometry.lower[i], geometry.upper[i])
        else:
            angles = np.cumsum(q)
            self.prog.AddBoundingBoxConstraint(geometry.lower, geometry.upper, q)
        lengths = np.array(geometry.lengths) / geometry.reach
        dx = sum(a * cos(angle) for a, angle in zip(lengths, angles)) - parameters[0]
        dy = sum(a * sin(angle) for a, angle in zip(lengths, angles)) - parameters[1]
        if posture:
            self.prog.AddConstraint(dx == 0.0)
            self.prog.AddConstraint(dy == 0.0)
            self.prog.AddCost(((q - parameters[2:]) ** 2).sum())
        else:
            self.prog.AddCost(dx**2 + dy**2)


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
        for tolerance in (
            NloptSolver.XAbsoluteToleranceName(),
            NloptSolver.XRelativeToleranceName(),
            NloptSolver.ConstraintToleranceName(),
        ):
            options.SetOption(key, tolerance, TOLERANCE)
    else:
        for kind in ("Major optimality", "Major feasibility", "Minor feasibility"):
            options.SetOption(key, f"{kind} tolerance", TOLERANCE)
    return solver, options
