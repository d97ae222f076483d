"""What leaves for one drone leaves through one thread, so that a drone that does not answer delays no other."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from crazychoir_fw.radio.callbacks import LOGGER

_LONGEST_NAP_S = 1.0
_AFTER_FAILURE_S = 0.1


class Outbox:
    """Does things one after another: what is posted, in order, and what `tick` brings.

    cflib's radio link blocks up to 2 s when its drone is out of reach. With a thread per drone, only that drone waits.
    What fails is logged, and ends nothing: set-points and a stop must leave whatever happened before.

    Args:
        name: Name of the thread.
        tick: Called with the time (s); does what is due and returns when it wants to be called again (s).
        clock: Returns the time (s).
        threaded: False leaves the work to whoever calls `run_once`.
    """

    def __init__(self, name: str, tick: Callable[[float], float], clock: Callable[[], float], threaded: bool) -> None:
        self._tick = tick
        self._clock = clock
        self._posted: deque[Callable[[], None]] = deque()
        self._wakes = threading.Event()
        self._ends = threading.Event()  # of the present thread
        self._last_failure = ""
        self._one_at_a_time = threading.RLock()
        self._name = name
        self._is_threaded = threaded
        self._thread: threading.Thread | None = None

    def begin(self) -> None:
        """Start the thread, where there is to be one; an ended one that is still busy does not count."""
        if self._is_threaded and (self._thread is None or not self._thread.is_alive() or self._ends.is_set()):
            self._ends = threading.Event()
            self._thread = threading.Thread(target=self._run, args=(self._ends,), name=self._name, daemon=True)
            self._thread.start()

    def post(self, *actions: Callable[[], None]) -> None:
        """Have things done soon, in this order, before any set-point; from any thread, whatever locks it holds.

        Without a thread of its own they are done by the next `wake` or `run_once`.
        """
        self._posted.extend(actions)
        self._wakes.set()

    def drop_posted(self) -> None:
        """Forget what was posted and not yet done."""
        self._posted.clear()

    def wake(self) -> None:
        """Have `tick` called soon; without a thread of its own, now: not with a lock that it needs."""
        if self._is_threaded:
            self._wakes.set()
        else:
            self.run_once()

    def run_once(self) -> float:
        """Do what is due, and return when there is more to do (s)."""
        with self._one_at_a_time:
            while True:
                self._do_posted()
                due = self._do_tick()
                if not self._posted:
                    return due

    def _do_tick(self) -> float:
        try:
            return self._tick(self._clock())
        except Exception as error:
            self._report(error)
            return self._clock() + _AFTER_FAILURE_S

    def _do_posted(self) -> None:
        while self._posted:
            try:
                action = self._posted.popleft()
            except IndexError:  # dropped meanwhile
                return
            try:
                action()
            except Exception as error:
                self._report(error)

    def _report(self, error: Exception) -> None:
        """Log what failed, but not the same again and again."""
        text = repr(error)
        if text != self._last_failure:
            self._last_failure = text
            LOGGER.error("%s: not sent: %s", self._name, text, exc_info=error)

    def flush(self, timeout_s: float) -> bool:
        """Wait until everything posted so far is done; False when that took too long."""
        if self._thread is None or not self._thread.is_alive():
            self.run_once()
            return True
        done = threading.Event()
        self.post(done.set)
        return done.wait(timeout_s)

    def end(self) -> None:
        """Do nothing more; a thread of its own ends by itself."""
        self._ends.set()
        self._wakes.set()

    def _run(self, ends: threading.Event) -> None:
        while True:
            due = self.run_once()
            self._wakes.wait(min(max(due - self._clock(), 0.0), _LONGEST_NAP_S))
            if ends.is_set():  # what wakes may be for the next thread
                return
            self._wakes.clear()
