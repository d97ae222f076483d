"""A positioning system that loses a drone, or tells it late where it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Number, Switch, ruled

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class PositioningFault(Fault):
    """The system that is fitted sees nothing of the drone, or what it saw arrives later.

    Any of them can be lost: motion capture, lighthouse, loco, the flow deck. Only motion capture can be late: the
    others are measured on board.
    """

    kind: ClassVar[str] = "positioning"

    lost: bool = ruled(Switch(), False)
    """No measurement at all."""

    delay: float = ruled(Number(0.0, 1.0, "s"), 0.0)
    """Added to the latency (s): at 100 poses per second at most 0.31 with the latency of 0.008 that there is."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lost == (self.delay > 0.0):
            raise RangeError("positioning: allowed: either lost, or a delay above 0")

    def check(self, world: World, drone: Drone) -> None:
        """Refuse a drone without a positioning system, or without one that can be late.

        Raises:
            StateError: If the drone has none.
            RangeError: If more poses would be under way than the simulation remembers.
        """
        system = drone.config.positioning or "mocap"
        if system == "none":
            raise StateError(f"{drone.id}: has no positioning that could fail")
        if self.delay > 0.0:
            if not system.startswith("mocap"):
                raise StateError(f"{drone.id}: has positioning '{system}', but only motion capture can be late")
            mocap = drone.struct.config.vehicle.mocap
            longest = lib.CF_MOCAP_CAPACITY / max(mocap.rate, 1) - 0.001 * (mocap.latency_ms + 1)
            if self.delay > longest + 1e-9:
                raise RangeError(f"{drone.id}: delay is {self.delay} s, allowed at this rate: {longest:.3f} s or less")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Lose or delay."""
        if self.lost:
            check(drone.uplink.dispatch("cf_inject_positioning_loss", True), f"{drone.id}: lost positioning")
        else:
            late = round(self.delay * TICKS_PER_SECOND)
            check(drone.uplink.dispatch("cf_inject_positioning_delay", late), f"{drone.id}: late positioning")

    def end(self, world: World, drone: Drone) -> None:
        """See again, or in time again."""
        if self.lost:
            drone.uplink.dispatch("cf_inject_positioning_loss", False)
        else:
            drone.uplink.dispatch("cf_inject_positioning_delay", 0)
