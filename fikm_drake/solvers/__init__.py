"""Position-level inverse kinematics: from targets to joint positions.

Batch code here is a structure of arrays: the targets are the last, contiguous axis, so that one
numpy call works on one number of every target.
"""
