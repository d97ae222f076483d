"""What leaves for one drone: packets that go once, in order, and set-points that are repeated."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.link import DroneLink
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.outbox import Outbox
from crazychoir_fw.radio.set_points import SetPointStream

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
        """Send nothing of what was asked for and has not left."""
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
