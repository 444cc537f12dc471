"""A workplane: its coordinates and its file."""

import dataclasses

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed
from pydrake.math import RigidTransform, RotationMatrix

from fikm_drake.resources import model_names
from fikm_drake.solvers.workplane.workplane import Workplane, load_workplane

WORKPLANE = Workplane(origin=[0.3, -0.2, 0.1], yaw=0.7, size=[400, 300])


def test_desk_to_world_is_a_rigid_transform():
    X_WD = RigidTransform(RotationMatrix.MakeZRotation(0.7), [0.3, -0.2, 0.1])
    points = np.random.default_rng(0).uniform(-100, 500, (20, 2))
    expected = [X_WD @ np.array([x / 1000, y / 1000, 0.0]) for x, y in points]
    np.testing.assert_allclose(WORKPLANE.to_world(points), expected, atol=1e-15)
    np.testing.assert_allclose(WORKPLANE.to_world(points[3]), expected[3], atol=1e-15)


def test_world_to_desk_is_its_inverse_with_the_height():
    points = np.random.default_rng(1).uniform(-100, 500, (4, 5, 2))
    raised = WORKPLANE.to_world(points) + [0.0, 0.0, 0.025]
    back = WORKPLANE.from_world(raised)
    np.testing.assert_allclose(back[..., :2], points, atol=1e-10)
    np.testing.assert_allclose(back[..., 2], 25.0, atol=1e-10)


def test_grid_has_401_by_301_points():
    grid = load_workplane("tojo4dof").grid()
    assert grid.shape == (401, 301, 2) and grid.dtype.kind == "i"
    np.testing.assert_array_equal(load_workplane("tojo4dof").grid(100), grid[::100, ::100])
    assert grid[7, 3].tolist() == [7, 3] and grid[-1, -1].tolist() == [400, 300]


@pytest.mark.parametrize("name", model_names("workplanes"))
def test_our_desks_round_trip_through_typed_yaml(name):
    workplane = load_workplane(name)
    assert yaml_load_typed(schema=Workplane, data=yaml_dump_typed(workplane)) == workplane


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"origin": [0.0, 0.0]}, r"\[0.0, 0.0\]"),
        ({"origin": [0.0, np.nan, 0.0]}, "nan"),
        ({"yaw": np.inf}, "yaw.*inf"),
        ({"size": [400]}, r"\[400\]"),
        ({"size": [400, 0]}, r"\[400, 0\]"),
        ({"size": [400.5, 300]}, "400.5"),
    ],
)
def test_bad_desks(change, words):
    with pytest.raises(ValueError, match=words):
        dataclasses.replace(WORKPLANE, **change).validate()


def test_bad_files_are_named(tmp_path):
    path = tmp_path / "workplane.yaml"
    for text in ("size: [400, -3]\n", "sizes: [1, 2]\n", "- 1\n"):
        path.write_text(text)
        with pytest.raises(ValueError, match="workplane.yaml"):
            load_workplane(path)
    with pytest.raises(FileNotFoundError, match="no workplane 'tojo'.*tojo4dof"):
        load_workplane("tojo")
