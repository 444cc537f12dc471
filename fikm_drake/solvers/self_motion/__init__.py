"""Feasible regions of arms with one spare degree of freedom.

Where the joints may be while the tool stays at its target and every joint within its limits: for the
planar 3R in closed form, for any other arm by tracing the curve of its self-motion.
"""
