"""Channel 3 of port 2: what can be asked about parameters beyond their values (docs/reference/crtp-cflib.md#9.5)."""

from __future__ import annotations

import errno
import functools
import struct
from collections.abc import Callable

from crazychoir_fw.crtp.services.param_storage import ParameterStorage
from crazychoir_fw.crtp.services.param_values import ParameterValues
from crazychoir_fw.crtp.toc import READ_ONLY, TableOfContents, parameter_toc
from crazychoir_fw.onboard.core import platform_names
from crazychoir_fw.onboard.variables import factory_values, parameter_table

SET_BY_NAME, VALUE_UPDATED, EXTENDED_TYPE, STORE, STATE, CLEAR, DEFAULT, EXTENDED_TYPE_V2, DEFAULT_V2 = range(9)
"""First byte."""

PERSISTENT = 1
"""Extended type of a parameter that can be stored."""

_OK = b"\0"
_NO_ENTRY = bytes((errno.ENOENT,))
_TYPE = 0x0F  # bits of the type byte without flags

Answer = Callable[[int], bytes]
"""Takes the number of a parameter that exists and returns what follows command and number."""


class MiscCommands:
    """Answers the commands of one drone."""

    def __init__(
        self, toc: TableOfContents, values: ParameterValues, storage: ParameterStorage, defaults: dict[str, float | int]
    ) -> None:
        self._toc = toc
        self._values = values
        self._storage = storage
        self._defaults = defaults
        self._answers: dict[int, Answer] = {
            EXTENDED_TYPE: self._extended_type,
            STORE: self._store,
            STATE: self._state,
            CLEAR: self._clear,
            DEFAULT: self._default,
            EXTENDED_TYPE_V2: self._extended_type_v2,
            DEFAULT_V2: self._default_v2,
        }

    def answer(self, payload: bytes) -> bytes | None:
        """Return the answer to a request, None where the firmware gives none."""
        if not payload:
            return None
        if payload[0] == SET_BY_NAME:
            return self._set_by_name(payload)
        answer = self._answers.get(payload[0])
        if answer is None or len(payload) < 3:
            return None
        number = int.from_bytes(payload[1:3], "little")
        return payload[:3] + (answer(number) if number < len(self._toc) else _NO_ENTRY)

    def _set_by_name(self, payload: bytes) -> bytes | None:
        parts = payload[1:].split(b"\0", 2)
        if len(parts) < 3 or not parts[2]:
            return None
        group, name, rest = parts
        error = self._set(group, name, rest[0], rest[1:])
        return bytes((SET_BY_NAME,)) + group + b"\0" + name + b"\0" + bytes((error,))

    def _set(self, group: bytes, name: bytes, type_byte: int, raw: bytes) -> int:
        """Have a parameter written by its name; returns the error number."""
        number = self._toc.numbers.get(f"{group.decode('latin-1')}.{name.decode('latin-1')}")
        if number is None:
            return errno.ENOENT
        kind, size = self._toc.types[number], self._values.size(number)
        if (kind ^ type_byte) & _TYPE or len(raw) < size:
            return errno.EINVAL
        if kind & READ_ONLY:
            return errno.EACCES
        return 0 if self._values.write(number, raw[:size]) else errno.EINVAL

    def _is_persistent(self, number: int) -> bool:
        return self._toc.variables[number].is_persistent

    def _extended_type(self, number: int) -> bytes:
        return bytes((PERSISTENT,)) if self._is_persistent(number) else _NO_ENTRY

    def _extended_type_v2(self, number: int) -> bytes:
        return _OK + bytes((PERSISTENT,)) if self._is_persistent(number) else _NO_ENTRY

    def _store(self, number: int) -> bytes:
        if not self._is_persistent(number):
            return _NO_ENTRY
        value = self._values.unpack(number, self._values.read(number))
        return _OK if self._storage.store(self._toc.variables[number].name, value) else _NO_ENTRY

    def _clear(self, number: int) -> bytes:
        return _OK if self._storage.clear(self._toc.variables[number].name) else _NO_ENTRY

    def _state(self, number: int) -> bytes:
        default = self._default_bytes(number)
        stored = fitting(self._values, number, self._storage.get(self._toc.variables[number].name))
        return _OK + default if stored is None else b"\1" + default + stored

    def _default_bytes(self, number: int) -> bytes:
        return self._values.pack(number, self._defaults[self._toc.variables[number].name])

    def _default(self, number: int) -> bytes:
        return _NO_ENTRY if self._toc.types[number] & READ_ONLY else self._default_bytes(number)

    def _default_v2(self, number: int) -> bytes:
        return _NO_ENTRY if self._toc.types[number] & READ_ONLY else _OK + self._default_bytes(number)


def fitting(values: ParameterValues, number: int, value: float | int | None) -> bytes | None:
    """Return a stored value as bytes; None where there is none, or one that the parameter's type cannot hold."""
    if value is None:
        return None
    try:
        return values.pack(number, value)
    except (struct.error, OverflowError):
        return None


@functools.cache
def defaults(platform: int, provider: int) -> dict[str, float | int]:
    """Return what parameters are after the boot of a stock drone, by name.

    Args:
        platform: Number of the airframe.
        provider: Number of the provider.
    """
    names = [variable.name for variable in parameter_toc(provider).variables]
    found = factory_values(platform_names()[platform], parameter_table(provider), provider)
    return {name: found[name] for name in names}
