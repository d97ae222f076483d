"""One link to one drone: opened within a time, closed for certain, lost with a report."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cflib.crtp
from cflib.crtp.udpdriver import UdpDriver
from cflib.utils.power_switch import PowerSwitch

from crazychoir_fw.common.errors import RadioError, RangeError, StateError
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie

_SERVE = "is `crazychoir serve` running?"
_DRIVERS_LOCK = threading.Lock()


def init_drivers() -> None:
    """Load cflib's drivers, once; its own function adds them again each time."""
    with _DRIVERS_LOCK:
        if UdpDriver not in cflib.crtp.CLASSES:
            cflib.crtp.init_drivers()


class Connection:
    """One link to one drone, through one Crazyflie object of cflib.

    Args:
        uri: Where the drone is.
        cache: Folder for tables of contents, which are the same for every drone with the same firmware.
        on_lost: Called with a reason when an open link breaks, in a thread of cflib.
    """

    def __init__(self, uri: str, cache: Path | None, on_lost: Callable[[Connection, str], None]) -> None:
        self.uri = uri
        if cache is not None:
            cache.mkdir(parents=True, exist_ok=True)  # cflib stumbles when several drones make it at once
        self.cf = LinkedCrazyflie(rw_cache=str(cache) if cache is not None else None)
        self._on_lost = on_lost
        self._stage = "nothing"
        self._failure: str | None = None
        self._changed = threading.Condition()
        self._is_open = False
        for caller, stage in (
            (self.cf.link_established, "answer"),
            (self.cf.connected, "tables"),
            (self.cf.fully_connected, "parameters"),
        ):
            # a lambda would lose the value of the loop
            caller.add_callback(lambda _, stage=stage: self._reached(stage))
        self.cf.connection_failed.add_callback(lambda _, reason: self._failed(reason))
        self.cf.connection_lost.add_callback(lambda _, reason: self._failed(reason))

    @property
    def is_open(self) -> bool:
        """Whether packets can be sent."""
        return self._is_open and self.cf.link is not None

    def open(self, answer_timeout_s: float, timeout_s: float, *, with_parameters: bool = True) -> None:
        """Open the link, and wait until cflib knows the drone.

        Args:
            answer_timeout_s: How long the drone may be silent at first (s).
            timeout_s: How long all of it may take (s), tables of contents and parameters included.
            with_parameters: Whether to wait for the values of all parameters; without them none can be set.

        Raises:
            RadioError: If it is not reached; the text says how far it got.
        """
        init_drivers()
        began = time.monotonic()
        self.cf.open_link(self.uri)
        self._wait({"answer", "tables", "parameters"}, began + min(answer_timeout_s, timeout_s))
        self._wait({"parameters"} if with_parameters else {"tables", "parameters"}, began + timeout_s)
        self._is_open = True
        with self._changed:
            failure = self._failure
        if failure is not None:  # between the last packet and this line
            self._give_up(f"{self.uri}: {failure}")

    def abandon(self) -> None:
        """End an `open` that waits in another thread."""
        with self._changed:
            self._failure = self._failure or "closed"
            self._changed.notify_all()

    def close(self) -> None:
        """Close the link, without a word to the drone; takes up to 1 s."""
        self._is_open = False
        self.cf.drop_link()

    def _reached(self, stage: str) -> None:
        with self._changed:
            self._stage = stage
            self._changed.notify_all()

    def _failed(self, reason: object) -> None:
        was_open, self._is_open = self._is_open, False
        # the text of a driver that could not be loaded goes on with a traceback
        text = str(reason).split("\n\nTraceback")[0].strip().replace("\n", " ")
        with self._changed:
            self._failure = text or "link error"
            self._changed.notify_all()
        if was_open:
            self._on_lost(self, self._failure)

    def _wait(self, stages: set[str], until: float) -> None:
        with self._changed:
            while self._failure is None and self._stage not in stages:
                left = until - time.monotonic()
                if left <= 0.0:
                    break
                self._changed.wait(left)
            failure, stage = self._failure, self._stage
        if failure is None and stage in stages:
            return
        self._give_up(f"{self.uri}: {self._stuck(stage) if failure is None else self._broken(failure)}")

    def _broken(self, failure: str) -> str:
        return f"nobody listens there; {_SERVE}" if "refused" in failure and self._is_udp else failure

    @property
    def _is_udp(self) -> bool:
        return self.uri.startswith("udp:")

    def _stuck(self, stage: str) -> str:
        if stage == "nothing":
            hint = _SERVE if self._is_udp else "is the drone switched on?"
            return f"no answer within the time allowed; {hint}"
        known = "tables of contents" if stage == "answer" else "values of all parameters"
        return f"it answers, but its {known} did not come within the time allowed"

    def _give_up(self, text: str) -> None:
        self.close()
        raise RadioError(text)


@dataclass(frozen=True)
class ReconnectPolicy:
    """Attempts after a loss, with growing waits before each.

    Raises:
        RangeError: If a number is out of its range.
    """

    attempts: int = 10
    """How many; 0 gives the drone up at once."""
    first_wait_s: float = 0.5
    """Wait before the first attempt (s)."""
    factor: float = 2.0
    """What each wait is longer than the one before."""
    longest_wait_s: float = 5.0
    """No wait is longer (s)."""
    resumes: bool = False
    """Whether commands are taken again as soon as the link is back. Without it a drone that was lost waits for
    `resume` or `takeoff`: it may lie on the floor, next to a person about to pick it up."""

    def __post_init__(self) -> None:
        for name in ("attempts", "first_wait_s", "longest_wait_s"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RangeError(f"{name} is {getattr(self, name)!r}, allowed: a number from 0")
        if not (math.isfinite(self.factor) and self.factor >= 1.0):
            raise RangeError(f"factor is {self.factor!r}, allowed: a number from 1")

    def waits(self) -> Iterator[float]:
        """Yield the wait before each attempt (s)."""
        wait = self.first_wait_s
        for _ in range(self.attempts):
            yield min(wait, self.longest_wait_s)
            wait *= self.factor


BOOT_S = 4.0
"""How long a drone takes until it answers again, sensors and decks included (s)."""


def can_switch(uri: str) -> bool:
    """Return whether the power of a drone can be switched over this link: by a Crazyradio only."""
    return uri.startswith("radio://")


def power_cycle(who: str, uri: str) -> None:
    """Switch the drone off for a second, and on again; the link must have been closed. Takes more than 1 s.

    Raises:
        StateError: If this link cannot do that.
        RadioError: If the radio chip of the drone does not answer.
    """
    if not can_switch(uri):
        raise StateError(f"{who}: its power can be switched over radio:// only")
    init_drivers()
    try:
        switch = PowerSwitch(uri)
        try:
            switch.stm_power_cycle()
        finally:
            switch.close()
    except Exception as error:  # of many kinds: no dongle, no answer, an address that is none
        raise RadioError(f"{who}: the power could not be switched: {error}") from error
