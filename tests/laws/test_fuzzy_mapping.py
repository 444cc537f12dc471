"""The fuzzy mapping against equations 19, 27-29 and 32-34 taken literally, and what they imply."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import fikm_drake as fd

INDIRECT = fd.FuzzyMapping()


def equations_32_to_34(J, dr):
    """One element at a time; the zero test is the paper's own."""
    m, n = J.shape
    r = [sum(abs(J[i, j]) for j in range(n)) for i in range(m)]  # equation 27
    c = [sum(abs(J[i, j]) for i in range(m)) for j in range(n)]  # equation 28
    dtheta = np.zeros(n)
    for j in range(n):
        if c[j] != 0.0:
            total = 0.0
            for i in range(m):
                if r[i] != 0.0:
                    total += J[i, j] * dr[i] / r[i]
            dtheta[j] = total / c[j]
    return dtheta


def equations_19_and_29(J, dr, rules_of):
    """Equation 29 with dθ_ij by the truth of every rule (equations 18, 19)."""
    m, n = J.shape
    dtheta = np.zeros(n)
    for j in range(n):
        column = sum(abs(J[i, j]) for i in range(m))
        for i in range(m):
            rules = rules_of(i, j)
            if rules is None:
                continue
            dtheta_ij = 0.0
            for a, row in zip(rules.first.grades(dr[i]), rules.consequents):
                for b, w in zip(rules.second.grades(J[i, j]), row):
                    dtheta_ij += a * b * w
            row_sum = sum(abs(J[i, k]) for k in range(n))
            dtheta[j] += abs(J[i, j]) / row_sum * abs(J[i, j]) * dtheta_ij / column
    return dtheta


def mapping_matrix(J, law=INDIRECT):
    """The matrix M (n,m) of a linear law: dθ = M dr."""
    return np.stack([law(J, unit) for unit in np.eye(len(J))], axis=-1)


elements = st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-3)


@st.composite
def jacobians(draw, elements=elements, most_rows=6, most_columns=9):
    shape = (draw(st.integers(1, most_rows)), draw(st.integers(1, most_columns)))
    return draw(hnp.arrays(float, shape, elements=elements))


@st.composite
def cases(draw):
    J = draw(jacobians())
    return J, draw(hnp.arrays(float, len(J), elements=st.floats(-1.0, 1.0)))


@given(cases())
def test_equations_32_to_34(case):
    J, dr = case
    expected = equations_32_to_34(J, dr)
    np.testing.assert_allclose(INDIRECT(J, dr), expected, rtol=1e-12, atol=1e-12)


@given(cases())
def test_is_one_step_of_sart(case):
    J, dr = case
    rows, columns = np.abs(J).sum(1), np.abs(J).sum(0)
    assume((rows > 0).all() and (columns > 0).all())
    sart = np.diag(1 / columns) @ J.T @ np.diag(1 / rows) @ dr
    np.testing.assert_allclose(INDIRECT(J, dr), sart, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("lead", [(1,), (5,), (2, 3), (0,)])
@pytest.mark.parametrize("shape", [(2, 2), (3, 7), (6, 7), (1, 4), (4, 1)])
def test_a_batch_equals_its_elements(lead, shape):
    rng = np.random.default_rng(len(lead) + 10 * shape[0])
    J, dr = rng.normal(size=lead + shape), 0.1 * rng.normal(size=lead + shape[:1])
    J[..., 0] *= 1e-17 if shape[1] > 1 else 1.0
    batch = INDIRECT(J, dr)
    assert batch.shape == lead + shape[1:]
    for index in np.ndindex(*lead):
        np.testing.assert_allclose(batch[index], INDIRECT(J[index], dr[index]), rtol=1e-12)


def test_one_jacobian_serves_a_batch_of_errors_and_the_reverse():
    rng = np.random.default_rng(0)
    J, dr = rng.normal(size=(3, 7)), rng.normal(size=(20, 3))
    np.testing.assert_allclose(INDIRECT(J, dr), [INDIRECT(J, row) for row in dr], rtol=1e-12)
    J, dr = rng.normal(size=(20, 3, 7)), rng.normal(size=3)
    np.testing.assert_allclose(INDIRECT(J, dr), [INDIRECT(one, dr) for one in J], rtol=1e-12)


@given(cases())
def test_step_is_the_same_as_a_call(case):
    J, dr = case
    batch = INDIRECT(J[None], dr[None])[0]
    np.testing.assert_allclose(INDIRECT.step(J, dr), batch, rtol=1e-12, atol=1e-13)


@given(jacobians())
def test_schur_bound(J):
    """‖R^-½ J C^-½‖ ≤ 1, so J M has its eigenvalues in [0, 1]."""
    eigenvalues = np.linalg.eigvals(J @ mapping_matrix(J))
    assert np.abs(eigenvalues.imag).max() < 1e-6
    assert eigenvalues.real.min() > -1e-9
    assert eigenvalues.real.max() < 1 + 1e-9


@given(cases(), st.floats(0.01, 1.99))
def test_with_a_frozen_jacobian_gains_below_two_never_increase_the_weighted_error(case, gain):
    J, error = case
    rows = np.abs(J).sum(1)
    J, error, rows = J[rows > 0], error[rows > 0], rows[rows > 0]
    assume(len(J))
    size = np.linalg.norm(error / np.sqrt(rows))
    for _ in range(5):
        error = error - J @ INDIRECT(J, gain * error)
        after = np.linalg.norm(error / np.sqrt(rows))
        assert after <= size * (1 + 1e-12) + 1e-15
        size = after


@given(jacobians(st.floats(0.01, 3.0)), st.floats(2.01, 5.0))
def test_a_gain_above_two_can_increase_the_error(J, gain):
    """With J ≥ 0 the row sums are an eigenvector of J M with eigenvalue 1 (Perron)."""
    error = np.abs(J).sum(1)
    after = error - J @ INDIRECT(J, gain * error)
    np.testing.assert_allclose(after, (1 - gain) * error, rtol=1e-9)
    assert np.linalg.norm(after) > np.linalg.norm(error)


@given(cases(), st.floats(1e-3, 1e3))
def test_another_unit_of_length_scales_nothing(case, factor):
    """J and dr in mm in place of m: the same angles. Larger J alone: smaller steps."""
    J, dr = case
    expected = INDIRECT(J, dr)
    np.testing.assert_allclose(INDIRECT(factor * J, factor * dr), expected, rtol=1e-9, atol=1e-12)
    smaller = INDIRECT(factor * J, dr)
    np.testing.assert_allclose(factor * smaller, expected, rtol=1e-9, atol=1e-12)


@given(cases(), st.integers(0, 2**15 - 1))
def test_signs_of_axes_and_joints(case, bits):
    """Turning a task axis round changes nothing; turning a joint's axis round turns its step."""
    J, dr = case
    m, n = J.shape
    signs = np.array([1.0 - 2 * (bits >> k & 1) for k in range(m + n)])
    rows, columns = signs[:m], signs[m:]
    flipped = INDIRECT(rows[:, None] * J * columns, rows * dr)
    np.testing.assert_allclose(flipped, columns * INDIRECT(J, dr), rtol=1e-12, atol=1e-15)


@given(cases(), st.floats(-2.0, 2.0), st.integers(0, 1000))
def test_is_linear_in_the_error(case, factor, seed):
    J, dr = case
    other = np.random.default_rng(seed).normal(size=len(dr))
    combined = INDIRECT(J, dr + factor * other)
    expected = INDIRECT(J, dr) + factor * INDIRECT(J, other)
    np.testing.assert_allclose(combined, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["panda", "puma560", "iiwa14"])
def test_a_joint_whose_axis_meets_the_tool_does_not_move(name):
    """Its column is rounding errors; equation 34's exact test would divide them by their size."""
    arm = fd.load_arm(name)
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (200, arm.num_joints))
    J = arm.jacobian(q)[:, 3:]
    assert np.abs(J[..., -1]).max() < 1e-12
    for law in (INDIRECT, fd.FuzzyMapping("direct", jacobian_range=arm.jacobian_range()[3:])):
        steps = law(J, np.full(3, 0.1))
        assert (steps[:, -1] == 0.0).all()
        assert (np.abs(steps[:, :-1]).max(axis=1) > 0).all()
        assert (np.stack([law.step(one, np.full(3, 0.1)) for one in J])[:, -1] == 0.0).all()


def test_noise_of_one_column_is_not_amplified():
    J = np.array([[0.5, 1e-17], [0.3, -1e-17], [0.1, 1e-17]])
    assert equations_32_to_34(J, np.full(3, 0.1))[1] > 0.05  # what the paper's test lets through
    assert INDIRECT(J, np.full(3, 0.1))[1] == 0.0
    assert fd.FuzzyMapping(zero_threshold=0.0)(J, np.full(3, 0.1))[1] > 0.05


def test_a_small_column_above_the_threshold_still_moves():
    J = np.array([[1.0, 1e-6]])
    np.testing.assert_allclose(INDIRECT(J, [0.1]), equations_32_to_34(J, np.array([0.1])))
    assert INDIRECT(J, [0.1])[1] != 0.0


def test_a_row_of_noise_pushes_nothing():
    """A direction in which no joint can move the tool, as of a planar arm's z."""
    J = np.array([[1.0, 0.5], [1e-17, -1e-17]])
    np.testing.assert_array_equal(INDIRECT(J, [0.0, 0.1]), [0.0, 0.0])
    expected = INDIRECT(J[:1], [0.1])
    np.testing.assert_allclose(INDIRECT(J, [0.1, 0.1]), expected, rtol=1e-12)


@pytest.mark.parametrize("shape", [(1, 1), (3, 7), (4, 3, 7)])
def test_a_zero_jacobian_gives_no_motion(shape):
    J, dr = np.zeros(shape), np.ones(shape[:-1])
    for law in (INDIRECT, fd.FuzzyMapping("direct", jacobian_range=1.0)):
        np.testing.assert_array_equal(law(J, dr), np.zeros(shape[:-2] + shape[-1:]))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["J", "dr"])
def test_what_is_not_finite_is_not_hidden(where, bad):
    """A block can see it: the answer is not finite either."""
    rng = np.random.default_rng(2)
    J, dr = rng.normal(size=(3, 7)), rng.normal(size=3)
    (J[0] if where == "J" else dr)[0] = bad
    with np.errstate(all="ignore"):
        assert not np.isfinite(INDIRECT(J, dr)).all()
        assert not np.isfinite(INDIRECT(J[None], dr[None])).all()


@pytest.fixture(scope="module")
def arm7():
    return fd.load_arm("arm7")


@pytest.fixture(scope="module")
def direct(arm7):
    return fd.FuzzyMapping("direct", jacobian_range=arm7.jacobian_range()[3:])


@pytest.fixture(scope="module")
def samples(arm7):
    rng = np.random.default_rng(3)
    q = rng.uniform(-np.pi, np.pi, (2000, arm7.num_joints))
    return arm7.jacobian(q)[:, 3:], rng.uniform(-0.1, 0.1, (2000, 3))


def test_rule_bases_are_generated_once_for_each_distinct_range(arm7, direct):
    bound = arm7.jacobian_range()[3:]
    distinct = np.unique(np.round(bound[bound > 0], 9))
    assert list(direct.rule_bases) == distinct.tolist()
    assert len(distinct) < bound.size
    for j_max, rules in direct.rule_bases.items():
        assert rules.second.knots[-1] == pytest.approx(j_max)
        assert rules.table_error < 0.0013
    assert INDIRECT.rule_bases == {}


def test_equations_19_and_29(arm7, direct, samples):
    bound = np.round(arm7.jacobian_range()[3:], 9)

    def rules_of(i, j):
        return direct.rule_bases.get(float(bound[i, j]))

    for J, dr in zip(samples[0][:100], samples[1]):
        expected = equations_19_and_29(J, dr, rules_of)
        np.testing.assert_allclose(direct(J, dr), expected, rtol=1e-9, atol=1e-14)


def test_direct_batch_equals_its_elements(direct, samples):
    J, dr = samples[0][:60], samples[1][:60]
    each = [direct(*pair) for pair in zip(J, dr)]
    np.testing.assert_allclose(direct(J, dr), each, rtol=1e-12, atol=1e-15)
    nested = direct(J.reshape(5, 12, 3, 7), dr.reshape(5, 12, 3))
    np.testing.assert_allclose(nested.reshape(60, 7), each, rtol=1e-12, atol=1e-15)
    shared = [direct(J[0], one) for one in dr]
    np.testing.assert_allclose(direct(J[0], dr), shared, rtol=1e-12, atol=1e-15)


def test_direct_and_indirect_agree_inside_the_universe(direct, samples):
    """Section 4: "equivalent"; measured at most .037 and .0006 rad apart, the mean step is .034."""
    J, dr = samples
    exact, fuzzy = INDIRECT(J, dr), direct(J, dr)
    difference = np.abs(fuzzy - exact)
    assert difference.max() < 0.05
    assert difference.mean() < 0.001
    pull = np.einsum("...ij,...j->...i", J, fuzzy)
    assert ((pull * dr).sum(-1) > 0).mean() > 0.99  # it moves towards the target


def test_direct_is_odd_in_the_error_and_linear_inside_its_universe(direct, samples):
    J, dr = samples
    np.testing.assert_allclose(direct(J, -dr), -direct(J, dr), atol=1e-9)
    np.testing.assert_allclose(direct(J, 0.5 * dr), 0.5 * direct(J, dr), atol=1e-9)


def test_direct_holds_the_error_to_its_universe(arm7, samples):
    law = fd.FuzzyMapping("direct", jacobian_range=arm7.jacobian_range()[3:], dr_max=0.05)
    J = samples[0][:50]
    np.testing.assert_allclose(law(J, np.full(3, 9.0)), law(J, np.full(3, 0.05)), atol=1e-12)


def test_one_range_for_all_elements():
    law = fd.FuzzyMapping("direct", jacobian_range=1.5)
    (rules,) = law.rule_bases.values()
    J, dr = np.array([[1.2, -0.4, 0.7]]), np.array([0.06])
    expected = equations_19_and_29(J, dr, lambda i, j: rules)
    np.testing.assert_allclose(law(J, dr), expected, rtol=1e-12)


def test_the_range_of_table_2_is_the_default_and_is_not_left_silently():
    law = fd.FuzzyMapping("direct")
    assert list(law.rule_bases) == [1.5]
    with pytest.raises(ValueError, match="1.6, beyond jacobian_range"):
        law(np.array([[1.6, 0.1]]), np.array([0.05]))


def test_a_joint_measured_past_its_limits_does_not_stop_the_loop():
    """The range of a prismatic joint's arm holds inside its limits only."""
    slider = fd.DhJoint(type="prismatic", a=0.1, alpha=np.pi / 2, lower=0.0, upper=0.2)
    table = fd.DhTable("arm", joints=[fd.DhJoint(), slider], tool=fd.DhTransform(a=0.3))
    plant = fd.MakeDhArmPlant(fd.DhArm(table))
    law = fd.FuzzyMapping("direct")
    config = fd.FuzzyIkConfig(law=law, task="xy", measured_position=True)
    for fused in (False, True):
        config.fused = fused
        controller = fd.MakeFuzzyIkController(plant, config=config)
        context = controller.CreateDefaultContext()
        controller.GetInputPort("desired_position").FixValue(context, [0.2, 0.3])
        step = controller.GetOutputPort("joint_step")
        for angle in np.linspace(-3.0, 3.0, 13):
            controller.GetInputPort("estimated_position").FixValue(context, [angle, 0.25])
            assert np.isfinite(step.Eval(context)).all() and step.Eval(context).any()


@pytest.mark.parametrize("generation", ["least_squares", "araki"])
def test_rule_generation_can_be_chosen(generation):
    law = fd.FuzzyMapping("direct", jacobian_range=1.5, max_error=0.003, generation=generation)
    (rules,) = law.rule_bases.values()
    assert rules.method == generation
    assert rules.error < 0.003


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"method": "fuzzy"}, ["method", "fuzzy", "indirect", "direct"]),
        ({"zero_threshold": -1e-9}, ["zero_threshold", "-1e-09", "[0, 1)"]),
        ({"zero_threshold": 1.0}, ["zero_threshold", "1.0", "[0, 1)"]),
        ({"zero_threshold": np.nan}, ["zero_threshold", "nan", "[0, 1)"]),
        ({"method": "direct", "jacobian_range": [[-1.0]]}, ["jacobian_range", "-1.0", "negative"]),
        ({"method": "direct", "jacobian_range": np.inf}, ["jacobian_range", "inf", "limits"]),
        ({"method": "direct", "jacobian_range": 1.0, "dr_max": 0.0}, ["dr_max", "0.0", "positive"]),
        (
            {"method": "direct", "jacobian_range": 1.0, "max_error": -1.0},
            ["max_error", "-1.0", "positive"],
        ),
        (
            {"method": "direct", "jacobian_range": 1.0, "generation": "guess"},
            ["guess", "araki", "least_squares"],
        ),
    ],
)
def test_errors_name_the_bad_value_and_the_valid_ones(arguments, words):
    with pytest.raises(ValueError) as error:
        fd.FuzzyMapping(**arguments)
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize(
    ("J", "dr"), [((3, 7), (2,)), ((7,), (7,)), ((3, 7), ()), ((5, 3, 7), (5, 4))]
)
@pytest.mark.parametrize("method", ["indirect", "direct"])
def test_shapes_that_do_not_fit_are_named(method, J, dr):
    law = fd.FuzzyMapping(method, jacobian_range=1.0)
    with pytest.raises(ValueError) as error:
        law(np.ones(J), np.ones(dr))
    assert str(J) in str(error.value) and str(dr) in str(error.value)


def test_ranges_of_another_arm_are_named():
    law = fd.FuzzyMapping("direct", jacobian_range=np.ones((3, 6)))
    with pytest.raises(ValueError) as error:
        law(np.ones((3, 7)), np.ones(3))
    assert "(3, 6)" in str(error.value) and "(3, 7)" in str(error.value)
