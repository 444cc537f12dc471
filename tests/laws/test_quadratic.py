"""What a law minimises: without bounds its minimum is the law's step."""

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.laws.quadratic import quadratic_of

LAWS = [
    fd.FuzzyMapping(),
    fd.FuzzyMapping(row_floor=0.1, column_floor=0.2),
    fd.FuzzyMapping.iterated(),
    fd.FuzzyMapping(iterations=6, damping=0.02, row_floor=1.0, column_floor=0.1),
    fd.DampedLeastSquares(0.1),
]


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("shape", [(3, 7), (6, 6), (6, 8), (2, 4)])
@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_its_minimum_is_the_step(law, shape, damping):
    rng = np.random.default_rng(3)
    minimises = quadratic_of(law, shape[0])
    more = (damping,) if getattr(law, "takes_damping", False) else ()
    for _ in range(20):
        J, dr = rng.normal(size=shape), 0.1 * rng.normal(size=shape[0])
        J[:, 0] *= rng.choice([0.0, 1.0])  # a joint that moves nothing
        H, g, columns = minimises(J, dr, *(more or (0.0,)))
        np.testing.assert_allclose(
            np.linalg.solve(H, g), law.step(J, dr, *more), rtol=1e-6, atol=1e-9
        )
        assert (np.linalg.eigvalsh(H) > 0.0).all() and (columns > 0.0).all()


@pytest.mark.parametrize(
    "law", [fd.DampedLeastSquares(1e200), fd.FuzzyMapping(iterations=6, damping=1e300)], ids=str
)
@pytest.mark.filterwarnings("ignore:invalid value")  # infinite times zero
@pytest.mark.parametrize("retreat", [0.0, 0.06])
def test_damping_whose_square_is_no_number_holds_the_arm(law, retreat):
    plant = fd.MakeDhArmPlant(fd.load_arm("arm7"))
    for fused in (False, True):
        config = fd.FuzzyIkConfig(
            law=law, limit_retreat=retreat, singularity_nudge=0.0, fused=fused
        )
        controller = fd.MakeFuzzyIkController(plant, config=config)
        context = controller.CreateDefaultContext()
        controller.GetInputPort("desired_position").FixValue(context, [0.5, 0.5, 0.2])
        assert not controller.GetOutputPort("joint_step").Eval(context).any()
    J, dr = np.ones((3, 7)), np.full(3, 0.1)
    assert not law.step(J, dr).any() and not law(J, dr).any()


@pytest.mark.parametrize(
    "law",
    [
        fd.FuzzyMapping(iterations=3),
        fd.FuzzyMapping("direct"),
        fd.PseudoInverse(),
        lambda J, dr: dr,
    ],
)
def test_others_are_not_known(law):
    assert quadratic_of(law, 6) is None


def test_a_jacobian_of_zeros_moves_nothing():
    for law in LAWS:
        H, g, _ = quadratic_of(law, 3)(np.zeros((3, 7)), np.ones(3), 0.0)
        assert not g.any() and np.isfinite(H).all()
