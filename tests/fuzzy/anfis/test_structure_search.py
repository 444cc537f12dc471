"""Structures of an ANFIS compared on held-out data."""

import numpy as np
import pytest

from fikm_drake import Anfis, cli
from fikm_drake.fuzzy.anfis.structure_search import search_structures, split_rows


@pytest.fixture(scope="module")
def table():
    X = np.random.default_rng(0).uniform(-1.0, 1.0, (400, 2))
    return X, np.sin(3.0 * X[:, 0]) * X[:, 1]


def test_split_is_of_all_rows_once_and_by_the_seed(table):
    parts = list(split_rows(*table, seed=3))
    assert [len(y) for _, y in parts] == [240, 80, 80]
    rows = np.concatenate([np.column_stack(part) for part in parts])
    whole = np.column_stack(table)
    np.testing.assert_array_equal(rows[np.lexsort(rows.T)], whole[np.lexsort(whole.T)])
    np.testing.assert_array_equal(parts[0][0], next(split_rows(*table, seed=3))[0])
    assert not np.array_equal(parts[0][0], next(split_rows(*table, seed=4))[0])
    with pytest.raises(ValueError, match="shares"):
        list(split_rows(*table, shares=(0.6, 0.5)))


def test_the_best_by_validation_comes_first_and_held_out_only_tells(table):
    data, validation, held_out = split_rows(*table)
    found = search_structures(
        data, validation, held_out, memberships=(2, 4), orders=(0, 1), epochs=4
    )
    assert len(found) == 8
    errors = [s.validation for s in found]
    assert errors == sorted(errors) and str(found[0]).startswith("4 x 4")
    for s in found:
        off = s.anfis.predict(held_out[0]) - held_out[1]
        assert s.held_out == pytest.approx(np.sqrt(np.mean(off**2)))
        assert s.held_out_largest == pytest.approx(np.abs(off).max())
    other = search_structures(data, validation, memberships=(2, 4), orders=(0, 1), epochs=4)
    assert [str(s) for s in other] == [str(s) for s in found]
    assert np.isnan(other[0].held_out)
    gaussian = next(s for s in found if str(s) == "4 x 4 gaussian, order 1")
    assert gaussian.numbers == 16 * 3 + 8 * 2


def test_bad_grids_are_refused(table):
    data, validation, _ = split_rows(*table)
    with pytest.raises(ValueError, match="at least one"):
        search_structures(data, validation, memberships=())
    with pytest.raises(ValueError, match="kind"):
        search_structures(data, validation, memberships=(2,), kinds=("cubic",))


def test_command_compares_and_writes_the_best(table, tmp_path, capsys):
    path, out = tmp_path / "data.csv", tmp_path / "best.yaml"
    np.savetxt(path, np.column_stack(table), delimiter=",", header="x,y,z", comments="")
    command = ["train", "structures", str(path), "--memberships", "2", "3", "--epochs", "2"]
    assert cli.main([*command, "--kinds", "gaussian", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "240 rows learned, 80 chose, 80 held out" in text
    assert text.count("gaussian, order") == 5  # and the one that is written
    assert Anfis.load(out).kind == "gaussian"
    path.write_text("a,b\n1,x\n", encoding="utf-8")
    assert cli.main(command) == 2
    assert "data.csv" in capsys.readouterr().err
