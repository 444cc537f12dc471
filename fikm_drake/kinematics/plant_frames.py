"""Checks of a plant, and its frames by name."""

from pydrake.multibody.parsing import GetScopedFrameByName
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, FrameIndex


def check_plant(plant: MultibodyPlant) -> None:
    """Raise ValueError unless the plant is finalized and has joints, all of them with q̇ = v."""
    if not plant.is_finalized():
        raise ValueError("the plant must be finalized: call plant.Finalize() first")
    if plant.num_positions() == 0 or not plant.IsVelocityEqualToQDot():
        raise ValueError(
            "the plant must have joints, and only such whose velocities are the rates of their "
            "positions; weld its base (a free base has a quaternion)"
        )


def as_frame(plant: MultibodyPlant, frame: str | Frame | None) -> Frame:
    """A frame, or the one of that name, see `frame_by_name`; None: the world's."""
    if frame is None:
        return plant.world_frame()
    return frame_by_name(plant, frame) if isinstance(frame, str) else frame


def frame_by_name(plant: MultibodyPlant, name: str | None) -> Frame:
    """The only frame of that name, `instance::name` where several model instances have one.

    Raises:
        ValueError: there is no or more than one such frame; the message lists the frames.
    """
    try:
        return GetScopedFrameByName(plant, name)
    except (RuntimeError, TypeError):
        frames = (plant.get_frame(FrameIndex(i)) for i in range(plant.num_frames()))
        raise ValueError(
            f"frame must name exactly one frame of the plant, got {name!r}; there are: "
            + ", ".join(frame.scoped_name().get_full() for frame in frames)
        ) from None
