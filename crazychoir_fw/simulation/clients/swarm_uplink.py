"""Setpoints of many drones in one call: what `Uplink.request("setpoint", ...)` does one by one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import repeat
from operator import attrgetter, eq, is_
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import check

if TYPE_CHECKING:
    from crazychoir_fw.recording.journal import Journal
    from crazychoir_fw.simulation.clients.uplink import Uplink
    from crazychoir_fw.simulation.drone import Drone

_FAULT_FILTER, _TRANSPORT, _LISTENERS = attrgetter("fault_filter"), attrgetter("transport"), attrgetter("listeners")
_NONE, _ONE = repeat(None), repeat(1)

SETPOINT_BYTES: int = ffi.sizeof("setpoint_t")
"""Size of one setpoint."""


class SwarmUplink:
    """The uplinks of all drones of a world."""

    def __init__(self, drones: Sequence[Drone]) -> None:
        """Take the drones; each uplink has one listener, the journal, so far."""
        self._drones = drones
        self._uplinks = [drone.uplink for drone in drones]
        self._structs = ffi.new("cf_t *[]", [drone.struct for drone in drones])
        self._status = ffi.new("cf_status_t *")

    def send_setpoints(
        self, numbers: Sequence[int] | NDArray[np.integer], setpoints: bytes, journal: Journal, tick: int
    ) -> None:
        """Send a setpoint each to several drones.

        Args:
            numbers: Of the drones.
            setpoints: A ``setpoint_t`` for each, one behind the other.
            journal: Where they are written down.
            tick: Now (ms).

        Raises:
            RangeError: If a number in one is not finite.
            StateError: If a drone has failed.
        """
        chosen = np.ascontiguousarray(numbers, np.int32)
        # other listeners, filters and transports get them one by one
        alone: list[int] = []
        if not self._are_plain():
            alone = [k for k, i in enumerate(chosen.tolist()) if not _is_plain(self._uplinks[i])]
        if alone:
            self._send_one_by_one(chosen, setpoints, alone)
            is_plain = np.ones(len(chosen), bool)
            is_plain[alone] = False
            rows = np.frombuffer(setpoints, np.uint8).reshape(-1, SETPOINT_BYTES)
            chosen, setpoints = chosen[is_plain], rows[is_plain].tobytes()
        if not len(chosen):
            return
        journal.add_blocks(tick, chosen, "setpoint", setpoints, SETPOINT_BYTES)
        cells = ffi.from_buffer("int32_t[]", chosen)
        taken = lib.cf_send_setpoints(self._structs, cells, len(chosen), setpoints, self._status)
        if taken < len(chosen):
            check(self._status[0], f"{self._drones[chosen[taken]].id}: setpoint")

    def _are_plain(self) -> bool:
        """Return whether all uplinks are plain; look-ups that C makes take a third of the time of a loop here."""
        uplinks = self._uplinks
        return (
            all(map(is_, map(_FAULT_FILTER, uplinks), _NONE))
            and all(map(is_, map(_TRANSPORT, uplinks), _NONE))
            and all(map(eq, map(len, map(_LISTENERS, uplinks)), _ONE))
        )

    def _send_one_by_one(self, numbers: NDArray[np.int32], setpoints: bytes, places: Sequence[int]) -> None:
        for k in places:
            word = setpoints[k * SETPOINT_BYTES : (k + 1) * SETPOINT_BYTES]
            drone = self._drones[numbers[k]]
            check(drone.uplink.request("setpoint", word), f"{drone.id}: setpoint")


def _is_plain(uplink: Uplink) -> bool:
    return uplink.fault_filter is None and uplink.transport is None and len(uplink.listeners) == 1
