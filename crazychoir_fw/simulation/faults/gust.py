"""A gust of wind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Number, Vector, ruled

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class Gust(Fault):
    """The wind rises to a velocity and falls again, as one minus a cosine over the duration."""

    kind: ClassVar[str] = "gust"

    duration: float = ruled(Number(0.001, 3600.0, "s"), 1.0)
    """From calm to calm (s)."""

    velocity: tuple[float, float, float] = ruled(Vector(50.0, "m/s"), (0.0, 0.0, 0.0))
    """Of the air at its height (m/s, world)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not any(self.velocity):
            raise RangeError("gust: velocity is missing, allowed: one that is not zero")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Let it blow; it ends by itself."""
        velocity = [float(number) for number in self.velocity]
        ticks = round(self.duration * TICKS_PER_SECOND)
        check(drone.uplink.dispatch("cf_inject_gust", velocity, ticks), f"{drone.id}: gust")
