"""What a positioning system tells one drone, with the vocabulary of cflib's `Localization`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.clients.uplink import Uplink


class Localization:
    """External positions and poses, and the emergency stop: ``drone.loc``, as ``cf.loc`` of cflib.

    Calls for decks that are not simulated (ultra-wideband packets, persistent lighthouse data) are left out.
    """

    def __init__(self, name: str, cf: Any, uplink: Uplink) -> None:
        self._name = name
        self._cf = cf
        self._uplink = uplink
        uplink.handle("feed_watchdog", self._feed_watchdog)

    def _vector(self, values: ArrayLike, length: int, call: str) -> list[float]:
        vector = np.asarray(values, float)
        if vector.shape != (length,):
            raise RangeError(f"{self._name}: {call}: shape {vector.shape}, allowed: ({length},)")
        return vector.tolist()

    def send_extpos(self, pos: ArrayLike) -> None:
        """Tell the drone its position (m, world), shape (3,)."""
        x, y, z = self._vector(pos, 3, "send_extpos")
        check(self._uplink.request("cf_send_external_position", x, y, z), f"{self._name}: send_extpos([{x}, {y}, {z}])")

    def send_extpose(self, pos: ArrayLike, quat: ArrayLike) -> None:
        """Tell the drone its position (m, world), shape (3,), and attitude (quaternion xyzw), shape (4,)."""
        x, y, z = self._vector(pos, 3, "send_extpose")
        quat_xyzw = self._vector(quat, 4, "send_extpose")
        status = self._uplink.request("cf_send_external_pose", x, y, z, quat_xyzw)
        check(status, f"{self._name}: send_extpose([{x}, {y}, {z}], {quat_xyzw})")

    def send_emergency_stop(self) -> None:
        """Stop the motors and lock the drone until it is rebooted."""
        self._uplink.request("cf_emergency_stop")

    def send_emergency_stop_watchdog(self) -> None:
        """Start or feed the watchdog: the drone stops for good when a second passes without another call."""
        self._uplink.request("feed_watchdog")

    def _feed_watchdog(self) -> None:
        lib.cf_feed_emergency_watchdog(self._cf)
