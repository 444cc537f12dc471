"""Position-level inverse kinematics: from targets to joint positions, outside any control cycle.

A room a question: `batch` (many targets at once), `self_motion` (where may the joints be while the tool
stays), `redundancy` (which posture of those), `labvolt` and `workplane` (the arms of two papers). What
may enter: functions from arrays to arrays with a status for every target. Blocks that call them are in
`systems`.

Batch code here is a structure of arrays: the targets are the last, contiguous axis, so that one numpy
call works on one number of every target.
"""
