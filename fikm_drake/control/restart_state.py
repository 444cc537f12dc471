"""What a restart search does."""

from enum import IntEnum


class RestartState(IntEnum):
    """What a restart search does; the first element of its memory."""

    NONE = 0
    """The law leads."""
    SEARCHING = 1
    """The law stays where it is; a posture is searched for."""
    UNDERWAY = 2
    """The joints move to the posture that was found."""
    STUCK = 3
    """None was found: the target is out of reach, as far as the search can tell."""
