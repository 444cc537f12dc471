"""Inverse kinematics of a plane (Tojo & Morishita 2010): a measured table and what answers from it.

`WorkplaneData` are joint positions at grid points of a `Workplane` in whole millimetres;
`WorkplaneInverse` gives them in closed form for the paper's arm, `TiltedPlaneInverse` for a tool held at
an angle; `IntegerFuzzyIk` interpolates between few of them with the integer rules of `fuzzy.integer`, in
integers alone, and writes itself as C.

What may enter: inverses of two coordinates [mm]. The integer arithmetic itself knows no arm and is in
`fuzzy`.
"""
