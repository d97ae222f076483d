"""What happens to drones at instants: collisions, faults, losses. The recorder keeps them beside the signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Event:
    """Something that happened at an instant."""

    time: float
    """Simulated time (s)."""
    kind: str
    """One word, such as ``collision`` or ``fault``."""
    drone: str | None = None
    """Name of the drone; None concerns the whole world."""
    details: Mapping[str, Any] = field(default_factory=dict)
    """What JSON can hold."""

    def as_dict(self) -> dict[str, Any]:
        """Return the event as a log file keeps it."""
        return asdict(self)
