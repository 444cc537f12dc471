"""The block that solves the LabVolt 5250's inverse kinematics."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from fikm_drake.arrays import Array
from fikm_drake.checks import check_period, check_position
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.solvers.labvolt.follow_target import follow_target
from fikm_drake.solvers.labvolt.fuzzy_starts import FuzzyStarts
from fikm_drake.solvers.labvolt.geometry import MODEL
from fikm_drake.solvers.labvolt.program import make_solver
from fikm_drake.solvers.labvolt.solve import REACHED, TOLERANCE, check_tolerance


class LabVoltIk(LeafSystem):
    """Inverse kinematics of a LabVolt 5250 that follows a target.

    .. pydrake_system::

        name: LabVoltIk
        input_ports:
        - desired_position
        - approach
        output_ports:
        - commanded_position
        - angles
        - status

    - **desired_position** (3) [m]: of the tool, in the base frame.
    - **approach** (1) [rad]: with `approach=True` only: angle of the hand from the horizontal, −π/2 to
      pick from above. Where a target cannot be reached at it the nearest angle is taken.
    - **commanded_position** (4) [rad]: joints of `models/labvolt5250.urdf`, which put the tool on the target.
    - **angles** (4) [rad]: the same as the LabVolt counts them: yaw, then θ_1, θ_2, θ_3 from the horizontal.
    - **status** (1): a `LabVoltStatus`. SOLVED: reached; FELL_BACK: reached, but the last
      solution was no good start, so others were tried and the arm may jump, which a `SpeedLimiter` makes a
      way of. TURNED: reached at
      another approach angle. Else (UNREACHABLE,
      INVALID_INPUT: NaN or infinite) it stays as it was at the last tick that reached its target.

    The last solution is the state, stored each period; SQP starts from it, from the fuzzy rules at first
    and where that fails. The base turns on past ±180°.

    Args:
        period: of the control cycle [s].
        initial_position: the command (4,) until a target is reached [rad]; None: the model's default.
        warm_start: False starts from the fuzzy rules in each cycle, as the paper does.
        tolerance: within this a target is reached [m].
        solver: of the SQP: `slsqp` of NLopt, or `snopt`.
        fuzzy: the rules; None: ours.
        approach: whether there is a port for the approach angle; the solution is then in closed form.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> fd.LabVoltIk(period=0.02).GetOutputPort("commanded_position").size()
        4
    """

    def __init__(
        self,
        *,
        period: float,
        initial_position: ArrayLike | None = None,
        warm_start: bool = True,
        tolerance: float = TOLERANCE,
        solver: str = "slsqp",
        fuzzy: FuzzyStarts | None = None,
        approach: bool = False,
    ) -> None:
        super().__init__()
        arm = load_arm(MODEL)
        self._lower, self._upper = arm.lower, arm.upper
        start = arm.default_position if initial_position is None else initial_position
        start = check_position(start, self._lower, self._upper)
        self._warm_start = warm_start
        self._tolerance = check_tolerance(tolerance)
        make_solver(solver)  # or ValueError
        self._solver, self._fuzzy = solver, fuzzy
        target = self.DeclareVectorInputPort("desired_position", 3)
        self._target = target.Eval
        needs = {target.ticket()}
        self._approach = None
        if approach:
            port = self.DeclareVectorInputPort("approach", 1)
            self._approach = port.Eval
            needs.add(port.ticket())
        state = self.DeclareDiscreteState([*start, 0.0])  # the last element: there is a solution
        needs.add(self.discrete_state_ticket(state))
        self._solution = self.DeclareCacheEntry(
            "solution", ValueProducer(lambda: Value(BasicVector(5)), self._solve), needs
        )
        ticket = {self._solution.ticket()}
        for name, size, calc in (
            ("commanded_position", 4, self._calc_position),
            ("angles", 4, self._calc_angles),
            ("status", 1, self._calc_status),
        ):
            self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=ticket)
        self.DeclarePeriodicDiscreteUpdateEvent(check_period(period), 0.0, self._update)

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the command (4,) [rad] in this block's context; the next solution starts from it.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        self.ValidateContext(context)
        position = check_position(position, self._lower, self._upper)
        context.SetDiscreteState(0, [*position, 1.0])

    def _solve(self, context: Context, value: Value) -> None:
        state = context.get_discrete_state(0).value()
        position, status = follow_target(
            self._target(context),
            state[:4].copy(),
            warm=bool(state[4]) and self._warm_start,
            tolerance=self._tolerance,
            solver=self._solver,
            fuzzy=self._fuzzy,
            approach=None if self._approach is None else float(self._approach(context)[0]),
        )
        value.get_mutable_value().set_value([*position, float(status)])

    def _found(self, context: Context) -> Array:
        return self._solution.Eval(context).value()

    def _calc_position(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._found(context)[:4])

    def _calc_angles(self, context: Context, output: BasicVector) -> None:
        yaw, *relative = self._found(context)[:4]
        output.set_value([yaw, *np.cumsum(relative)])

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        output[0] = self._found(context)[4]

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        found = self._found(context)
        reached = found[4] in REACHED
        if reached:
            discrete_state.set_value(0, [*found[:4], 1.0])
