"""The journal of a flight: every request that reached a drone, with its tick, and how to build the world again.

Same world and same requests give the same bits, so that a journal is a whole flight in a few kilobytes. Requests are
kept in columns, about 40 bytes for a setpoint: a flight of an hour with setpoints at 50 Hz takes 7 MB per drone.
"""

from __future__ import annotations

import json
import numbers
from array import array
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_SCALARS = frozenset("bif")
_CODES = {bool: "b", float: "f", str: "s", bytes: "y", type(None): "n"}
_CODES_OF_VALUES = frozenset("bifsyjn")
_FORGOTTEN = "its first requests are in the stream of a log, and no copy has them"
_EXACT = 2**53  # whole numbers up to here survive as float64


class Request(NamedTuple):
    """One request as it reached its drone."""

    tick: int
    """Milliseconds since the start of the world."""
    drone: int
    """Number of the drone in its world, from 0."""
    verb: str
    """What was asked for (`crazychoir_fw.simulation.clients.uplink`)."""
    arguments: tuple[Any, ...]
    """Plain data: numbers, booleans, text, bytes, lists of them."""


class _Kind:
    """All requests with one verb and arguments of the same types, in columns."""

    def __init__(self, verb: str, signature: str) -> None:
        self.verb = verb
        self.signature = signature
        self.numbers = array("d")
        self.blob = bytearray()

    def copy(self) -> _Kind:
        other = _Kind(self.verb, self.signature)
        other.numbers = self.numbers[:]
        other.blob = self.blob[:]
        return other


class Journal:
    """Requests in the order of their coming."""

    def __init__(self, recipe: Mapping[str, Any] | None = None) -> None:
        """Begin an empty journal.

        Args:
            recipe: How to build the world (`crazychoir_fw.simulation.recipe`); what JSON can hold.
        """
        self.recipe: dict[str, Any] = dict(recipe or {})
        self.gap: str | None = None
        """Why the requests alone do not lead to the end of the flight, as a sentence; None when they do."""
        self.samples: list[int] = []
        """Of a recorded flight: how many requests had come before each sample of the log, (T,)."""
        self.is_kept = True
        """Whether requests are written down."""
        self.forgotten = 0
        """Number of requests, the first ones, that are on disk and not in memory."""
        self._clear()

    def _clear(self) -> None:
        self._ticks = array("q")
        self._drones = array("i")
        self._kind_numbers = array("i")
        self._kinds: list[_Kind] = []
        self._number_of: dict[tuple[str, str], int] = {}
        # by verb and types of arguments, for speed: numbers only, and numbers before bytes, as packets have
        self._scalar_kinds: dict[tuple[Any, ...], int] = {}
        self._bytes_kinds: dict[tuple[Any, ...], int] = {}

    def __len__(self) -> int:
        return self.forgotten + len(self._ticks)

    def __repr__(self) -> str:
        return f"<Journal of {len(self)} requests>"

    def stop(self, why: str) -> None:
        """Forget all requests and stop recording.

        Args:
            why: A sentence, which is the gap from now on.
        """
        self.gap = why
        self.is_kept = False
        self.forgotten = 0
        self._clear()

    def forget(self) -> None:
        """Forget requests that are on disk; they still count."""
        self.forgotten = len(self)
        self._clear()

    def extend(self, other: Journal) -> None:
        """Append the requests of another journal, which came later, and take over its gap."""
        numbers = array("i", [self._number(kind.verb, kind.signature) for kind in other._kinds])
        for number, kind in zip(numbers, other._kinds, strict=True):
            self._kinds[number].numbers.extend(kind.numbers)
            self._kinds[number].blob += kind.blob
        self._ticks.extend(other._ticks)
        self._drones.extend(other._drones)
        self._kind_numbers.extend(array("i", [numbers[number] for number in other._kind_numbers]))
        self.gap = self.gap or other.gap

    def begin_again(self) -> Journal:
        """Return an empty journal of the same world, for a flight from its start."""
        other = Journal(self.recipe)
        if not self.is_kept and self.gap is not None:
            other.stop(self.gap)
        return other

    def add(self, tick: int, drone: int, verb: str, arguments: Sequence[Any]) -> None:
        """Write a request down; what no file can hold becomes a gap."""
        if not self.is_kept:
            return
        types = (verb, *map(type, arguments))
        number = self._scalar_kinds.get(types)
        if number is not None and (int not in types or _are_exact(arguments)):
            self._kinds[number].numbers.extend(arguments)
        elif (number := self._bytes_kinds.get(types)) is not None and _are_exact(arguments[:-1]):
            kind, raw = self._kinds[number], arguments[-1]
            kind.numbers.extend(arguments[:-1])
            kind.numbers.append(len(raw))
            kind.blob += raw
        else:
            try:
                signature = "".join(_signature(argument) for argument in arguments)
            except TypeError as error:
                self.gap = self.gap or f"'{verb}' at {tick / 1000:.3f} s carries {error}, which no file can hold"
                return
            number = self._number(verb, signature)
            for argument in arguments:
                _store(argument, self._kinds[number])
            self._remember(types, signature, number)
        self._ticks.append(tick)
        self._drones.append(drone)
        self._kind_numbers.append(number)

    def _remember(self, types: tuple[Any, ...], signature: str, number: int) -> None:
        """Let requests with this verb and these types find their kind without a signature, if they can."""
        if _SCALARS.issuperset(signature) and {bool, int, float}.issuperset(types[1:]):
            self._scalar_kinds[types] = number
        elif signature.endswith("y") and _SCALARS.issuperset(signature[:-1]) and types[-1] is bytes:
            self._bytes_kinds[types] = number

    def add_blocks(self, tick: int, drones: NDArray[np.int32], verb: str, blocks: bytes, size: int) -> None:
        """Write down one request of several drones each, whose argument is a block of bytes.

        Args:
            tick: When (ms).
            drones: Their numbers, shape (n,).
            verb: What was asked for.
            blocks: One block behind the other.
            size: Bytes of each.
        """
        if not self.is_kept:
            return
        number = self._number(verb, "y")
        kind = self._kinds[number]
        count = len(drones)
        # columns are appended to as arrays, a copy of memory each: lists would be looked through number by number
        kind.numbers.extend(array("d", [size]) * count)
        kind.blob += blocks
        self._ticks.extend(array("q", [tick]) * count)
        self._drones.frombytes(drones.tobytes())
        self._kind_numbers.extend(array("i", [number]) * count)

    def _number(self, verb: str, signature: str) -> int:
        key = (verb, signature)
        if key not in self._number_of:
            self._number_of[key] = len(self._kinds)
            self._kinds.append(_Kind(verb, signature))
        return self._number_of[key]

    def __iter__(self) -> Iterator[Request]:
        cursors = [_Cursor(kind) for kind in self._kinds]
        for tick, drone, number in zip(self._ticks, self._drones, self._kind_numbers, strict=True):
            yield Request(tick, drone, self._kinds[number].verb, cursors[number].next())

    def copy(self) -> Journal:
        """Return a journal that goes on by itself."""
        other = Journal(self.recipe)
        other.gap = self.gap or (_FORGOTTEN if self.forgotten else None)
        other.is_kept = self.is_kept
        other.samples = list(self.samples)
        other._ticks, other._drones = self._ticks[:], self._drones[:]
        other._kind_numbers = self._kind_numbers[:]
        other._kinds = [kind.copy() for kind in self._kinds]
        other._number_of = dict(self._number_of)
        other._scalar_kinds = dict(self._scalar_kinds)
        other._bytes_kinds = dict(self._bytes_kinds)
        return other

    # ---------------------------------------------------------------- as members of a file

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the journal as arrays for a file; `from_arrays` reads them."""
        about = {
            "recipe": self.recipe,
            "gap": self.gap,
            "kinds": [[kind.verb, kind.signature] for kind in self._kinds],
            "numbers": [len(kind.numbers) for kind in self._kinds],
            "bytes": [len(kind.blob) for kind in self._kinds],
        }
        columns = [np.frombuffer(kind.numbers, np.float64) for kind in self._kinds if kind.numbers]
        return {
            "about": np.array(json.dumps(about)),
            "ticks": np.array(self._ticks, np.int64),
            "drones": np.array(self._drones, np.int32),
            "kinds": np.array(self._kind_numbers, np.int32),
            "numbers": np.concatenate(columns) if columns else np.empty(0),
            "blob": np.frombuffer(b"".join(kind.blob for kind in self._kinds), np.uint8),
            "samples": np.array(self.samples, np.int64),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], trusted: bool = False) -> Journal:
        """Read what `to_arrays` wrote.

        Args:
            arrays: What it wrote.
            trusted: Whether this process wrote them, so that nothing is checked.

        Raises:
            ValueError: If the arrays are no journal.
            KeyError: If one of them is missing.
        """
        about = json.loads(str(arrays["about"]))
        journal = cls(about["recipe"])
        journal.gap = about["gap"]
        journal.samples = [int(sample) for sample in arrays["samples"]]
        journal._ticks = array("q", arrays["ticks"].astype(np.int64).tobytes())
        journal._drones = array("i", arrays["drones"].astype(np.int32).tobytes())
        journal._kind_numbers = array("i", arrays["kinds"].astype(np.int32).tobytes())
        columns = arrays["numbers"].astype(np.float64)
        blob = arrays["blob"].astype(np.uint8).tobytes()
        for (verb, signature), n_numbers, n_bytes in zip(about["kinds"], about["numbers"], about["bytes"], strict=True):
            kind = journal._kinds[journal._number(str(verb), str(signature))]
            kind.numbers.frombytes(columns[:n_numbers].tobytes())
            kind.blob += blob[:n_bytes]
            columns, blob = columns[n_numbers:], blob[n_bytes:]
        if not trusted:
            journal._check()
        return journal

    def _check(self) -> None:
        """Refuse columns that do not fit together, so that readers of the journal need not check them."""
        lengths = {len(self._ticks), len(self._drones), len(self._kind_numbers)}
        if len(lengths) != 1 or any(not 0 <= number < len(self._kinds) for number in self._kind_numbers):
            raise ValueError("the columns of the journal do not fit together")
        if any(later < earlier for earlier, later in zip(self._ticks, self._ticks[1:], strict=False)):
            raise ValueError("the ticks of the journal run backwards")
        try:
            sum(1 for _ in self)
        except (IndexError, OverflowError, RecursionError, UnicodeDecodeError) as error:
            raise ValueError(f"a request of the journal is cut off: {error}") from error


def _are_exact(values: Sequence[float]) -> bool:
    return all(abs(value) <= _EXACT for value in values)


def _signature(value: Any) -> str:
    """Return the types of plain data: b i f for a boolean, whole and other number, s y j n for text, bytes, JSON, None.

    Raises:
        TypeError: If it is no plain data.
    """
    code = _CODES.get(type(value))
    if code is not None:
        return code
    if isinstance(value, np.bool_):
        return "b"
    if isinstance(value, numbers.Integral):
        return "i" if abs(int(value)) <= _EXACT else "j"
    if isinstance(value, numbers.Real):
        return "f"
    if isinstance(value, str):
        return "s"
    if isinstance(value, bytes | bytearray):
        return "y"
    if value is None:
        return "n"
    if isinstance(value, list | tuple):
        return f"[{''.join(_signature(item) for item in value)}]"
    if isinstance(value, Mapping):
        json.dumps(value)
        return "j"
    raise TypeError(f"a {type(value).__name__}")


def _store(value: Any, kind: _Kind) -> None:
    """Append plain data to the columns of its kind."""
    code = _signature(value)
    if code in _SCALARS:
        kind.numbers.append(value)
    elif code[0] == "[":
        for item in value:
            _store(item, kind)
    elif code != "n":
        raw = bytes(value) if code == "y" else (value if code == "s" else json.dumps(value)).encode()
        kind.numbers.append(len(raw))
        kind.blob += raw


class _Cursor:
    """Reads the requests of a kind one after the other."""

    def __init__(self, kind: _Kind) -> None:
        self._kind = kind
        self._number = 0
        self._byte = 0

    def next(self) -> tuple[Any, ...]:
        codes = iter(self._kind.signature)
        return tuple([self._value(code, codes) for code in codes])

    def _value(self, code: str, codes: Iterator[str]) -> Any:
        if code == "[":
            items = []
            while (inner := next(codes, "")) != "]":
                items.append(self._value(inner, codes))
            return items
        if code not in _CODES_OF_VALUES:
            raise IndexError("a signature is cut off")
        if code == "n":
            return None
        number = self._kind.numbers[self._number]
        self._number += 1
        if code == "f":
            return number
        if code in "bi":
            return bool(number) if code == "b" else int(number)
        end = self._byte + int(number)
        if not self._byte <= end <= len(self._kind.blob):
            raise IndexError("bytes are missing")
        raw = bytes(self._kind.blob[self._byte : end])
        self._byte = end
        if code == "y":
            return raw
        return raw.decode() if code == "s" else json.loads(raw)
