"""How far an arm keeps from obstacles, and the fuzzy rules of its approach."""

# No `from __future__ import annotations` here: Drake's typed YAML needs real types on the fields.
from dataclasses import dataclass
from math import inf

import numpy as np

from fikm_drake.checks import check_not_negative, check_number, check_positive_finite
from fikm_drake.fuzzy.mamdani import MamdaniSystem, load_mamdani
from fikm_drake.fuzzy.rule_base import RuleBase
from fikm_drake.fuzzy.triangular_partition import TriangularPartition

INPUTS, OUTPUT = ("distance", "approach"), "rate"
"""The variables of the rules by name."""
FINEST = 32
"""Parts at least into which the rules' ranges are divided by the table that the cycle reads [-]."""


@dataclass
class ClearanceConfig:
    """How a `Clearance` keeps an arm from obstacles; Drake's typed YAML loads and dumps it.

    Attributes:
        safe_distance: no pair of bodies comes nearer than this [m]; default 0.01. Raise it for an arm
            that is late behind its command, or whose shapes are rough; and with low limits of acceleration,
            which come first: how long the arm then needs to brake is not foreseen.
        influence_distance: pairs nearer than this are looked at [m]; default 0.1. Larger is smoother
            and earlier, and costs more rows; at least the way that the arm makes in a few cycles, and
            more than `safe_distance`.
        rules: name of a fuzzy system of `models/fuzzy/`, or path of your own YAML file; default
            `clearance`. Its inputs are `distance` (0 at the safe, 1 at the influence distance,
            negative nearer than safe) and `approach` (speed of approach that is asked for, in widths of
            that zone a second [1/s]); its output `rate` [1/s] is the rate at which the
            distance to the safe one may shrink, or is won back. A larger rate is less careful.
        retreat_speed: largest speed at which a pair that is too near is parted [m/s]; default 0.25.
    """

    safe_distance: float = 0.01
    influence_distance: float = 0.1
    rules: str = "clearance"
    retreat_speed: float = 0.25

    @property
    def zone(self) -> float:
        """Width of the zone between the two distances [m]."""
        return self.influence_distance - self.safe_distance

    def validate(self) -> None:
        """Raise ValueError or FileNotFoundError, naming the bad value and the valid ones."""
        check_not_negative("safe_distance", self.safe_distance)
        check_positive_finite("influence_distance", self.influence_distance, "m")
        check_number(
            "influence_distance",
            self.influence_distance,
            f"more than safe_distance = {self.safe_distance:g} [m]",
            lambda x: self.safe_distance < x < inf,
        )
        check_positive_finite("retreat_speed", self.retreat_speed, "m/s")
        if not isinstance(self.rules, str):
            raise ValueError(f"rules must be a name or a path, got {self.rules!r}")
        # Ours need no check, which is most of a start's time.
        if self.rules != ClearanceConfig.rules:
            load_clearance_rules(self.rules)


def load_clearance_rules(name_or_path: str) -> MamdaniSystem:
    """The fuzzy rules of the approach, see `ClearanceConfig.rules`.

    Raises:
        FileNotFoundError: there is no such file; the message lists ours.
        ValueError: the file is no fuzzy system of those variables; the message says what is wrong.
    """
    system = load_mamdani(name_or_path)
    config = system.config
    inputs = tuple(variable.name for variable in config.inputs)
    outputs = tuple(variable.name for variable in config.outputs)
    if inputs != INPUTS or outputs != (OUTPUT,):
        raise ValueError(
            f"clearance rules {name_or_path!r} must have the inputs {INPUTS} and the output {OUTPUT!r}, "
            f"got {inputs} and {outputs}"
        )
    rates = clearance_table(system).consequents
    if not rates.min() >= 0.0:
        raise ValueError(
            f"clearance rules {name_or_path!r}: rate must not be negative, got {rates.min():g}"
        )
    return system


def clearance_table(system: MamdaniSystem) -> RuleBase:
    """The rules as a table that a control cycle interpolates: rate [1/s] over distance and approach.

    Exact at its knots, among them the corners of all memberships; in between too, where the memberships
    are triangles that sum to one and the system takes products and heights, as ours does.
    """
    grids = []
    for variable in system.config.inputs:
        corners = [
            x for shape in variable.memberships.values() for x in (*shape.core, *shape.support)
        ]
        ends = variable.lower, variable.upper
        knots = np.unique(np.clip([*corners, *np.linspace(*ends, FINEST + 1)], *ends))
        apart = np.diff(knots, prepend=-inf) > 1e-9 * (ends[1] - ends[0])
        grids.append(knots[apart])
    points = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1)
    rates = system(points).values[..., 0]
    first, second = (
        TriangularPartition(grid, [f"{x:.6g}#{i}" for i, x in enumerate(grid)]) for grid in grids
    )
    return RuleBase(first, second, rates, names=(*INPUTS, OUTPUT))
