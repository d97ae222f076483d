"""Keeps a watched flight at the pace of the clock on the wall."""

import time


class FramePacer:
    """Real time for one flight, from the first question on.

    Args:
        frame_s: Simulated time between two pictures (s).
    """

    def __init__(self, frame_s: float) -> None:
        self._frame_s = frame_s
        self._next_frame = -1.0
        self._start: float | None = None

    def is_frame(self, sim_seconds: float) -> bool:
        """Return whether a picture is due."""
        if sim_seconds < self._next_frame:
            return False
        self._next_frame = sim_seconds + self._frame_s - 1e-9
        return True

    def wait(self, sim_seconds: float) -> None:
        """Let simulated time wait for the clock on the wall: here alone it does."""
        if self._start is None:
            self._start = time.perf_counter() - sim_seconds
        time.sleep(max(0.0, sim_seconds - (time.perf_counter() - self._start)))
