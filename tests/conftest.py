"""What all tests share."""

import fcntl
import gc
import hashlib
import os
import signal
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

TESTS = Path(__file__).resolve().parent
if core := os.environ.get("CRAZYCHOIR_CORE"):  # the build of CMakeLists.txt, with sanitizers, instead of the usual one
    sys.modules["crazychoir_fw._core"] = module_from_spec(spec_from_file_location("crazychoir_fw._core", core))
    if "PYTEST_XDIST_WORKER" in os.environ:
        os.environ.pop("LD_PRELOAD", None)  # compilers that tests call need no sanitizer
sys.path.append(str(TESTS / "firmware"))  # for the miniature checkout
from miniature import lay_out  # noqa: E402

from crazychoir_fw.firmware.build import build_provider  # noqa: E402

# The gate tries the same cases every time, so that it fails for a change and never by luck; and no test may fail
# because a machine is slow. `HYPOTHESIS_PROFILE=explore pytest` looks for new cases, twenty times as many.
settings.register_profile("gate", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gate"))

# Hypothesis also tries the constants of whatever modules are imported, and that differs with what a worker of
# pytest-xdist ran before: only to explore.
if settings.get_current_profile_name() == "gate" and hasattr(providers, "_get_local_constants"):
    NO_CONSTANTS = providers.Constants()
    providers._get_local_constants = lambda: NO_CONSTANTS


def pytest_configure(config):
    """Keep what is compiled for the next run, and apart from what a user keeps; hear of SIGINT."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        # inherited from a shell that runs the tests in the background; what the tests start is ended by this signal
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if config.pluginmanager.hasplugin("cacheprovider"):
        os.environ.setdefault("CRAZYCHOIR_CACHE", str(config.cache.mkdir("firmware") / "cache"))


def pytest_collection_modifyitems(items):
    """Mark tests of files that take long: `pytest -m "not slow"` is for in between. Several workers begin with them."""
    slow = {TESTS / name for name in (TESTS / "slow.txt").read_text().split()}
    for item in items:
        if item.path in slow:
            item.add_marker(pytest.mark.slow)
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: item.path not in slow)
    missing = [path.name for path in slow if not path.is_file()]
    if missing:
        raise pytest.UsageError(f"tests/slow.txt names files that are not there: {', '.join(missing)}")


def pytest_collection():
    """Collect tests without collecting garbage."""
    gc.disable()


def pytest_collection_finish():
    """Leave out of later collections of garbage what the session keeps anyway.

    Among ten thousand tests a full one takes seconds, for which drones that fly in real time hear nothing.
    """
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def lasting_folder(request):
    """A folder that outlives the session, for what is named by its content."""
    return request.config.cache.mkdir("firmware")


@pytest.fixture(scope="session")
def lasting_cache(lasting_folder):
    """A cache that outlives the session: what has not changed is not compiled again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CRAZYCHOIR_CACHE", str(lasting_folder / "cache"))
        # a session builds more than a user keeps, and what it made an hour ago is still asked for
        patch.setattr("crazychoir_fw.firmware.cache._KEPT_LIBRARIES", 200)
        patch.setattr("crazychoir_fw.firmware.cache._KEPT_OBJECTS", 4000)
        yield lasting_folder / "cache"


@pytest.fixture(scope="session")
def miniature(lasting_folder):
    """The miniature checkout of the newest release, a repository, laid out once. Not to be written to."""
    parts = [path for path in sorted((TESTS / "firmware" / "miniature").rglob("*")) if path.is_file()]
    # some files of the miniature are made from ours
    parts += sorted((TESTS.parent / "bindings").rglob("*.[ch]"))
    name = hashlib.sha256(b"".join(path.read_bytes() for path in parts if path.suffix != ".pyc")).hexdigest()[:12]
    root = lasting_folder / f"checkout {name}"
    with (lasting_folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (root / "laid out").exists():
            lay_out(root, git=True)
            (root / "laid out").touch()
    return root


@pytest.fixture(scope="session")
def bitcraze_library(miniature, lasting_cache):
    """The library of the miniature checkout for cf2."""
    return build_provider(miniature, "cf2")


@pytest.fixture
def hop():
    """A mission as its file holds it: two drones take off, wait and land."""
    return {
        "name": "hop",
        "drones": [{"id": "cf1", "position": [0, 0]}, {"id": "cf2", "position": [1, 0]}],
        "flight": [
            {"takeoff": {"height": 1.0, "duration": 2.0}},
            {"hover": {"duration": 3.0}},
            {"land": {"duration": 2.0}},
        ],
    }
