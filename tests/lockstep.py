"""Served worlds in lockstep: the test advances the time, so that no flight depends on the speed of the machine."""

import threading
import time

SILENCE_S = 1000.0
"""Pings of cflib go by the wall, sessions in lockstep by simulated time, which is much faster in tests."""


class GoingOn:
    """Time goes on in another thread meanwhile, for calls that wait for a drone."""

    def __init__(self, world):
        self._world = world

    def __enter__(self):
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._ends.is_set():
            self._world.run(0.01)
            time.sleep(0.002)

    def __exit__(self, *_):
        self._ends.set()
        self._thread.join()


def wait_for_odometry(handler, world):
    """Wait a little for the odometry of this instant, which comes by a socket and threads of cflib.

    Not for certain: a server drops logs when it is behind, as a radio does, and this world is in haste.
    """
    end = time.monotonic() + 0.02
    for drone in handler:
        while drone.odometry.time_s < world.time - 0.03 and time.monotonic() < end:
            time.sleep(0.0002)
