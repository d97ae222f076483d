"""The one way by which requests of clients reach their drone.

Whatever listens to commands (a journal for replay) or disturbs them (a radio that loses packets) hooks in here; the
clients beside this file only turn cflib's vocabulary into requests.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from crazychoir_fw._core import ffi, lib

Listener = Callable[[str, tuple[Any, ...]], None]
"""Called with verb and arguments of every request that the drone takes, in their order."""

FaultFilter = Callable[[str, tuple[Any, ...]], bool]
"""Called before a request leaves the client: False drops it. A filter that delays a request calls `Uplink.send`."""

Transport = Callable[[str, tuple[Any, ...]], None]
"""Takes what has left the client, and calls `Uplink.dispatch` when it arrives, if it does."""

_C_REQUESTS = re.compile(
    r"cf_(send|inject)_\w+"
    r"|cf_(arm|recover_from_crash|emergency_stop|fail_pilot|reboot|notify_setpoint_stop|set_group_mask)"
    r"|cf_(takeoff|land|stop|go_to|spiral|takeoff_with_velocity|land_with_velocity)"
    r"|cf_(write|define|start)_trajectory|cf_write_memory"
)
"""C functions that clients ask for; a file may name others, which clients may not call."""

_POINTED_AT = {"cf_send_external_pose": 4, "cf_inject_gust": 3, "cf_spiral": 1, "cf_inject_imu": 1}
"""So many numbers or structs C reads behind the pointer that these requests hand over."""


class Uplink:
    """Requests to one drone: a verb, which is the name of a C function over ``cf_t`` or has a handler, and plain data.

    Arguments are numbers, booleans, text, bytes and lists of them, so that a request can be written to a file.
    """

    def __init__(self, cf: Any) -> None:
        self._cf = cf
        self._handlers: dict[str, Callable[..., Any]] = {}
        self.listeners: list[Listener] = []
        self.fault_filter: FaultFilter | None = None
        self.transport: Transport | None = None
        """A simulated radio, if there is one; otherwise what leaves the client is delivered at once."""

    def handle(self, verb: str, handler: Callable[..., Any]) -> None:
        """Let a function carry out a verb that is no plain C function."""
        self._handlers[verb] = handler

    def is_request(self, verb: str, arguments: tuple[Any, ...]) -> bool:
        """Tell whether clients ask for such a thing, so that a request from a file may be delivered."""
        if verb in self._handlers:
            return True
        if _C_REQUESTS.fullmatch(verb) is None or not hasattr(lib, verb):
            return False
        if verb in ("cf_write_trajectory", "cf_write_memory"):
            *_where, length, data = arguments
            return isinstance(data, bytes) and len(data) == length
        if verb == "cf_fail_pilot":
            return len(arguments) == 1 and isinstance(arguments[0], bytes)
        # C believes that what it is pointed at is complete
        kinds = [argument.kind for argument in ffi.typeof(getattr(lib, verb)).args[1:]]
        lists = [value for value, kind in zip(arguments, kinds, strict=False) if kind == "pointer"]
        return all(isinstance(value, list) and len(value) == _POINTED_AT.get(verb) for value in lists)

    def request(self, verb: str, *arguments: Any) -> Any:
        """Send a request, as a client does by radio. Returns what it returns; ``CF_OK`` when it is lost."""
        if self.fault_filter is not None and not self.fault_filter(verb, arguments):
            return lib.CF_OK
        return self.send(verb, *arguments)

    def send(self, verb: str, *arguments: Any) -> Any:
        """Let a request go its way after the fault filter. Returns what it returns; ``CF_OK`` on a simulated radio."""
        if self.transport is not None:
            self.transport(verb, arguments)
            return lib.CF_OK
        return self.dispatch(verb, *arguments)

    def dispatch(self, verb: str, *arguments: Any) -> Any:
        """Carry out a request on the drone, past the radio.

        Raises:
            TypeError: If C cannot take an argument; no listener hears of the request then.
            OverflowError: The same, for a number that is too large.
        """
        handler = self._handlers.get(verb)
        # what C refuses has not happened: a journal that held it could not be replayed
        result = getattr(lib, verb)(self._cf, *arguments) if handler is None else None
        for listener in self.listeners:
            listener(verb, arguments)
        return result if handler is None else handler(*arguments)
