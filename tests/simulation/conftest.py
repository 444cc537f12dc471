"""Short runs that many tests read."""

import pytest

from fikm_drake import TrackingScenario, simulate


def _short(arm, waypoints, **settings):
    return simulate(TrackingScenario(arm, waypoints, duration=0.3, hold=0.1, **settings))


@pytest.fixture(scope="session")
def planar_log():
    return _short("planar2", [[1.5, 0.0], [1.3, 0.4]])


@pytest.fixture(scope="session")
def spatial_log():
    return _short("arm7", [[0.2, -0.6, 0.6], [0.3, -0.55, 0.5]])


@pytest.fixture(params=["planar", "spatial"])
def any_log(request, planar_log, spatial_log):
    """A copy whose arrays may be written to."""
    log = {"planar": planar_log, "spatial": spatial_log}[request.param]
    return log.replace()
