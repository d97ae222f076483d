"""What a drone does with commands."""

from __future__ import annotations

import enum


class Mode(str, enum.Enum):
    """What a drone does with commands."""

    LOCKED = "locked"
    """It takes none before `takeoff`."""
    READY = "ready"
    """It takes commands."""
    TAKING_OFF = "taking off"
    """The planner on board flies; commands are ignored until it is up."""
    LANDING = "landing"
    """The planner on board flies; commands are ignored."""
    LANDED = "landed"
    """Commands are ignored until `takeoff` or `resume`."""
    STOPPED = "stopped"
    """Motors off; commands are ignored until `resume`."""
    LOST = "lost"
    """The link was lost; commands are ignored until `resume` or `takeoff`."""

    def __str__(self) -> str:
        return self.value
