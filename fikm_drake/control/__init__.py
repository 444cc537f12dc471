"""One control cycle as pure functions: what surrounds the law, from the error to the next command.

A cycle k takes the error e_k at q_k and gives q_{k+1}:

    K = gain(e_k, the last dθ),  K_f = K/3 + 2/3 K_f,  d = K_f e_k / 3 + 2/3 d,
    dθ = law(J(q_k), d),  q_{k+1} = q_k + guard(dθ)

With R, C the absolute row and column sums of J the fuzzy law has ‖R^-½ J C^-½‖₂ ≤ 1 (the Schur test), so
the unfiltered loop is stable for 0 < K < 2 and the filtered one for 0 < λK < 10 (`loop_stability`).

What may enter: functions and small dataclasses of numpy arrays and floats. No ports, no Context, no
plant: those are of `systems`, which call what is here; no way from J and e to dθ: that is a law, of
`laws`.
"""
