"""Feasible regions of arms with one spare degree of freedom.

Where may the joints be while the tool stays at its target and every joint within its limits? The
postures {q : f(q) = x} of n joints under n − 1 equations are curves with the tangent J(q) t = 0. For the
planar 3R the region of joint 1 is known in closed form (`feasible_intervals`): it lies between the zeros
of the cosine laws of the other two joints. For any other arm the curves are traced
(`trace_self_motion`): steps along t, Newton back on f(q) = x, exact events where a joint meets a limit,
until the curve closes or ends.

What may enter: geometry of these curves, exact to rounding. Which posture of a curve to take is asked in
`redundancy`.
"""
