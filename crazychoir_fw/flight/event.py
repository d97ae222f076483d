"""`Event`: something that happened in a flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Event:
    """Something that happened in an experiment."""

    time: float
    kind: str
    """``takeoff``, ``start``, ``land``, ``landed``, ``stop``, ``failure``, ``lost``, ``rejoined``."""
    drone: str | None
    """Name of the drone; None for an event that concerns the whole flight."""
    details: str | Mapping[str, Any] = ""
    """A sentence, or what belongs to it, by name."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as an event of a flight log."""
        details = {"reason": self.details} if isinstance(self.details, str) and self.details else self.details
        return {
            "time": round(self.time, 4),
            "kind": self.kind,
            "drone": self.drone,
            "details": dict(details) if details else {},
        }
