"""Where a drone is, and whether that is inside of its safety area."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.radio.flight import FlightState
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.sender import Sender

_FRESH_S = 1.0  # an older position says nothing about the safety area


class PoseCache:
    """The last known position of one drone, and what follows from it.

    Args:
        who: Name and URI, for errors.
        options: Safety area and clock.
        sender: The way to the drone.
        flight: What ends when the drone is outside.
    """

    def __init__(self, who: str, options: Options, sender: Sender, flight: FlightState) -> None:
        self._who = who
        self._area = options.safety_area
        self._clock = options.clock
        self._sender = sender
        self._flight = flight
        self._known: tuple[float, NDArray[np.float64]] | None = None  # time (s), position
        self._is_outside = False

    @property
    def position(self) -> NDArray[np.float64] | None:
        """Last known position (m, world), shape (3,)."""
        known = self._known
        return known[1].copy() if known is not None else None

    @property
    def is_fresh(self) -> bool:
        """Whether the position is at most 1 s old."""
        return self._known is not None and self._clock() - self._known[0] <= _FRESH_S

    def note(self, position: NDArray[np.float64], now: float) -> None:
        """Remember where it is (m, world) at a time (s), and act when that is outside."""
        self._known = (now, position)
        area, flight = self._area, self._flight
        was_outside, self._is_outside = self._is_outside, area is not None and not area.contains(position, area.margin)
        if area is None or not self._is_outside:
            return
        with self._sender.lock:
            if not flight.is_active or flight.mode not in (Mode.READY, Mode.TAKING_OFF):
                return
            where = ", ".join(f"{value:.2f}" for value in position)
            text = f"at ({where}), outside of the safety area {area}"
            if area.breach == "stop":
                flight.stop(text)
            elif area.breach == "land":
                flight.land(reason=text)
            elif was_outside:  # reported when it left
                return
            flight.note("safety_area", text)
        self._sender.outbox.wake()
        flight.emit()

    def inside(self, velocity: Sequence[float]) -> Sequence[float]:
        """Bend a velocity (m/s, world) at the border of the safety area.

        A drone that no longer tells where it is stands still; one that has never told is not limited.
        """
        if self._area is None or self._known is None:
            return velocity
        time, position = self._known
        if self._clock() - time > _FRESH_S:
            return (0.0, 0.0, 0.0)
        return self._area.velocity(position, velocity)

    def check_start(self, height: float) -> None:
        """Refuse a take-off to a height (m, world) that leads out of the safety area, or begins outside.

        Raises:
            RangeError: If it does.
        """
        area, position = self._area, self.position
        if area is None:
            return
        if position is not None:
            x, y, z = position.tolist()
            if not area.contains((x, y, max(z, area.low[2])), area.margin):
                raise RangeError(f"{self._who}: takeoff: ({x:.2f}, {y:.2f}) is outside of the safety area {area}")
        if not area.low[2] <= height <= area.high[2]:
            raise RangeError(f"{self._who}: takeoff: height {height:g} m is outside of the safety area {area}")
