"""Drones over the radio."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.common.motor_logs import FULL_DUTY, MOTORS
from crazychoir_fw.flight.access.access import Access, DroneState, Variable
from crazychoir_fw.flight.hardware_backend import SUPERVISOR
from crazychoir_fw.radio.connection import can_switch
from crazychoir_fw.radio.link import LinkState
from crazychoir_fw.radio.supervisor import CAN_BE_ARMED, IS_ARMED, IS_AUTO_ARMED, IS_LOCKED, supervisor_bits

if TYPE_CHECKING:
    from crazychoir_fw.planning import Polynomial

_BITS = (
    *("can be armed", "armed", "auto-armed", "can fly", "flying", "tumbled", "locked", "crashed"),
    *("high-level control is flying", "high-level trajectory finished", "high-level control disabled"),
)
"""Bits of ``supervisor.info``, from the lowest."""

_TRAJECTORY = 1  # id of the one that the page uploads


def _words(bits: float) -> str:
    return ", ".join(word for k, word in enumerate(_BITS) if int(bits) >> k & 1)


class HardwareAccess(Access):
    """What the radio handler says; parameters and memories take their time."""

    no_rewind = "the time of real drones cannot be turned back"
    knows_truth = False
    has_software = True

    def __init__(self, backend: Any) -> None:
        super().__init__(backend)
        self._drones = list(backend.handler)
        self._uploads: dict[int, Future[float]] = {}
        self._lock = threading.Lock()
        self._restarting: set[int] = set()
        self._problems: dict[int, str] = {}

    def _latest(self, index: int, name: str) -> float:
        seen = self._drones[index].latest.get(name)
        return float("nan") if seen is None else float(seen.value)

    def state(self, index: int) -> DroneState:
        """See `Access`."""
        drone, bits = self._drones[index], self._latest(index, SUPERVISOR)
        words = "" if np.isnan(bits) else _words(bits)
        link = str(drone.link_state)
        if drone.is_connected:
            with contextlib.suppress(CrazychoirError):  # it broke meanwhile
                link += f", {1000.0 * drone.link_latency_s:.0f} ms"
        failure = "restarting" if index in self._restarting else self._problems.get(index) or drone.reason
        duties = tuple(self._latest(index, name) / FULL_DUTY for name in MOTORS)
        return DroneState(
            supervisor=words or str(drone.mode),
            battery_v=self._latest(index, "pm.vbat"),
            link=link,
            failure=failure,
            motors=() if np.isnan(duties).any() else duties,
        )

    def batteries(self) -> NDArray[np.float64]:
        """See `Access`."""
        return np.array([self._latest(i, "pm.vbat") for i in range(len(self._drones))])

    def is_slow(self, index: int) -> bool:
        """See `Access`."""
        return True

    def arm(self, index: int, is_armed: bool) -> None:
        """See `Access`. What the drone would refuse without a word is refused here."""
        bits = self._latest(index, SUPERVISOR)
        if is_armed and not np.isnan(bits) and not int(bits) & (CAN_BE_ARMED | IS_ARMED | IS_AUTO_ARMED):
            raise StateError(
                f"{self.names[index]}: cannot be armed now, its supervisor says: {_words(bits) or 'nothing'}"
            )
        self._drones[index].arm(is_armed)

    def reboot(self, index: int) -> str:
        """Switch a real drone off and on; where the link cannot, tell one that has crashed that it may fly."""
        drone = self._drones[index]
        if can_switch(drone.uri):
            self._later(index, drone.reboot)
            return "back in about 10 s"
        if drone.link_state in (LinkState.DISCONNECTED, LinkState.CLOSED):
            self._later(index, drone.connect)
            return "called again"
        if not drone.is_connected:
            raise StateError(f"{self.names[index]}: the link is {drone.link_state}; wait until it is there")
        bits = supervisor_bits(drone.cf)
        if bits is not None and bits & IS_LOCKED:
            raise StateError(
                f"{self.names[index]}: is locked, and over {drone.uri.partition('://')[0]}:// its power cannot be "
                "switched; start crazychoir serve again, or a real drone by its button"
            )
        drone.recover()
        return "told that it may fly"

    def _later(self, index: int, do: Callable[[], None]) -> None:
        """Do something that takes its time in a thread of its own: once, until it is done."""
        with self._lock:
            if index in self._restarting:
                raise StateError(f"{self.names[index]}: is restarting already")
            self._restarting.add(index)
        self._problems.pop(index, None)

        def work() -> None:
            try:
                do()
            except Exception as error:  # told by its card
                self._problems[index] = str(error)
            finally:
                self._restarting.discard(index)

        threading.Thread(target=work, name=f"restart-{self.names[index]}", daemon=True).start()

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
                    value = float("nan")  # not received yet
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

    def cannot_follow(self, index: int) -> str | None:
        """See `Access`."""
        if hasattr(self._drones[index], "upload_trajectory"):
            return None
        return (
            f"{self.names[index]}: its radio handler streams set-points; a mission with layers.planning streams "
            "curves, one without layers.control uploads them"
        )

    def begin_upload(self, index: int, curve: Polynomial) -> None:
        """See `Access`: in a thread for each drone, since the flight goes on meanwhile."""
        drone = self._drones[index]
        if reason := self.cannot_follow(index):
            raise StateError(reason)
        future: Future[float] = Future()
        self._uploads[index] = future

        def write() -> None:
            from crazychoir_fw.planning import to_pieces

            try:
                future.set_result(drone.upload_trajectory(_TRAJECTORY, to_pieces(curve).rows))
            except Exception as error:  # raised again in the thread that reads the future
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
