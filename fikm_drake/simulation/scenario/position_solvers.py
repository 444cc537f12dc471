"""The position solvers of papers 2, 4 and 5 as controllers of a scenario."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass, field
from typing import cast

from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.laws.law import LawLike
from fikm_drake.simulation.scenario.site import Site, Wired, no_law, only, position_block
from fikm_drake.solvers.labvolt.solution import LabVoltStatus
from fikm_drake.solvers.labvolt.solve import TOLERANCE
from fikm_drake.solvers.redundancy.learned_bounds import LearnedBounds
from fikm_drake.solvers.redundancy.redundancy_resolver import RedundancyResolver
from fikm_drake.solvers.redundancy.resolution import ResolutionStatus
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk, tojo_inverse
from fikm_drake.systems.integer_fuzzy_ik_system import IntegerFuzzyIkStatus, IntegerFuzzyIkSystem
from fikm_drake.systems.labvolt_ik import LabVoltIk
from fikm_drake.systems.redundancy_ik import RedundancyIk


@dataclass
class LabVolt:
    """Paper 4's solver, on its own arm; targets are positions.

    Attributes:
        warm_start: False starts from the fuzzy rules in each cycle, as the paper does.
        tolerance: within this a target is reached [m].
        solver: of the SQP, `slsqp` or `snopt`.
    """

    warm_start: bool = True
    tolerance: float = TOLERANCE
    solver: str = "slsqp"

    measures, avoids = False, False

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        LabVoltIk(period=1.0, tolerance=self.tolerance, solver=self.solver)

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram."""
        no_law(self, law)
        only(self, site, 3)
        if site.robot.arm.name != "labvolt5250":
            raise ValueError(
                f"controller labvolt is of the robot labvolt5250, not {site.robot.name}"
            )
        system = LabVoltIk(
            period=1.0 / site.rate,
            warm_start=self.warm_start,
            tolerance=self.tolerance,
            solver=self.solver,
        )
        ports = ("desired_position", "commanded_position", ("angles",))
        return position_block(site, system, *ports, LabVoltStatus, held=True)


@dataclass
class Redundancy:
    """Paper 2's resolver: a redundant arm in the middle of what its limits leave.

    Attributes:
        task: what the target fixes; it must leave one degree of freedom.
        joint: whose bounds are halved, from 0.
        bounds: name or path of learned bounds; empty: those that come with the arm, or traced ones.
    """

    task: str = "xy"
    joint: int = 0
    bounds: str = ""

    measures, avoids = False, False

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        if self.bounds:
            LearnedBounds.load(self.bounds)

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram."""
        no_law(self, law)
        bounds = LearnedBounds.load(self.bounds) if self.bounds else None
        resolver = RedundancyResolver(site.robot.arm, bounds, task=self.task, joint=self.joint)
        turns = resolver.task.turns
        only(self, site, 7 if turns else len(resolver.task.coordinates))
        system = RedundancyIk(resolver, period=1.0 / site.rate, initial_position=site.start)
        desired = "desired_pose" if turns else "desired_position"
        return position_block(
            site, system, desired, "commanded_position", ("bounds",), ResolutionStatus
        )


@dataclass
class Integer:
    """Paper 5's rules in integers, over the workplane of its arm; targets are positions.

    Attributes:
        labels: memberships of x and of y.
        conjunction: `min` as in the paper, or `product`.
        rounding: `truncate` as in the paper, or `nearest`.
        least_squares: whether the singletons are fitted everywhere, or taken at the peaks.
    """

    labels: list[int] = field(default_factory=lambda: [3, 3])
    conjunction: str = "min"
    rounding: str = "truncate"
    least_squares: bool = False

    measures, avoids = False, False

    def validate(self) -> None:
        """Raise ValueError, naming the bad value."""
        if len(self.labels) != 2:
            raise ValueError(f"labels must be two numbers, of x and of y, got {self.labels}")
        self._ik()

    def _ik(self) -> IntegerFuzzyIk:
        return IntegerFuzzyIk(
            labels=(self.labels[0], self.labels[1]),
            conjunction=cast(Conjunction, self.conjunction),
            rounding=cast(Rounding, self.rounding),
            least_squares=self.least_squares,
        )

    def add(self, site: Site, law: LawLike | None = None) -> Wired:
        """Add it to a Diagram."""
        no_law(self, law)
        only(self, site, 3)
        if site.robot.arm.name != "tojo4dof":
            raise ValueError(f"controller integer is of the robot tojo4dof, not {site.robot.name}")
        system = IntegerFuzzyIkSystem(self._ik(), tojo_inverse().workplane, period=1.0 / site.rate)
        return position_block(
            site, system, "desired_position", "commanded_position", (), IntegerFuzzyIkStatus
        )
