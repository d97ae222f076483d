"""Port 2, parameters (docs/reference/crtp-cflib.md#9).

Choices where the firmware has none, or is known to be wrong:

- A value that is not finite is refused. The answer to such a write carries the value that stays, so that the client
  does not believe in the other one; a write by name is answered with EINVAL.
- The same holds for a write that is too short, and for one that comes while too many wait.
- A change that the client did not ask for is sent at the next tenth of a simulated second, with the value where the
  client looks for it; also one that was written by name, which the firmware keeps to itself.
- What runs on board when a parameter is written, runs also when it is written by name.
"""

from __future__ import annotations

import errno
from collections.abc import Iterable
from typing import Any

from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.param_misc import VALUE_UPDATED, MiscCommands, defaults, fitting
from crazychoir_fw.crtp.services.param_storage import storage_of
from crazychoir_fw.crtp.services.param_values import ParameterValues
from crazychoir_fw.crtp.services.reading_ahead import ReadingAhead
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.crtp.toc import READ_ONLY, parameter_toc

TOC, READ, WRITE, MISC = range(4)

LOOK_EVERY = 100
"""Ticks between two looks for parameters that the drone changed by itself."""


class ParamService:
    """Reads, writes and stores the parameters of one drone."""

    ports = (Port.PARAM,)

    def __init__(self, context: ServiceContext) -> None:
        """Have what is stored written, and again after every boot.

        Raises:
            RangeError: If the file of stored parameters is none.
        """
        drone = context.drone
        self._context = context
        self._toc = parameter_toc(drone.provider_number)
        self._reading = ReadingAhead(context, Port.PARAM, self._toc)
        self._values = ParameterValues(context, self._toc)
        self._storage = storage_of(drone, context.storage)
        stock = defaults(int(drone.struct.config.platform), drone.provider_number)
        self._misc = MiscCommands(self._toc, self._values, self._storage, stock)
        context.every(LOOK_EVERY, self._tell_news)
        drone.uplink.listeners.append(self._listen)
        context.closing.callback(drone.uplink.listeners.remove, self._listen)
        context.when_sought(self._go_back)
        context.later(self._write_stored)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer a request at once; writes take effect between two steps of the simulation."""
        if channel == TOC:
            return self._reading.receive(payload)
        if channel == MISC:
            answer = self._misc.answer(payload)
        elif len(payload) < 2:
            return ()
        else:
            number = int.from_bytes(payload[:2], "little")
            if number >= len(self._toc):
                answer = payload[:2] + bytes((errno.ENOENT,))
            elif channel == READ:
                answer = payload[:2] + b"\0" + self._told(number)
            else:
                answer = self._write(number, payload)
        return () if answer is None else ((channel, answer),)

    def _told(self, number: int) -> bytes:
        raw = self._values.read(number)
        self._values.believe(number, raw)
        return raw

    def _write(self, number: int, payload: bytes) -> bytes | None:
        if self._toc.types[number] & READ_ONLY:
            return None
        raw = payload[2 : 2 + self._values.size(number)]
        if len(raw) < self._values.size(number) or not self._values.write(number, raw):
            return payload[:2] + self._told(number)
        self._values.believe(number, raw)
        return payload

    def end_session(self) -> None:
        """Tell of changes no more."""
        self._reading.forget()
        self._values.forget_client()

    # ---------------------------------------------------------------- on the simulation thread

    def _tell_news(self) -> None:
        for number, raw in self._values.news():
            self._context.send(Port.PARAM, MISC, bytes((VALUE_UPDATED,)) + number.to_bytes(2, "little") + raw)

    def _listen(self, verb: str, arguments: tuple[Any, ...]) -> None:
        if verb == "cf_reboot":
            self._context.later(self._write_stored)

    def _go_back(self, tick: int) -> None:
        if tick == 0:
            self._context.later(self._write_stored)

    def _write_stored(self) -> None:
        """Write what is stored and this drone has, as the firmware does when it boots."""
        for name, value in self._storage:
            number = self._toc.numbers.get(name)
            if number is None or not self._toc.variables[number].is_persistent:
                continue
            raw = fitting(self._values, number, value)
            if raw is not None:
                # past the radio, whatever may be wrong with that
                self._context.drone.uplink.dispatch("param", name, self._values.unpack(number, raw))
