"""Drones that are made up, and handlers without threads, on a clock that stands still."""

import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("cflib")
sys.path.append(str(Path(__file__).parent))
from fake_drone import FakeAir, FakeClock, install


@pytest.fixture
def air():
    made_up = FakeAir()
    take_back = install(made_up)
    yield made_up
    take_back()


@pytest.fixture
def clock():
    return FakeClock()


@pytest.fixture
def fly(air, clock):
    """Make a connected handler of a class, with one drone or more, and close it in the end."""
    handlers = []

    def make(handler_class, count=1, **options):
        chosen = {
            "threaded": False,
            "clock": clock,
            "cache": None,
            "logger": False,
            "reset_estimator": False,
            "on_close": "leave",
        }
        handler = handler_class(air.uris(count), **{**chosen, **options})
        handlers.append(handler)
        handler.connect()
        for drone in air.drones.values():
            drone.packets.clear()
        return handler

    yield make
    for handler in handlers:
        handler.close()


@pytest.fixture
def eventually():
    """Wait until something is true; only to fail is slow."""

    def wait(condition, seconds=20.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "did not come true"
            time.sleep(0.002)

    return wait
