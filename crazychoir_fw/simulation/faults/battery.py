"""A battery that is low, badly connected, or gone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Number, Switch, ruled

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class BatteryFault(Fault):
    """The battery loses charge, gets a bad contact, or is cut.

    A cut drone is without power: its motors run down and its software ends. Connected again it waits for a reboot. What
    is lost of the charge does not come back at the end of the fault.
    """

    kind: ClassVar[str] = "battery"

    charge: float | None = ruled(Number(0.0, 1.0), None)
    """State of charge that the battery jumps to."""

    resistance: float = ruled(Number(0.0, 10.0, "Ohm"), 0.0)
    """Resistance of the bad contact (Ohm)."""

    cut: bool = ruled(Switch(), False)
    """The battery falls off."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.charge is None and not self.resistance and not self.cut:
            raise RangeError("battery: nothing is wrong with it; allowed: charge, resistance or cut")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Let it fail."""
        if self.charge is not None:
            check(drone.uplink.dispatch("cf_inject_battery_charge", self.charge), f"{drone.id}: charge")
        if self.resistance:
            check(drone.uplink.dispatch("cf_inject_battery_resistance", self.resistance), f"{drone.id}: resistance")
        if self.cut:
            drone.uplink.dispatch("cf_inject_battery_cut", True)

    def end(self, world: World, drone: Drone) -> None:
        """Repair the contact."""
        if self.resistance:
            drone.uplink.dispatch("cf_inject_battery_resistance", 0.0)
        if self.cut:
            drone.uplink.dispatch("cf_inject_battery_cut", False)
