"""Fuzzy systems to look at: memberships, surfaces, and which rules say what at one point.

Every engine here has the same anatomy. Inputs x have memberships with grades μ(x) in [0, 1]; a rule's
strength w_r joins the grades of its premise; it says a conclusion, and the conclusions are made one number:

    Mamdani              a membership, cut off or scaled by w_r; the united memberships are defuzzified
    Sugeno, generated    a number z_r; Σ w_r z_r, w_r a product, Σ w_r = 1
    integer              whole numbers; Σ w_r z_r / Σ w_r with w_r in 0 … 255 (or 255²)
    ANFIS                a linear function of the inputs; Σ w_r z_r(x), w_r a product of shares

`fuzzy_view` gives any of them, and what has `rules` that are one (`GainSupervision`, `FuzzyRateControl`,
`IntegerFuzzyIk`), that common form; the pictures are drawn from it.

What may enter: what explains a rule base. Nothing here is used by an inference.
"""

from fikm_drake.fuzzy.teaching.explanation import Explanation, FuzzyView
from fikm_drake.fuzzy.teaching.fuzzy_view import fuzzy_view
from fikm_drake.fuzzy.teaching.plot_rules import plot_rules
from fikm_drake.fuzzy.teaching.plots import plot_memberships, plot_surface
from fikm_drake.fuzzy.teaching.write_rules_page import write_rules_page

__all__ = [
    "Explanation",
    "FuzzyView",
    "fuzzy_view",
    "plot_memberships",
    "plot_rules",
    "plot_surface",
    "write_rules_page",
]
