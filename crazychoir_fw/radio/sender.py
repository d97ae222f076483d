"""What leaves for one drone: packets that go once, in order, and set-points that are repeated."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.link import DroneLink
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.threads import LOGGER

_INFINITE = math.inf


class SetPointStream:
    """Holds the last set-point of a drone, and says when it is to be sent and how long.

    A new set-point goes out at once, unless the last one went out less than a shortest gap ago: then the newest of
    those that came meanwhile goes out at the end of the gap. A set-point that is not replaced is repeated, because a
    drone levels out when its set-point is 0.5 s old and locks itself after 2 s; when it is older than the time-out, it
    is no longer sent.

    Args:
        keep_alive_hz: Repetitions per second.
        max_rate_hz: Set-points per second at most.
        timeout_s: Max age of a set-point that is still repeated (s).
    """

    def __init__(self, keep_alive_hz: float, max_rate_hz: float, timeout_s: float) -> None:
        self._repeat_s = 1.0 / keep_alive_hz
        self._gap_s = 1.0 / max_rate_hz
        self._timeout_s = timeout_s
        self._send: Callable[[], None] | None = None
        self._is_new = False
        self._until = _INFINITE
        self._last_sent = -_INFINITE

    def give(self, send: Callable[[], None], now: float, timeout_s: float | None = None) -> None:
        """Replace the set-point.

        Args:
            send: Sends it.
            now: Time (s).
            timeout_s: How long it is repeated (s), in place of the usual time-out.
        """
        self._send, self._is_new = send, True
        self._until = now + (self._timeout_s if timeout_s is None else timeout_s)

    def clear(self) -> None:
        """Send nothing more."""
        self._send, self._is_new, self._until = None, False, _INFINITE

    def is_stale(self, now: float) -> bool:
        """Return whether the set-point has been sent and is too old to be repeated."""
        return self._send is not None and not self._is_new and now >= self._until

    def due(self) -> float:
        """Return when there is something to do next (s)."""
        if self._send is None:
            return _INFINITE
        if self._is_new:
            return self._last_sent + self._gap_s
        return min(self._last_sent + self._repeat_s, self._until)

    def take(self, now: float) -> Callable[[], None] | None:
        """Return what is to be sent now, if anything; it then counts as sent."""
        if self._send is None or self.is_stale(now) or now < self.due() - 1e-9:
            return None
        self._last_sent, self._is_new = now, False
        return self._send


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
        threaded: False leaves the work to calls of `run_once`.
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


Send = Callable[[LinkedCrazyflie], None]
"""Sends packets through cflib's object of the present connection."""


class Sender:
    """The way from a handler to its drone. Without a connection, what is to be sent now is gone.

    Args:
        agent_id: Name of the agent, for that of the thread.
        link: Its link.
        options: Rates, time-out, clock, thread.
        tick: Called with the time (s) between what is posted; sends what is due and returns when it wants to be called
            again (s).
    """

    def __init__(self, agent_id: str, link: DroneLink, options: Options, tick: Callable[[float], float]) -> None:
        self._link = link
        timeout = math.inf if options.on_silence == "repeat" else options.command_timeout_s
        self.lock = threading.RLock()
        """Of the stream, and of what decides about it."""
        self.stream = SetPointStream(options.keep_alive_hz, options.max_rate_hz, timeout)
        self.outbox = Outbox(f"radio-{agent_id}", tick, options.clock, options.threaded)
        self.has_streamed = False
        """Whether our set-points hold the commander on board, so that the planner there is not heard."""

    @property
    def is_connected(self) -> bool:
        """Whether packets reach the drone, as far as is known."""
        return self._link.is_connected

    def send(self, send: Send) -> None:
        """Send at once, in the thread of the caller."""
        cf = self._link.cf
        if cf is not None:
            send(cf)

    def post(self, *sends: Send) -> None:
        """Have packets sent soon, in this order, before any set-point; see `Outbox.post`."""
        self.outbox.post(*((lambda send=send: self.send(send)) for send in sends))

    def repeat(self, send: Send, now: float, timeout_s: float | None = None) -> None:
        """Replace the set-point that is repeated; see `SetPointStream.give`."""
        self.stream.give(lambda: self._send_set_point(send), now, timeout_s)

    def _send_set_point(self, send: Send) -> None:
        self.has_streamed = True
        self.send(send)

    def take_set_point(self, now: float) -> Callable[[], None] | None:
        """Return what sends the set-point, if it is due and the drone is connected."""
        return self.stream.take(now) if self.is_connected else None

    def next_set_point(self) -> float:
        """Return when the next set-point is due (s)."""
        return self.stream.due() if self.is_connected else math.inf

    def forget(self) -> None:
        """Drop the commands that are queued."""
        self.outbox.drop_posted()
        self.stream.clear()

    def release(self, cf: LinkedCrazyflie) -> None:
        """Tell the drone that set-points have ended, so that it listens to its planner."""
        self.has_streamed = False
        cf.commander.send_notify_setpoint_stop()

    def release_if_streamed(self, cf: LinkedCrazyflie) -> None:
        """The same where it matters."""
        if self.has_streamed:
            self.release(cf)
