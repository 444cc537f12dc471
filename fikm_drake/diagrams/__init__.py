"""Factories that wire blocks: `Make…` builds a Diagram, `Add…(builder, …)` adds and returns it.

No arithmetic of their own. The fuzzy IK controller (Xu & Nechyba 1993, figure 1):

    desired ─▶ TaskError ─▶ VariableGain ─▶ LowPassFilter ─▶ DifferentialIk ─▶ JointIntegrator ─▶ command
                ▲    │           ▲                                ▲                  │
                │    ▼           │                                │                  │
                │  GainSupervisor ─▶ LowPassFilter                └──── position ────┤
                └──────────────────────────── position ──────────────────────────────┘

`RestartPlanner` stands before JointIntegrator where it is asked for, `StatusMonitor` looks on.
In tick k, with joints q_k, gain K and smoothings of 2/3,

    e_k = task error at q_k;  K from |e_k| and the last steps;  K'_k = K/3 + 2/3 K'_{k-1}
    d_k = K'_k e_k / 3 + 2/3 d_{k-1};  dθ_k = law(J(q_k), d_k);  q_{k+1} = q_k + dθ_k

which `control.cycle` tells as one function; `FusedFuzzyIk` runs that, and the two agree.
"""
