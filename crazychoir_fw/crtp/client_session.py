"""Client sessions of a drone: the rule for one client, for the next one, and for a second one.

UDP has no connections, and cflib says neither hello nor goodbye: each of its connections comes from a new address,
begins with a request for the link source that is never repeated, and ends with a set-point of zeros; in between it
pings ten times a second (docs/reference/crtp-cflib.md#2 to #4). Two clients cannot share a drone, because both number
their log blocks from 1. So a drone belongs to one address at a time:

- A free drone goes to the first client that sends a packet.
- It goes on to another one when its owner is gone: the operating system says that its socket is closed, or its last
  command was a set-point of zeros and then even its pings have ceased, or it has been silent for a second, as the radio
  of a real drone has it.
- Meanwhile it is not taken away. Packets of others are counted and ignored. But a request for the link source is kept,
  and answered when the owner is gone, because the client that sent it will not ask again. Several can wait, and none
  loses its place to another one: what was sent long ago, by a client that has gone, may be read late.
- With `newest_wins` such a request takes the drone at once.
"""

from __future__ import annotations

import enum

from crazychoir_fw.crtp.packet import MAX_PAYLOAD, NULL

Address = tuple[str, int]

SILENCE_S = 1.0
"""Silence timeout (s): after it a client counts as disconnected. The radio of a real drone waits as long."""
GOODBYE_S = 0.15
"""Silence (s) after a set-point of zeros that ends a session. A client that has closed its link sends nothing more,
while a connected one pings every 0.1 s."""

MAX_WAITING = 16
"""Clients that wait for one drone; of more the earliest is forgotten."""

_HEADER = 0xF3  # without the two reserved bits
_LINK_SOURCE = 0xF1
_ECHO = 0xF0
_NULL = NULL[0] & _HEADER
_GOODBYE = 0x30, bytes(14)


class Ruling(enum.Enum):
    """What becomes of a datagram."""

    TAKE = "take"
    """It is for the drone."""
    BEGIN = "begin"
    """It is for the drone, and the first of a session."""
    NULL = "null"
    """A null packet: its sender gets one back, and nothing else happens."""
    KEEP = "keep"
    """A newcomer waits for the drone."""
    REFUSE = "refuse"
    """The drone belongs to another client."""
    MALFORMED = "malformed"
    """It is no packet."""


def is_link_source(datagram: bytes) -> bool:
    """Tell whether a datagram is a request that begins a session."""
    return len(datagram) > 0 and datagram[0] & _HEADER == _LINK_SOURCE


class ClientSession:
    """The client session of one drone. It knows neither sockets nor the clock; times (s) never go back."""

    def __init__(self, silence_s: float = SILENCE_S, newest_wins: bool = False) -> None:
        self._silence_s = silence_s
        self._newest_wins = newest_wins
        self.address: Address | None = None
        """Address of the client that owns the session; None while the drone is free."""
        self.heard_at = 0.0
        """Time of the latest datagram from that client (s)."""
        self._waiting: dict[Address, bytes] = {}  # with the requests that they will not repeat, the latest at the end
        self._said_goodbye = False

    def hear(self, address: Address, datagram: bytes, now: float) -> Ruling:
        """Rule on a datagram. The caller does what the ruling says."""
        if not 1 <= len(datagram) <= 1 + MAX_PAYLOAD:
            return Ruling.MALFORMED
        kind = datagram[0] & _HEADER
        if address == self.address:
            self.heard_at = now
            if kind == _NULL:
                return Ruling.NULL
            if kind == _LINK_SOURCE:
                self._said_goodbye = False
                return Ruling.BEGIN
            if kind != _ECHO:
                self._said_goodbye = (kind, datagram[1:]) == _GOODBYE
            return Ruling.TAKE
        if kind == _NULL:
            return Ruling.NULL
        if kind != _LINK_SOURCE:
            if self._waiting or not (self.address is None or self.is_gone(now)):
                return Ruling.REFUSE
            self._give_to(address, now)
            return Ruling.BEGIN
        if self._newest_wins or self._is_free(now):
            self._give_to(address, now)
            return Ruling.BEGIN
        self.forget(address)
        self._waiting[address] = datagram
        if len(self._waiting) > MAX_WAITING:
            del self._waiting[next(iter(self._waiting))]
        return Ruling.KEEP

    def wait_for_answer(self, now: float) -> None:
        """Know that the owner is silent because we owe it an answer."""
        self.heard_at = now

    def is_gone(self, now: float) -> bool:
        """Tell whether the owner has been silent for too long."""
        return self.address is not None and now - self.heard_at > self._silence_s

    def next_in_line(self, now: float) -> bytes | None:
        """Hand the drone to a client that waits, if it is free. Returns the request to be answered."""
        if not (self._waiting and self._is_free(now)):
            return None
        # of several the latest: it is the most likely to be still there
        address, request = self._waiting.popitem()
        self._give_to(address, now)
        return request

    def forget(self, address: Address) -> None:
        """Remove a client from the queue."""
        self._waiting.pop(address, None)

    def leave(self) -> None:
        """Free the drone."""
        self.address = None
        self._said_goodbye = False

    def _is_free(self, now: float) -> bool:
        return self.address is None or self.is_gone(now) or (self._said_goodbye and now - self.heard_at > GOODBYE_S)

    def _give_to(self, address: Address, now: float) -> None:
        self.address = address
        self.heard_at = now
        self._said_goodbye = False
        self.forget(address)
