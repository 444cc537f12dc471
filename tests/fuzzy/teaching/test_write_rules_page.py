"""The page with sliders: its numbers are the engine's, and its script runs."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.fuzzy.teaching import fuzzy_view, write_rules_page

DOM = """
class Node { constructor() { this.kids = []; this.style = {}; this.innerHTML = ""; }
  append(kid) { this.kids.push(kid); kid.parentNode = this; }
  getContext() { return {fillRect() {}}; }
  getBoundingClientRect() { return {left: 0, top: 0, width: 100, height: 100}; } }
const ids = {};
globalThis.document = {createElement: () => new Node(),
  getElementById: id => ids[id] || (ids[id] = new Node())};
"""
CHECK = """
const slider = data.inputs[0].slider; slider.value = 1; slider.oninput();
if (map) map.onclick({clientX: 70, clientY: 30});
console.log(JSON.stringify({at: data.inputs.map(v => +v.text.textContent.split("= ")[1]),
  outputs: ids.outputs.innerHTML, strengths: rows.map(r => +r.strength.textContent),
  drawing: ids.drawing ? ids.drawing.innerHTML : ""}));
"""


def page_data(path):
    text = path.read_text("utf-8")
    assert text.startswith("<!doctype html>") and "http" not in text  # needs no network
    return json.loads(re.search(r"^const data = (.*);$", text, flags=re.M).group(1))


def test_numbers_are_the_engine_s(tmp_path):
    system = fd.load_mamdani("labvolt_theta3")
    write_rules_page(system, tmp_path / "page.html", title="θ3 & more", steps=5)
    data = page_data(tmp_path / "page.html")
    assert "θ3 &amp; more" in (tmp_path / "page.html").read_text("utf-8")
    a, b = (np.array(variable["values"]) for variable in data["inputs"])
    for k, (x, y) in enumerate((x, y) for x in a for y in b):
        values, fired = system([x, y])
        expected = pytest.approx(values[0], rel=1e-5) if fired[0] else None
        assert data["values"][k][0] == expected
        strengths = np.zeros(9)
        for rule, strength in data["strengths"][k]:
            strengths[rule] = strength
        np.testing.assert_allclose(strengths, system.strengths([x, y]), atol=1e-4)


def test_the_arm_is_the_arm_of_the_outputs(tmp_path):
    ik, arm = fd.IntegerFuzzyIk(), fd.load_arm("tojo4dof")
    draw = fd.arm_drawing(arm, lambda points, angles: ik.to_radians(angles), view="xz")
    write_rules_page(ik, tmp_path / "page.html", drawing=draw, caption="an arm", steps=3)
    data = page_data(tmp_path / "page.html")
    q = ik.to_radians(ik.solve(0, 0)[0])
    tool = arm.forward_kinematics(q)[:3, 3]
    drawn = np.array(data["drawing"]["lines"][0])
    assert drawn.shape == (arm.num_joints + 2, 2)
    np.testing.assert_allclose(drawn[0], 0.0)
    np.testing.assert_allclose(drawn[-1], tool[[0, 2]], atol=1e-4)


@pytest.mark.skipif(not shutil.which("node"), reason="no node")
@pytest.mark.parametrize("inputs", [1, 2, 3])
def test_the_script_follows_sliders_and_clicks(tmp_path, inputs):
    X = np.random.default_rng(0).uniform(-1.0, 1.0, (40, inputs))
    system = fd.Anfis((2,) * inputs).fit(X, X.sum(axis=1), epochs=1)
    lines = lambda points, values: np.concatenate([points[:, :1], values], axis=1)[:, None]  # noqa: E731
    write_rules_page(system, tmp_path / "page.html", steps=5, drawing=lines)
    script = (tmp_path / "page.html").read_text("utf-8").split("<script>")[1].split("</script>")[0]
    run = subprocess.run(
        ["node", "-e", DOM + script + CHECK], capture_output=True, text=True, check=True
    )
    shown = json.loads(run.stdout)
    told = fuzzy_view(system).explain(shown["at"])
    value = float(re.search(r">(-?[\d.e-]+)<", shown["outputs"]).group(1))
    assert value == pytest.approx(told.value, abs=1e-4)
    np.testing.assert_allclose(shown["strengths"], [r.strength for r in told.rules], atol=2e-3)
    assert "<polyline" in shown["drawing"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"steps": 1}, "steps must be an integer of at least 2, got 1"),
        ({"drawing": lambda points, values: points}, r"drawing must give corners \(N, p, 2\)"),
        (
            {"drawing": lambda points, values: np.full((len(points), 3, 2), np.nan)},
            "drawing must give a finite line somewhere",
        ),
    ],
)
def test_bad_options_are_named(tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        write_rules_page(fd.FuzzyRateControl(), tmp_path / "page.html", **{"steps": 3, **options})
    assert not list(tmp_path.iterdir())


def test_four_inputs_are_too_many_and_views_are_named(tmp_path):
    X = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 4))
    with pytest.raises(ValueError, match="at most 3 inputs, got 4"):
        write_rules_page(fd.Anfis((1,) * 4).fit(X, X[:, 0], epochs=1), tmp_path / "page.html")
    with pytest.raises(ValueError, match="view must be one of"):
        fd.arm_drawing(fd.load_arm("planar2"), view="front")
