"""Paths: targets one after the other, followed by joints that never leap.

Target k is solved from the posture of target k − 1 by damped Newton steps, with what the task leaves free
turned toward the middle of the limits; targets that lie far apart are reached through targets in
between. A way of the joints that is longer than a stated multiple of the tool's is a leap: then, as where
limits or obstacles end the way, another posture of the target is looked for, and the place is told.

What may enter: functions from a chain and targets to joint positions with a status for every target, and
what gives them times.
"""
