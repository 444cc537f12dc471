"""What the schema knows, each kind as somebody new would write it: YAML, run, log, tables, comparison."""

import csv

import numpy as np
import pytest

import fikm_drake as fd

IIWA = "initial_position: [0, 0.6, 0, -1.5, 0, 1, 0]\n"
PLANAR = "robot: planar4\ninitial_position: [0.4, -0.4, -0.6, 0.5]\n"
LINE = "target: {positions: [[1.2, 0.4], [1.1, 0.5]], duration: 0.2, hold: 0.1}\n"
SHORT = "target: {positions: [[0.5, 0.0, 0.5], [0.5, 0.05, 0.5]], duration: 0.2, hold: 0.1}\n"
KINDS = {
    "arm by name": "robot: ur5\n" + SHORT,
    "DH table": "robot: mine.yaml\ntarget: {positions: [[0.5, 0.1, 0.5]], hold: 0.2}\n",
    "URDF": "robot: mine.urdf\n" + SHORT,
    "directives": "robot: {file: world.dmd.yaml, frame: arm::tool}\n" + SHORT + IIWA,
    "frmrc": "controller: frmrc\n" + PLANAR + LINE,
    "supervised": "robot: iiwa14\ncontroller: supervised_drake\ntarget: {poses: "
    "[{xyz: [0.5, 0, 0.5], rpy: [0, 3, 0]}], hold: 0.2}\n",
    "labvolt": "robot: labvolt5250\ncontroller: labvolt\ntarget: {positions: [[0.3, 0, 0.2]], hold: 0.2}\n",
    "redundancy": "robot: hassantabar3r\ncontroller: redundancy\n"
    "target: {positions: [[1, 2], [1, 2.1]], duration: 0.2}\n",
    "integer": "robot: tojo4dof\ncontroller: integer\n"
    "target: {positions: [[0.3, 0.0, -0.155]], hold: 0.2}\n",
    "axes": PLANAR + LINE,
    "quaternions": "robot: panda\ntarget: {poses: [{xyz: [0.4, 0, 0.5], quaternion: [0, 1, 0, 0]}], "
    "hold: 0.2}\n",
    "spline": "robot: iiwa14\ntarget: {positions: [[0.5, 0, 0.5], [0.5, 0.1, 0.5], [0.4, 0.1, 0.5]], "
    "shape: spline, profile: cubic, duration: 0.3}\n" + IIWA,
    "circle": "robot: iiwa14\ntarget: !Circle {center: [0.5, 0, 0.5], radius: 0.05, duration: 0.3}\n"
    + IIWA,
    "step": PLANAR + "target: {positions: [[1.0, 0.6]], hold: 0.3}\n",
    "csv": "robot: iiwa14\ntarget: !Csv {file: path.csv}\n" + IIWA,
    "samples": "robot: iiwa14\ntarget: !Samples {times: [0, 0.1], values: [[0.5, 0, 0.5], [0.5, 0.1, 0.5]], "
    "interpolation: hold, hold: 0.2}\n" + IIWA,
    "torques": "robot: iiwa14\nplant: torque_driven\n" + SHORT + IIWA,
    "servos": "robot: iiwa14\nplant: !Servos {stiffness: 2000}\n" + SHORT + IIWA,
    "driver": "robot: iiwa14\nplant: sim_iiwa\n" + SHORT + IIWA,
    "sensor": PLANAR + LINE + "controller: {config: {measured_position: true}}\n"
    "sensor: {noise: 0.001, delay: 0.02, rate: 100}\nseed: 7\n",
    "sensor with torques": "robot: iiwa14\nplant: torque_driven\nsensor: {noise: 0.0001, delay: 0.002}\n"
    "seed: 7\n" + SHORT + IIWA,
    "obstacles": "robot: iiwa14\nobstacles: [{xyz: [0.5, 0.2, 0.5], box: [0.1, 0.1, 0.1]}]\n"
    "clearance: {safe_distance: 0.02}\n" + SHORT + IIWA,
} | {
    law: PLANAR + LINE + f"controller: {{config: {{law: !{law} {{}}}}}}\n"
    for law in (
        "FuzzyMapping",
        "DampedLeastSquares",
        "PseudoInverse",
        "JacobianTranspose",
        "FuzzyRateControl",
    )
}
TABLE = """\
name: mine
convention: craig
joints:
- {d: 0.3, lower: -3, upper: 3}
- {alpha: 1.5708, lower: -2, upper: 2}
- {a: 0.4, lower: -2.5, upper: 2.5}
tool: {a: 0.3}
"""
WORLD = """\
directives:
- add_model: {name: arm, file: package://fikm_drake/iiwa14.urdf}
- add_weld: {parent: world, child: arm::base}
"""


@pytest.mark.parametrize("kind", KINDS)
def test_from_yaml_to_a_log_that_loads_and_converts(kind, tmp_path):
    (tmp_path / "mine.yaml").write_text(TABLE)
    (tmp_path / "mine.urdf").write_text(fd.load_arm("ur5").to_urdf())
    (tmp_path / "world.dmd.yaml").write_text(WORLD)
    (tmp_path / "path.csv").write_text("time_s,x_m,y_m,z_m\n0,0.5,0,0.5\n0.2,0.5,0.1,0.5\n")
    (tmp_path / "run.yaml").write_text(KINDS[kind])
    scenario = fd.load_scenario(tmp_path / "run.yaml")
    log = fd.simulate(scenario)
    assert len(log) == scenario.num_cycles + 1 and np.isfinite(log.q).all()
    np.testing.assert_array_equal(log.q[0], scenario.start())
    log.save(tmp_path / "run.npz")
    again = fd.RunLog.load(tmp_path / "run.npz")
    assert fd.compare(log, again).same
    assert again.scenario.num_cycles == scenario.num_cycles
    log.to_csv(tmp_path / "run.csv")
    with open(tmp_path / "run.csv", newline="") as file:
        header, *rows = csv.reader(file)
    assert len(rows) == len(log) and header[0] == "time_s"
    # Run again from what the log keeps, without the files beside the scenario.
    if kind not in ("URDF", "directives"):  # a model stays a path
        for file in ("mine.yaml", "path.csv"):
            (tmp_path / file).unlink()
    found = fd.compare(log, fd.simulate(again.scenario))
    assert found.rows == len(log) and max(found.largest.values()) < 1e-9
    pandas = pytest.importorskip("pandas")
    frame = log.to_dataframe()
    assert list(frame.columns) == header[1:]
    read = pandas.read_csv(tmp_path / "run.csv", index_col="time_s")
    columns = [name for name in header[1:] if not name.endswith("_name")]
    np.testing.assert_array_equal(read[columns].to_numpy(), frame[columns].to_numpy())
