"""What a guidance asks for in one step."""

from __future__ import annotations

from dataclasses import dataclass

from crazychoir_fw.common.messages import Reference, TrajectoryPoint


@dataclass(frozen=True)
class Outputs:
    """Outputs of one step. A field that is None is not sent: its receiver keeps the latest value."""

    reference: Reference | None = None
    """To the controller of this drone, now."""
    trajectory: list[TrajectoryPoint] | None = None
    """To the trajectory handler of this drone, once."""
    idle: bool = False
    """The drone shall not fly: it stands before its take-off or after its landing, or was stopped. The component
    that drives the motors turns them off, and does not step controllers."""
