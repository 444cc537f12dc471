"""Random arms, tasks, laws, configs, targets and noise: what must hold whatever comes in.

A case is made from two numbers, the seed and the case's index, and can be run again alone. What must
hold is said in `violations`; it is checked against the plant, not against the code that is tested. A
config that a constructor refuses with a ValueError is no violation, it is counted. What enters: the
public blocks and factories.
"""
