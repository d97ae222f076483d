"""Work at a rate on the clock of ROS."""

from __future__ import annotations

import math
from collections.abc import Callable

from rclpy.node import Node

from crazychoir_fw.common.errors import RangeError


def check_frequency(who: str, frequency: float) -> None:
    """Check a frequency.

    Raises:
        RangeError: If it is not above zero, or exceeds 1 MHz.
    """
    if not (math.isfinite(frequency) and 0.0 < frequency <= 1e6):
        raise RangeError(f"{who}: frequency is {frequency}, allowed: above 0 Hz, up to 1 MHz")


class Periodic:
    """Calls ``work(now)`` on a grid of times: no drift, no bursts to catch up, and a reset."""

    def __init__(self, node: Node, frequency: float, work: Callable[[float], None]) -> None:
        """Start the timer.

        Args:
            node: Node that owns the timer and its clock.
            frequency: Calls per second (Hz).
            work: Called with the time of that clock (s).

        Raises:
            RangeError: If the frequency is not above zero.
        """
        check_frequency(node.get_name(), frequency)
        self.frequency = float(frequency)
        """Calls per second (Hz)."""
        self._node = node
        self._work = work
        self._clock = node.get_clock()
        self._last: float | None = None
        # rounded down: a grid of simulated steps rounded the other way would make every call a step late
        self._timer = node.create_timer(int(1e9 / frequency) * 1e-9, self._call, clock=self._clock)

    def _call(self) -> None:
        # an executor may call twice when the first time of a clock comes
        now = self._clock.now().nanoseconds / 1e9
        if now != self._last:
            self._last = now
            self._work(now)

    def reset(self) -> None:
        """Begin a new grid: the next call is one period from now."""
        self._last = None
        self._timer.reset()

    def skip(self) -> None:
        """Leave out a call that is due: the next one is a period from now."""
        self._timer.reset()

    def stop(self) -> None:
        """Cancel the timer."""
        self._timer.cancel()
