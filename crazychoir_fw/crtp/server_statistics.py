"""What a server counts."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass
class PacketCounts:
    """Packets of one drone since the server started."""

    received: int = 0
    """Datagrams received, of any kind and from any address."""
    taken: int = 0
    """Packets of its client that reached the drone."""
    replied: int = 0
    """Replies sent at once."""
    sent: int = 0
    """Other packets sent: log data, console text, late replies."""
    dropped: int = 0
    """Log data and console text that were not sent: a burst, a stall, or no client."""
    lost: int = 0
    """Replies that the operating system did not take."""
    refused: int = 0
    """Packets of others than its client."""
    rate_limited: int = 0
    """Datagrams that were not looked at because too many came."""
    malformed: int = 0
    """Datagrams that are no packets."""
    scans: int = 0
    """Null packets that were answered."""
    sessions: int = 0
    """Sessions that have begun."""
    errors: int = 0
    """Packets and changes at which a service failed."""


@dataclass(frozen=True)
class Statistics:
    """How a server does. Times are those of `Server.run`, without pauses."""

    sim_seconds: float = 0.0
    """Simulated time (s)."""
    wall_seconds: float = 0.0
    """Time on the wall (s)."""
    real_time_factor: float = 0.0
    """Simulated seconds per second."""
    recent_real_time_factor: float = 0.0
    """The same over the last second or so."""
    worst_lag_s: float = 0.0
    """Most that the simulation was behind the wall (s)."""
    dropped_lag_s: float = 0.0
    """Time (s) that was never caught up because it was too much."""
    resyncs: int = 0
    """How often that happened."""
    cpu_share: float = 0.0
    """Processor time of the whole process per second; 1 is one core."""
    drones: dict[str, PacketCounts] = field(default_factory=dict)
    """Packets by drone."""
    link: dict[str, Any] = field(default_factory=dict)
    """What the link counted, if it counts."""

    def as_dict(self) -> dict[str, Any]:
        """Return the statistics as a JSON file holds them."""
        return asdict(self)
