"""What learned bounds are made of, as YAML."""

from dataclasses import dataclass, field

from fikm_drake.fuzzy.anfis.anfis_data import AnfisData
from fikm_drake.kinematics.dh_table import DhTable


@dataclass
class BoundsData:
    """Learned bounds, as YAML."""

    arm: DhTable = field(default_factory=DhTable)
    """The arm that they are of."""
    task: str = "xy"
    """What the points fix: `xy` or `pose`."""
    joint: int = 1
    """Whose bounds they are, from 1."""
    inputs: str = "polar"
    """`xy` or `polar`."""
    lower: AnfisData = field(default_factory=AnfisData)
    """Learned lower bound of the joint [rad]."""
    upper: AnfisData = field(default_factory=AnfisData)
    """Learned upper bound of the joint [rad]."""
