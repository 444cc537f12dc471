"""From one pose to another in plain numbers: half of what the calls of pydrake and numpy take."""

from math import atan2, hypot

from pydrake.math import RigidTransform


def pose_error(now: RigidTransform, wanted: RigidTransform, length: float) -> list[float]:
    """The turn and the way that lead from one pose to another, in the frame of both.

    Twice the sine of the turn's angle, times its axis, is the sum of the cross products of the columns of
    both rotation matrices; twice its cosine that of their dot products, less 1. From a right angle on, where
    the sine says less and less of the angle, Drake's quaternion does.

    Args:
        now: the pose.
        wanted: the other one.
        length: a turn of 1 rad counts as this much [m].

    Returns:
        (6,): angle times axis, the short way, times `length`, then the difference of the positions [m].
    """
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = now.GetAsMatrix34().tolist()
    (A, B, C, X), (D, E, F, Y), (G, H, K, Z) = wanted.GetAsMatrix34().tolist()
    cos = a * A + b * B + c * C + d * D + e * E + f * F + g * G + h * H + i * K - 1.0
    if cos > 0.0:
        u = d * G - g * D + e * H - h * E + f * K - i * F
        v = g * A - a * G + h * B - b * H + i * C - c * K
        w = a * D - d * A + b * E - e * B + c * F - f * C
        sin = hypot(u, v, w)
        scale = length * atan2(sin, cos) / sin if sin > 0.0 else 0.0
    else:
        turn = wanted.rotation().multiply(now.rotation().inverse()).ToAngleAxis()
        u, v, w = turn.axis().tolist()
        scale = length * turn.angle()
    return [scale * u, scale * v, scale * w, X - x, Y - y, Z - z]
