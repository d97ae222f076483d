"""The radio of one drone: its socket, its client session, and its budget of packets."""

from __future__ import annotations

import socket
from collections import deque

from crazychoir_fw.crtp.client_session import Address, ClientSession
from crazychoir_fw.crtp.power_switch import PowerSwitch
from crazychoir_fw.crtp.server_statistics import PacketCounts
from crazychoir_fw.crtp.station import Station

LOG_RATE, LOG_BURST = 5000.0, 100.0
"""Log data and console text: 16 blocks at 100 Hz are 1600 packets a second; a client takes 5000 evenly, and bursts of
256 at most, replies among them (docs/reference/crtp-cflib.md#3.4)."""
REPLY_RATE, REPLY_BURST = 1000.0, 64.0
"""Answers by the clock on the wall: those beyond wait, in their order, because the socket of a client that sends a
thousand questions in a row holds 256 answers, and loses the rest."""
CLIENT_RATE, CLIENT_BURST = 20000.0, 2000.0
"""What the drone takes from its client."""
STRANGER_RATE, STRANGER_BURST = 1000.0, 200.0
"""What is looked at of all others."""
NEWCOMER_RATE, NEWCOMER_BURST = 1000.0, 200.0
"""Requests of all others to begin a session."""
PROBE_RATE, PROBE_BURST = 10.0, 2.0
"""Null packets to the client, to see whether it is still there when another client wants its drone."""
NOTE_RATE, NOTE_BURST = 1.0, 20.0
"""Events about sessions: a client that connects without end shall not fill the memory."""


class DroneRadio:
    """What the radio thread keeps for one drone; only it writes here, except where it says so."""

    def __init__(self, station: Station, opened: socket.socket, session: ClientSession) -> None:
        self.station = station
        self.name: str = station.context.drone.id
        self.socket = opened
        self.private: socket.socket | None = None
        """Hears and talks to its client alone, where the operating system can do that."""
        self.private_for: Address | None = None
        self.session = session
        self.power = PowerSwitch(station.context)
        self.counts = PacketCounts()
        self.is_open = False
        """Whether a session has begun."""
        self.heard_by_drone_at = 0.0
        """When a packet of the client came through the link to the drone (s)."""
        self.has_refused = False
        """Whether another client has been refused in this session."""
        self.has_output = False
        """Whether there is something to fetch from the services; set by any thread."""
        self.owes_relax = False
        """Whether a session has ended since the priority of set-points was relaxed; reset by the simulation thread."""
        self.unsent: deque[bytes] = deque()
        """Replies that the operating system did not take yet, or that were too many at once."""
        self.of_logs = TokenBucket(LOG_RATE, LOG_BURST)
        self.of_replies = TokenBucket(REPLY_RATE, REPLY_BURST)
        self.of_client = TokenBucket(CLIENT_RATE, CLIENT_BURST)
        self.of_strangers = TokenBucket(STRANGER_RATE, STRANGER_BURST)
        self.of_newcomers = TokenBucket(NEWCOMER_RATE, NEWCOMER_BURST)
        self.of_notes = TokenBucket(NOTE_RATE, NOTE_BURST)
        self.of_probes = TokenBucket(PROBE_RATE, PROBE_BURST)


class TokenBucket:
    """Lets bursts pass up to a size, and a steady stream up to a rate."""

    def __init__(self, rate: float, burst: float) -> None:
        """Begin full.

        Args:
            rate: Packets per second.
            burst: Packets at once.
        """
        self._rate = rate
        self._burst = burst
        self._left = burst
        self._filled_at = 0.0

    def take(self, now: float) -> bool:
        """Take one packet's worth at a time (s) that never goes back. Returns False when there is nothing left."""
        if self._left < self._burst:
            self._left = min(self._burst, self._left + (now - self._filled_at) * self._rate)
        self._filled_at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
