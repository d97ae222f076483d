"""Port 4: what memories there are, and bytes out of them and into them (docs/reference/crtp-cflib.md#10.1)."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from crazychoir_fw.crtp.memories import fitted_memories
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import Reply

INFO, READ, WRITE = range(3)
GET_COUNT, GET_DETAILS = 1, 2

OK, EIO = b"\x00", b"\x05"
"""Status of an answer; whatever goes wrong is an input or output error, as in the firmware."""

_PLACE = struct.Struct("<BI")  # id and address
_DETAILS = struct.Struct("<BBBI8s")  # command, id, type, size, serial
MAX_DATA = MAX_PAYLOAD - _PLACE.size - len(OK)
"""Bytes of memory that an answer has room for."""


class MemoryService:
    """Ids count from 0 and never change. Answers never wait for the simulation."""

    ports = (Port.MEMORY,)

    def __init__(self, context: ServiceContext) -> None:
        self.memories = fitted_memories(context)
        """By id."""
        self._details = [
            _DETAILS.pack(GET_DETAILS, number, memory.type, memory.size, memory.serial)
            for number, memory in enumerate(self.memories)
        ]

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Tell what there is, read or write. A packet that is cut off before the address is not answered."""
        if channel == INFO:
            answer = self._inform(payload)
            return ((INFO, answer),) if answer is not None else ()
        if len(payload) < _PLACE.size or channel not in (READ, WRITE):
            return ()
        result = self._read(payload) if channel == READ else self._write(payload)
        return ((channel, payload[: _PLACE.size] + result),)

    def end_session(self) -> None:
        """There is nothing to forget: memories outlive sessions."""

    def _inform(self, payload: bytes) -> bytes | None:
        if payload[:1] == bytes((GET_COUNT,)):
            return bytes((GET_COUNT, len(self.memories)))
        if payload[:1] == bytes((GET_DETAILS,)) and len(payload) > 1:
            return self._details[payload[1]] if payload[1] < len(self._details) else payload[:2]
        return None

    def _read(self, payload: bytes) -> bytes:
        number, address = _PLACE.unpack_from(payload)
        if len(payload) == _PLACE.size or not self._exists(number, address, length := payload[_PLACE.size]):
            return EIO
        data = self.memories[number].read(address, length) if length > 0 else b""
        return OK + data if data is not None else EIO

    def _write(self, payload: bytes) -> bytes:
        number, address = _PLACE.unpack_from(payload)
        data = payload[_PLACE.size :]
        if not self._exists(number, address, len(data)):
            return EIO
        return OK if not data or self.memories[number].write(address, data) else EIO

    def _exists(self, number: int, address: int, length: int) -> bool:
        return number < len(self.memories) and length <= MAX_DATA and address + length <= self.memories[number].size
