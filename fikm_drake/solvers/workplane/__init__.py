"""Paper 5: a workplane before an arm, joint positions measured or computed there, and rules made of them.

O. Tojo and T. Morishita, "Inverse Kinematics Algorithm based on Fuzzy Control Model", 2010. A point (x, y)
of the workplane [mm] lies in a cell between two labels of x and two of y. With grades up to 255 of
integer triangles,

    w_ij = min(μ_i(x), μ_j(y))   or   μ_i(x) μ_j(y) / 255,   θ_k = Σ w_ij s_ijk / Σ w_ij

(equation 5), s_ijk the singleton of joint k in whole steps of 0.01°. The singletons are inverse
kinematics at the peaks, of any arm by `WorkplaneInverse`, of an arm whose first joint tilts the plane
of the other three in closed form (`TiltedPlaneInverse`): with the point ahead f, to the left l and up u
of the shoulder, pitch = atan2(f, −u), and in the tilted plane the wrist at (hypot(f, u) − c cos h,
l − c sin h) for a heading h of the hand, which two links reach by the law of cosines. `WorkplaneData`
takes what was measured of a person or a taught arm instead; where the points are no grid of the peaks
the singletons are fitted by least squares (`fuzzy.integer.fit_singletons`).

With `min` the error falls as the cells' width h, with `product`, bilinear interpolation, as h².

What may enter: inverses of two coordinates [mm]; the integer arithmetic knows no arm and is in
`fuzzy.integer`.
"""
