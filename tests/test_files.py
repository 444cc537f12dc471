"""Saving never harms what was there: killed, on a full disk, in a folder that cannot be written."""

import os
import resource
import signal
import stat
import time

import numpy as np
import pytest

import fikm_drake as fd
from fikm_drake.files import whole_file, write_whole
from fikm_drake.fuzzy.integer.write_c import write_c
from fikm_drake.solvers.workplane.integer_fuzzy_ik import IntegerFuzzyIk


def in_child(work):
    """The exit code of a forked process that runs `work`, or minus the signal that ended it."""
    child = os.fork()
    if child == 0:
        try:
            work()
            os._exit(0)
        except OSError as error:
            os._exit(10 if str(error) else 11)
        except BaseException:
            os._exit(12)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def full_disk(bytes_left):
    """From here on no file of this process can grow beyond so many bytes."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_left, bytes_left))


@pytest.fixture(scope="module")
def planar_log():
    return fd.simulate(fd.TrackingScenario("planar2", [[1.5, 0.0], [1.3, 0.4]], hold=0.2))


@pytest.fixture(scope="module")
def learned():
    X = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    anfis = fd.Anfis((3, 3))
    anfis.fit(X, X[:, 0], epochs=1)
    return anfis


@pytest.fixture
def savers(planar_log, learned):
    points = np.random.default_rng(1).uniform(-2, 2, (20, 2))
    data = fd.generate_feasibility_data(fd.load_arm("hassantabar3r"), points)
    rules = IntegerFuzzyIk().rules
    return {
        "log.npz": planar_log.save,
        "log.csv": planar_log.to_csv,
        "page.html": lambda path: fd.write_html(planar_log, path),
        "plot.png": lambda path: fd.plot_log(planar_log, path),
        "anfis.yaml": learned.save,
        "bounds.yaml": fd.LearnedBounds.load("hassantabar3r").save,
        "mamdani.yaml": fd.load_mamdani("labvolt_posture").save,
        "data.npz": data.save,
        "rules.c": lambda path: write_c(rules, path),
    }


def test_every_saver_leaves_the_old_file_whole_on_a_full_disk(savers, tmp_path):
    for name, save in savers.items():
        path = tmp_path / name
        path.write_bytes(b"old " * 50)

        def work(save=save, path=path):
            full_disk(250)
            save(path)

        assert in_child(work) == 10, name  # an OSError with a text
        assert path.read_bytes() == b"old " * 50, name
        assert [p.name for p in tmp_path.iterdir()] == [name]
        path.unlink()


def test_every_saver_names_a_missing_folder(savers, tmp_path):
    for name, save in savers.items():
        with pytest.raises(OSError, match=f"gone.{name}"):
            save(tmp_path / "gone" / name)


def test_a_folder_that_cannot_be_written_is_an_error_that_names_the_file(tmp_path):
    path = tmp_path / "old.txt"
    path.write_text("old")
    os.chmod(tmp_path, 0o555)

    def work():
        if os.geteuid() == 0:
            os.setuid(65534)  # for root every folder can be written
        with pytest.raises(PermissionError, match=str(path)):
            write_whole(path, "new")

    parents = [p for p in tmp_path.parents if not p.stat().st_mode & stat.S_IXOTH]
    if os.geteuid() == 0 and parents:
        for folder in parents:
            os.chmod(folder, folder.stat().st_mode | stat.S_IXOTH)
    try:
        assert in_child(work) == 0
        assert path.read_text() == "old"
    finally:
        os.chmod(tmp_path, 0o755)


@pytest.mark.parametrize("moment", range(4))
def test_kill_while_writing_leaves_the_old_file_or_the_new(moment, tmp_path):
    path = tmp_path / "run.npz"
    old, new = b"o" * 1000, b"n" * 50_000_000
    path.write_bytes(old)
    child = os.fork()
    if child == 0:
        write_whole(path, new)
        os._exit(0)
    time.sleep(0.004 * moment)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    assert path.read_bytes() in (old, new)


def test_an_exception_while_writing_leaves_nothing_behind(tmp_path):
    path = tmp_path / "run.txt"
    for expected in (None, b"old"):
        if expected:
            path.write_bytes(expected)
        with pytest.raises(ZeroDivisionError), whole_file(path) as file:
            file.write(b"half")
            raise ZeroDivisionError
        assert [p.read_bytes() for p in tmp_path.iterdir()] == ([expected] if expected else [])


def test_modes_links_and_what_is_no_file(tmp_path):
    umask = os.umask(0o027)
    try:
        write_whole(tmp_path / "new", "x")
    finally:
        os.umask(umask)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640
    os.chmod(tmp_path / "new", 0o600)
    (tmp_path / "link").symlink_to("new")
    write_whole(tmp_path / "link", "y")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "new").read_text() == "y"
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o600
    write_whole(os.devnull, "z")
    assert not os.path.isfile(os.devnull)
    with pytest.raises(IsADirectoryError, match=tmp_path.name):
        write_whole(tmp_path, "z")
