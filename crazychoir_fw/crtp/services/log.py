"""Port 5, the log service: what can be logged, and blocks of it sent again and again.

docs/reference/crtp-cflib.md#8.
"""

from __future__ import annotations

import errno
import functools
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from crazychoir_fw._core import lib
from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.log_sampler import Run, Value, sampler_of
from crazychoir_fw.crtp.services.reading_ahead import ReadingAhead
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.crtp.toc import LOG_BLOCKS, LOG_OPERATIONS, LOG_TYPES, log_toc
from crazychoir_fw.simulation.clients.variables import is_computed_when_read

TOC, CONTROL, DATA = range(3)
"""Channels."""

DELETE, START, STOP, RESET, CREATE, APPEND, START_MS = range(2, 9)
"""Commands of the control channel. 0 and 1 are of protocol versions below 4, which are not spoken."""

OK = 0

_ENTRY_BYTES = 3  # of a value in a request: type and id


class _Block:
    """What a client has put together."""

    def __init__(self) -> None:
        self.values: tuple[Value, ...] = ()
        self.bytes = 0
        self.run: Run | None = None
        self.single: Run | None = None
        """The latest request for one packet; it may wait for the simulation."""

    def stop(self) -> None:
        """Let it rest."""
        for run in (self.run, self.single):
            if run is not None:
                run.is_over = True
        self.run = self.single = None


class LogService:
    """The log blocks of one drone.

    Blocks belong to the radio thread, which answers at once. A start is handed to the simulation thread, which samples;
    stopping is done at once, see `log_sampler`.
    """

    ports = (Port.LOG,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self._toc = log_toc(context.drone.provider_number)
        self._reading = ReadingAhead(context, Port.LOG, self._toc)
        self._variables = log_variables(context.drone.provider_number)
        self._sampler = sampler_of(context.world)
        self._blocks: dict[int, _Block] = {}
        self._starting: dict[tuple[int, bool], Run] = {}  # by number, and whether it is for one packet
        self._lock = threading.Lock()  # of what is starting
        self._commands: dict[int, Callable[[int, bytes], int]] = {
            DELETE: self._delete,
            START: self._start,
            STOP: self._stop,
            CREATE: self._create,
            APPEND: self._append,
            START_MS: self._start_ms,
        }

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer from the table of contents, or change a block and say how that went."""
        if not payload:
            return ()
        if channel == TOC:
            return self._reading.receive(payload)
        if channel == CONTROL:
            return ((CONTROL, self._control(payload)),)
        return ()

    def end_session(self) -> None:
        """Delete all blocks."""
        self._reading.forget()
        for block in self._blocks.values():
            block.stop()
        self._blocks = {}
        self._sampler.changed()

    # ---------------------------------------------------------------- blocks

    def _control(self, payload: bytes) -> bytes:
        """Carry out a command and return command, number of the block and error."""
        command, number = payload[0], payload[1] if len(payload) > 1 else 0
        if command == RESET:
            self.end_session()
            return bytes((RESET, number, OK))
        carry_out = self._commands.get(command)
        # a command without its block is none; what the firmware does then is not known
        error = carry_out(number, payload[2:]) if carry_out is not None and len(payload) > 1 else errno.ENOEXEC
        return bytes((command, number, error))

    def _create(self, number: int, entries: bytes) -> int:
        if number in self._blocks:
            return errno.EEXIST
        if len(self._blocks) >= LOG_BLOCKS:
            return errno.ENOMEM
        self._blocks[number] = _Block()
        return self._append(number, entries)

    def _append(self, number: int, entries: bytes) -> int:
        """Add values up to the first one that cannot be added; bytes that make no whole entry are ignored."""
        block = self._blocks.get(number)
        if block is None:
            return errno.ENOENT
        free = LOG_OPERATIONS - sum(len(other.values) for other in self._blocks.values())
        values, size, error = list(block.values), block.bytes, OK
        for fetched, index in _entries(entries):
            size_of_value = lib.cf_log_value_bytes(fetched)
            error = self._reason_against(index, size_of_value, size, free)
            if error != OK:
                break
            variable = self._variables[index]
            values.append(Value(variable.offset, variable.stored, fetched, variable.is_computed_when_read))
            size += size_of_value
            free -= 1
        block.values, block.bytes = tuple(values), size
        if block.run is not None:
            block.run.values = block.values
            self._sampler.changed()
        return error

    def _reason_against(self, index: int, size_of_value: int, size: int, free: int) -> int:
        if size + size_of_value > lib.CF_LOG_VALUE_BYTES:
            return errno.E2BIG
        if free == 0:
            return errno.ENOMEM
        # raw memory (0xFFFF) is not served; types that do not exist are refused with an error that clients know
        if index >= len(self._variables) or size_of_value == 0:
            return errno.ENOENT
        return OK

    def _delete(self, number: int, rest: bytes) -> int:
        error = self._stop(number, rest)
        self._blocks.pop(number, None)
        return error

    def _stop(self, number: int, rest: bytes) -> int:
        block = self._blocks.get(number)
        if block is None:
            return errno.ENOENT
        block.stop()
        self._sampler.changed()
        return OK

    def _start(self, number: int, rest: bytes) -> int:
        return self._run(number, rest[0] * 10) if rest else errno.ENOEXEC

    def _start_ms(self, number: int, rest: bytes) -> int:
        return self._run(number, rest[0] | rest[1] << 8) if len(rest) >= 2 else errno.ENOEXEC

    def _run(self, number: int, period: int) -> int:
        block = self._blocks.get(number)
        if block is None:
            return errno.ENOENT
        run = Run(self._context, number, period, block.values)
        if not self._hand_over(run):
            return errno.ENOMEM
        if period == 0:
            block.single = run
        else:
            block.stop()
            block.run = run
            self._sampler.changed()
        return OK

    def _hand_over(self, run: Run) -> bool:
        """Let the simulation begin a run. However many starts come before it does, it is called once."""
        with self._lock:
            is_called = bool(self._starting)
            self._starting[run.number, run.period == 0] = run
        if is_called or self._context.later(self._begin_runs):
            return True
        with self._lock:
            self._starting.clear()
        return False

    def _begin_runs(self) -> None:
        with self._lock:
            runs = list(self._starting.values())
            self._starting.clear()
        for run in runs:
            if not run.is_over:
                self._sampler.add(run)


def _entries(data: bytes) -> Iterator[tuple[int, int]]:
    """Read type to send and id of every complete entry."""
    for at in range(0, len(data) - _ENTRY_BYTES + 1, _ENTRY_BYTES):
        yield data[at] & 0x0F, data[at + 1] | data[at + 2] << 8


class LogVariable(NamedTuple):
    """Where a variable is, and what must be done to read it."""

    offset: int
    """Place within ``cf_t`` (bytes)."""
    stored: int
    """Type, as the log service numbers them."""
    is_computed_when_read: bool
    """Whether the log variables are brought up to date first."""


@functools.cache
def log_variables(provider: int) -> tuple[LogVariable, ...]:
    """Return all log variables of drones with this provider."""
    return tuple(
        LogVariable(row.offset, LOG_TYPES[row.dtype.str[1:]], is_computed_when_read(row, provider))
        for row in log_toc(provider).variables
    )
