"""Plots and pages of a run."""

import html
import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from pydrake.geometry import Meshcat

import fikm_drake as fd
from fikm_drake import ControllerStatus, plot_log, write_html

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
PNG = b"\x89PNG\r\n\x1a\n"


def test_plot_is_a_png_and_a_figure(any_log, tmp_path):
    figure = plot_log(any_log, tmp_path / "run.png")
    data = (tmp_path / "run.png").read_bytes()
    assert data.startswith(PNG) and len(data) > 20_000
    in_space = any_log.desired.shape[1] == 3
    assert [hasattr(axes, "get_zlim") for axes in figure.axes] == [False, False, False, in_space]
    labels = [axes.get_ylabel() for axes in figure.axes]
    for label, (word, unit) in zip(
        labels, [("error", "[cm]"), ("gain", "[-]"), ("joints", "[rad]"), ("y", "[m]")]
    ):
        assert word in label and unit in label


def test_plot_shows_the_error_of_the_log(planar_log):
    (line,) = plot_log(planar_log).axes[0].lines
    np.testing.assert_array_equal(line.get_xdata(), planar_log.time)
    expected = 100 * np.linalg.norm(planar_log.error_after, axis=1)
    np.testing.assert_allclose(line.get_ydata(), expected)


def test_cycles_that_need_a_look_are_shaded(planar_log):
    status = np.full(len(planar_log.time), int(ControllerStatus.TRACKING))
    plain = planar_log.replace(status=status)
    status = status.copy()
    status[3:6] = status[-2:] = ControllerStatus.LIMITED
    shaded = planar_log.replace(status=status)
    counts = [len(plot_log(log).axes[0].patches) for log in (plain, shaded)]
    assert counts == [0, 2]


def test_a_log_of_one_cycle_can_be_drawn(planar_log, tmp_path):
    log = planar_log.rows(slice(0, 1))
    plot_log(log, tmp_path / "one.png")
    assert (tmp_path / "one.png").read_bytes().startswith(PNG)
    write_html(log, tmp_path / "one.html")


def test_other_formats_and_bad_ones(planar_log, tmp_path):
    plot_log(planar_log, tmp_path / "run.svg")
    assert b"<svg" in (tmp_path / "run.svg").read_bytes()
    with pytest.raises(ValueError, match="xyz"):
        plot_log(planar_log, tmp_path / "run.xyz")
    with pytest.raises(OSError):
        plot_log(planar_log, tmp_path / "gone" / "run.png")


def test_page_is_self_contained_and_plays(any_log, tmp_path):
    path = tmp_path / "run.html"
    write_html(any_log, path)
    page = path.read_text("utf-8")
    assert "<html" in page.lower()
    loaded = re.findall(r"<(?:script|link|img|iframe)\b[^>]*(?:src|href)\s*=\s*[\"']?(\S+)", page)
    assert not [url for url in loaded if not url.startswith("data:")]
    assert "animation" in page
    assert len(page) > 500_000  # Meshcat itself is inside


def test_page_with_a_given_meshcat_that_stays_open(planar_log, tmp_path):
    meshcat = Meshcat()
    write_html(planar_log, tmp_path / "run.html", meshcat=meshcat)
    assert meshcat.HasPath("path/actual")
    assert meshcat.HasPath("path/desired")
    with pytest.raises(OSError):
        write_html(planar_log, tmp_path / "gone" / "run.html", meshcat=meshcat)


def test_page_has_title_curves_and_status_of_the_log(spatial_log, tmp_path):
    write_html(spatial_log, tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text("utf-8")
    assert "<title>arm7, Fuzzy, 50 Hz</title>" in page and str(spatial_log.metrics()) in page
    (text,) = re.findall(r"const run = (\{.*\}), *\n|const run = (\{.*\});", page)
    run = json.loads("".join(text))
    np.testing.assert_allclose(run["time"], spatial_log.time, rtol=1e-5)
    plots = {plot["label"]: plot["series"] for plot in run["plots"]}
    error = 1000 * np.linalg.norm(spatial_log.error_after, axis=1)
    np.testing.assert_allclose(plots["error [mm]"][0], error, rtol=1e-5)
    np.testing.assert_allclose(plots["joints [rad]"], spatial_log.q.T, rtol=1e-5, atol=1e-9)
    names = spatial_log.status_names
    for name, start, end in run["status"]:
        inside = (spatial_log.time >= start) & (spatial_log.time < end)
        assert {names[k] for k in np.flatnonzero(inside)} <= {name}
    assert run["status"][0][1] == 0.0 and run["status"][-1][2] == spatial_log.time[-1]


@pytest.mark.skipif(not BROWSER, reason="no browser is installed")
def test_page_plays_in_a_browser(spatial_log, tmp_path):
    """What the browser makes of it: curves drawn, the clock runs, the status is told."""
    path = tmp_path / "run.html"
    write_html(spatial_log, path)
    probe = (
        "<script>setTimeout(() => { fikmRun.seek(0.2); setTimeout(() => {"
        "const ink = [...document.querySelectorAll('#run-plots canvas')].map(c => {"
        "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        "let n = 0; for (let i = 0; i < d.length; i += 4) n += d[i] < 120; return n; });"
        "document.body.dataset.found = JSON.stringify({ink, clock:"
        "document.getElementById('run-clock').textContent, time: fikmRun.animator.time,"
        "status: document.getElementById('run-status').textContent}); }, 500); }, 1000);</script>"
    )
    page = path.read_text("utf-8")
    path.write_text(page.replace("</html>", probe + "</html>"), "utf-8")
    command = [BROWSER, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage"]
    command += [
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--virtual-time-budget=8000",
    ]
    command += [f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    (found,) = re.findall(r'data-found="([^"]*)"', done.stdout)
    found = json.loads(html.unescape(found))
    assert len(found["ink"]) == 3 and min(found["ink"]) > 100
    assert found["time"] == pytest.approx(0.2, abs=0.02) and found["clock"] == "0.20 s"
    assert found["status"] in {name.lower().replace("_", " ") for name in spatial_log.status_names}


@pytest.mark.parametrize("rows", [slice(5, 9), slice(0, 3), slice(-3, None)])
def test_rows_that_are_not_finite_are_passed_over(rows, spatial_log, tmp_path):
    """Of a robot that flew apart: Drake would end the process for such joints."""
    series = {}
    for name in spatial_log.names:
        series[name] = spatial_log[name].copy()
        series[name][rows] = np.nan
    log = spatial_log.replace(**series, clearance=np.full(len(spatial_log), np.nan))
    write_html(log, tmp_path / "run.html")
    assert "null" in (tmp_path / "run.html").read_text("utf-8")
    plot_log(log, tmp_path / "run.png")
    assert np.isnan(log.metrics().e_max) and np.isnan(log.metrics().clearance)
    assert fd.compare(log, log).same
    nowhere = spatial_log.replace(q=np.full_like(spatial_log.q, np.nan))
    with pytest.raises(ValueError, match="no row with finite joints"):
        write_html(nowhere, tmp_path / "run.html")
