"""What an arm hands on of its chain: how many joints, their limits, where they stand by default."""

from fikm_drake.arrays import Array
from fikm_drake.kinematics.serial_chain import SerialChain


class ChainLimits:
    """Limits of an arm's `chain`, copied so that they can be written to."""

    chain: SerialChain
    """The arm's one model of its kinematics."""

    @property
    def num_joints(self) -> int:
        """The number of joints, n."""
        return self.chain.num_joints

    @property
    def lower(self) -> Array:
        """Lower joint limits (n,) [rad or m], −inf where there is none."""
        return self.chain.lower.copy()

    @property
    def upper(self) -> Array:
        """Upper joint limits (n,) [rad or m], inf where there is none."""
        return self.chain.upper.copy()

    @property
    def velocity_limits(self) -> Array:
        """Largest joint speeds (n,) [rad/s or m/s], inf where there is no limit."""
        return self.chain.velocity_limits.copy()

    @property
    def acceleration_limits(self) -> Array:
        """Largest joint accelerations (n,) [rad/s² or m/s²], inf where there is no limit."""
        return self.chain.acceleration_limits.copy()

    @property
    def default_position(self) -> Array:
        """Where the joints stand by default, inside the limits (n,) [rad or m].

        Of a table the positions nearest to zero, of a plant those in its Context.
        """
        return self.chain.default_position.copy()
