"""A motor that is weak, or stands still."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.rules import Number, Whole, ruled

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World

MOTORS = 4


@dataclass(frozen=True, kw_only=True)
class MotorFault(Fault):
    """A motor gives a share of its thrust and torque; with none at all it also stops turning."""

    kind: ClassVar[str] = "motor"

    motor: int | None = ruled(Whole(1, MOTORS), None)
    """1 front right, 2 back right, 3 back left, 4 front left; without it, all four."""

    efficiency: float = ruled(Number(0.0, 2.0), 0.0)
    """Share of thrust and torque that is left; 0 stops the rotor."""

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Take it its share."""
        self._set(drone, self.efficiency)

    def end(self, world: World, drone: Drone) -> None:
        """Let it do what it was built for."""
        self._set(drone, 1.0)

    def _set(self, drone: Drone, efficiency: float) -> None:
        for motor in range(MOTORS) if self.motor is None else [self.motor - 1]:
            check(drone.uplink.dispatch("cf_inject_motor", motor, efficiency), f"{drone.id}: motor {motor + 1}")
