"""Port 0, the console: what the onboard software prints (docs/reference/crtp-cflib.md#11)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import Reply

PERIOD = 20
"""Ticks between two looks at the console."""

TEXT = 0
"""The only channel."""


class ConsoleService:
    """Sends every line when it is complete, or as soon as a packet is full.

    Only while there is a client: what was printed before it came is lost, as with a real drone.
    """

    ports = (Port.CONSOLE,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        onboard = context.drone.struct.onboard
        self._console = ffi.addressof(onboard, "console")
        self._onboard = onboard
        self._text = ffi.new("char[]", lib.CF_CONSOLE_BYTES)
        self._first = ffi.new("uint32_t *")
        self._has_client = False  # set by the radio thread
        # the rest belongs to the simulation thread
        self._cancel: Callable[[], None] | None = None
        self._seen = 0
        self._tick = 0
        self._begun_line = b""
        context.when_sought(lambda tick: self._forget())
        context.closing.callback(self._stop_looking)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Swallow it: nothing on board listens."""
        return ()

    def begin_session(self) -> None:
        """Listen to what is printed from now on."""
        self._has_client = True  # first: the simulation may look before this thread goes on
        if not self._context.later(self._begin):
            self._has_client = False

    def end_session(self) -> None:
        """Stop listening."""
        self._has_client = False

    def _begin(self) -> None:
        self._forget()
        if self._cancel is None:
            self._cancel = self._context.world.agenda.every(PERIOD, self._look)

    def _forget(self) -> None:
        self._seen = self._console.written
        self._tick = self._onboard.tick
        self._begun_line = b""

    def _look(self) -> None:
        if not self._has_client:
            self._stop_looking()
            return
        was_rebooted = self._onboard.tick < self._tick
        self._tick = self._onboard.tick
        if was_rebooted:
            self._seen, self._begun_line = 0, b""
        if self._console.written != self._seen:
            self._send_new()

    def _stop_looking(self) -> None:
        if self._cancel is not None:
            self._cancel()
            self._cancel = None

    def _send_new(self) -> None:
        count = lib.cf_console_read(self._console, self._seen, self._text, lib.CF_CONSOLE_BYTES, self._first)
        self._seen = (self._first[0] + count) & 0xFFFFFFFF
        text = self._begun_line + ffi.unpack(self._text, count)
        packets = list(packets_of(_as_ascii(text)))
        is_complete = not packets or packets[-1].endswith(b"\n") or len(packets[-1]) == MAX_PAYLOAD
        self._begun_line = b"" if is_complete else packets.pop()
        for packet in packets:
            self._context.send(Port.CONSOLE, TEXT, packet, droppable=True)


def packets_of(text: bytes) -> Iterator[bytes]:
    """Cut text after every end of a line, and where a packet is full."""
    for line in text.splitlines(keepends=True):
        for start in range(0, len(line), MAX_PAYLOAD):
            yield line[start : start + MAX_PAYLOAD]


def _as_ascii(text: bytes) -> bytes:
    """Replace what is none, because clients decode every packet by itself."""
    return text.decode("ascii", "replace").replace("\N{REPLACEMENT CHARACTER}", "?").encode()
