"""What all tests share."""

import os

import platformdirs
from hypothesis import settings

# Objects are found by content, so that all runs may share them; but what a user keeps is the user's.
os.environ.setdefault("CRAZYCHOIR_CACHE", platformdirs.user_cache_dir("crazychoir_fw_tests"))

# The gate tries the same cases every time, so that it fails for a change and never by luck; and no test may fail
# because a machine is slow. `HYPOTHESIS_PROFILE=explore pytest` looks for new cases, ten times as many.
settings.register_profile("gate", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gate"))
