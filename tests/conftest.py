"""What all tests share."""

import os

from hypothesis import settings

# The gate tries the same cases every time, so that it fails for a change and never by luck; and no test may fail
# because a machine is slow. `HYPOTHESIS_PROFILE=explore pytest` looks for new cases, ten times as many.
settings.register_profile("gate", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gate"))


def pytest_configure(config):
    """Keep what is compiled for the next run, and apart from what a user keeps."""
    if config.pluginmanager.hasplugin("cacheprovider"):
        os.environ.setdefault("CRAZYCHOIR_CACHE", str(config.cache.mkdir("firmware") / "cache"))
