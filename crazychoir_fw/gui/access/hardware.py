"""Drones over the radio."""

from __future__ import annotations

import contextlib
import threading
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.errors import CrazychoirError, StateError
from crazychoir_fw.experiment.hardware_backend import SUPERVISOR
from crazychoir_fw.gui.access.access import Access, DroneState, Variable

if TYPE_CHECKING:
    from crazychoir_fw.planning import Polynomial

_BITS = (
    *("can be armed", "armed", "auto-armed", "can fly", "flying", "tumbled", "locked", "crashed"),
    *("high-level control is flying", "high-level trajectory finished", "high-level control disabled"),
)
"""Bits of ``supervisor.info``, from the lowest."""

_TRAJECTORY = 1  # id of the one that the page uploads


class HardwareAccess(Access):
    """What the radio handler says; parameters and memories take their time."""

    is_slow = True
    can_rewind = False

    def __init__(self, backend: Any) -> None:
        super().__init__(backend)
        self._drones = list(backend.handler)
        self._uploads: dict[int, Future[float]] = {}

    def _latest(self, index: int, name: str) -> float:
        seen = self._drones[index].latest.get(name)
        return float("nan") if seen is None else float(seen.value)

    def state(self, index: int) -> DroneState:
        """See `Access`."""
        drone, bits = self._drones[index], self._latest(index, SUPERVISOR)
        words = "" if np.isnan(bits) else ", ".join(w for k, w in enumerate(_BITS) if int(bits) >> k & 1)
        link = str(drone.link_state)
        if drone.is_connected:
            with contextlib.suppress(CrazychoirError):  # it broke meanwhile
                link += f", {1000.0 * drone.link_latency_s:.0f} ms"
        return DroneState(words or str(drone.mode), self._latest(index, "pm.vbat"), link=link, failure=drone.reason)

    def batteries(self) -> NDArray[np.float64]:
        """See `Access`."""
        return np.array([self._latest(i, "pm.vbat") for i in range(len(self._drones))])

    def arm(self, index: int, is_armed: bool) -> None:
        """See `Access`."""
        self._drones[index].arm(is_armed)

    def reboot(self, index: int) -> None:
        """Tell a drone that has crashed that it may fly; restarting is done by hand."""
        drone = self._drones[index]
        if not drone.is_connected:
            raise StateError(f"{self.names[index]}: the link is {drone.link_state}; switch it off and on")
        drone.recover()

    def stop_now(self, indices: list[int]) -> None:
        """See `Access`."""
        for i in indices:
            self._drones[i].stop()

    def parameters(self, index: int) -> list[Variable]:
        """See `Access`."""
        drone = self._drones[index]
        found = []
        for group, members in sorted(drone.cf.param.toc.toc.items()):
            for name, element in sorted(members.items()):
                try:
                    value = drone.get_parameter(f"{group}.{name}")
                except CrazychoirError:
                    value = float("nan")  # not heard of yet
                read_only = element.get_readable_access() == "RO"
                found.append(Variable(f"{group}.{name}", str(element.ctype), value, read_only))
        return found

    def set_parameter(self, index: int, name: str, value: float) -> float:
        """See `Access`."""
        self._drones[index].set_parameter(name, value)
        return self._drones[index].get_parameter(name)

    def log_names(self) -> list[str]:
        """Return what is logged by now."""
        return sorted({name for drone in self._drones for name in drone.latest} | set(super().log_names()))

    def log_value(self, index: int, name: str) -> float:
        """See `Access`."""
        if name in super().log_names():
            return super().log_value(index, name)
        return self._latest(index, name)

    def begin_upload(self, index: int, curve: Polynomial) -> None:
        """See `Access`: in a thread for each drone, since the flight goes on meanwhile."""
        drone = self._drones[index]
        if not hasattr(drone, "upload_trajectory"):
            raise StateError(f"{self.names[index]}: its radio handler streams set-points; a mission with "
                             "layers.planning streams curves, one without layers.control uploads them")  # fmt: skip
        future: Future[float] = Future()
        self._uploads[index] = future

        def write() -> None:
            from crazychoir_fw.planning import to_pieces

            try:
                future.set_result(drone.upload_trajectory(_TRAJECTORY, to_pieces(curve).rows))
            except Exception as error:  # told to whoever asks
                future.set_exception(error)

        threading.Thread(target=write, name=f"upload-{self.names[index]}", daemon=True).start()

    def is_uploaded(self, index: int) -> bool:
        """See `Access`."""
        future = self._uploads[index]
        return future.done() and future.result() is not None

    def fly_uploaded(self, index: int) -> None:
        """See `Access`."""
        if not self._drones[index].start_trajectory(_TRAJECTORY):
            raise StateError(f"{self.names[index]}: takes no trajectory now, {self._drones[index].mode}")
