"""Settings of all tests."""

from hypothesis import settings

settings.register_profile("fikm_drake", derandomize=True, deadline=None)
settings.load_profile("fikm_drake")
