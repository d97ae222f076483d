"""Every kind of fault but that of the radio: motor, inertial sensors, positioning, battery, payload, kick, gust."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from crazychoir_fw.common.constraints import Constraint, choice, constrained, number, point, switch, whole
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.faults.fault import Fault, longest_delay

MOTORS = 4

_RAD_PER_DEG = math.pi / 180.0
_M_PER_S2_PER_G = 9.81
_SENSORS = {"gyro": (0, _RAD_PER_DEG), "acc": (3, _M_PER_S2_PER_G)}  # first bit of its axes, SI units in its own


def _within(largest: float, unit: str) -> Constraint:
    return point("x", "y", "z", low=-largest, high=largest, unit=unit)


@dataclass(frozen=True, kw_only=True)
class MotorFault(Fault):
    """A motor gives a share of its thrust and torque; with none at all it also stops turning."""

    kind: ClassVar[str] = "motor"

    motor: int | None = constrained(whole(1, MOTORS), None)
    """1 front right, 2 back right, 3 back left, 4 front left; without it, all four."""

    efficiency: float = constrained(number(0.0, 2.0), 0.0)
    """Share of thrust and torque that is left; 0 stops the rotor."""

    def begin(self, drone: Drone, seed: int) -> None:
        """Take it its share."""
        self._set(drone, self.efficiency)

    def end(self, drone: Drone) -> None:
        """Let it do what it was built for."""
        self._set(drone, 1.0)

    def _set(self, drone: Drone, efficiency: float) -> None:
        for motor in range(MOTORS) if self.motor is None else [self.motor - 1]:
            check(drone.uplink.dispatch("cf_inject_motor", motor, efficiency), f"{drone.id}: motor {motor + 1}")


@dataclass(frozen=True, kw_only=True)
class ImuFault(Fault):
    """Readings of the gyroscope or the accelerometer go wrong, on one axis or on all.

    A second fault on the same axes replaces the first one.
    """

    kind: ClassVar[str] = "imu"

    sensor: str = constrained(choice("gyro", "acc"), "gyro")
    """``gyro`` or ``acc``."""

    axis: str = constrained(choice("x", "y", "z", "all"), "all")
    """``x``, ``y``, ``z`` or ``all``."""

    stuck: bool = constrained(switch(), False)
    """The first reading of the fault is given again and again."""

    bias: float = constrained(number(-4000.0, 4000.0, "deg/s or g"), 0.0)
    """Added to the readings (deg/s, or g)."""

    noise: float = constrained(number(0.0, 4000.0, "deg/s or g"), 0.0)
    """Standard deviation of white noise that is added to each reading, 1000 times a second (deg/s, or g)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.stuck or self.bias or self.noise):
            raise RangeError("imu: nothing is wrong with it; allowed: stuck, bias or noise")
        if self.stuck and (self.bias or self.noise):
            raise RangeError("imu: a stuck sensor shows neither bias nor noise")

    def begin(self, drone: Drone, seed: int) -> None:
        """Spoil the readings."""
        self._inject(drone, self.stuck, self.bias, self.noise, seed)

    def end(self, drone: Drone) -> None:
        """Show the true readings again."""
        self._inject(drone, False, 0.0, 0.0, 0)

    def _inject(self, drone: Drone, stuck: bool, bias: float, noise: float, seed: int) -> None:
        first, unit = _SENSORS[self.sensor]
        axes = 7 if self.axis == "all" else 1 << "xyz".index(self.axis)
        fault = [[axes << first, stuck, bias * unit, noise * unit]]
        check(drone.uplink.dispatch("cf_inject_imu", fault, seed), f"{drone.id}: imu fault")


@dataclass(frozen=True, kw_only=True)
class PositioningFault(Fault):
    """The system that is fitted sees nothing of the drone, or what it saw arrives later.

    Any of them can be lost: motion capture, lighthouse, loco, the flow deck. Only motion capture can be late: the
    others are measured on board.
    """

    kind: ClassVar[str] = "positioning"

    lost: bool = constrained(switch(), False)
    """No measurement at all."""

    delay: float = constrained(number(0.0, 1.0, "s"), 0.0)
    """Added to the latency (s): at 100 poses per second at most 0.31 with the latency of 0.008 that there is."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lost == (self.delay > 0.0):
            raise RangeError("positioning: allowed: either lost, or a delay above 0")

    def check(self, drone: Drone) -> None:
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
            longest = longest_delay(drone)
            if self.delay > longest + 1e-9:
                raise RangeError(f"{drone.id}: delay is {self.delay} s, allowed at this rate: {longest:.3f} s or less")

    def begin(self, drone: Drone, seed: int) -> None:
        """Lose or delay."""
        if self.lost:
            check(drone.uplink.dispatch("cf_inject_positioning_loss", True), f"{drone.id}: lost positioning")
        else:
            late = round(self.delay * TICKS_PER_SECOND)
            check(drone.uplink.dispatch("cf_inject_positioning_delay", late), f"{drone.id}: late positioning")

    def end(self, drone: Drone) -> None:
        """See again, or in time again."""
        if self.lost:
            drone.uplink.dispatch("cf_inject_positioning_loss", False)
        else:
            drone.uplink.dispatch("cf_inject_positioning_delay", 0)


@dataclass(frozen=True, kw_only=True)
class BatteryFault(Fault):
    """The battery loses charge, gets a bad contact, or is cut.

    A cut drone is without power: its motors run down and its software ends. Connected again it waits for a reboot. What
    is lost of the charge does not come back at the end of the fault.
    """

    kind: ClassVar[str] = "battery"

    charge: float | None = constrained(number(0.0, 1.0), None)
    """State of charge that the battery jumps to."""

    resistance: float = constrained(number(0.0, 10.0, "Ohm"), 0.0)
    """Resistance of the bad contact (Ohm)."""

    cut: bool = constrained(switch(), False)
    """The battery falls off."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.charge is None and not self.resistance and not self.cut:
            raise RangeError("battery: nothing is wrong with it; allowed: charge, resistance or cut")

    def begin(self, drone: Drone, seed: int) -> None:
        """Let it fail."""
        if self.charge is not None:
            check(drone.uplink.dispatch("cf_inject_battery_charge", self.charge), f"{drone.id}: charge")
        if self.resistance:
            check(drone.uplink.dispatch("cf_inject_battery_resistance", self.resistance), f"{drone.id}: resistance")
        if self.cut:
            drone.uplink.dispatch("cf_inject_battery_cut", True)

    def end(self, drone: Drone) -> None:
        """Repair the contact."""
        if self.resistance:
            drone.uplink.dispatch("cf_inject_battery_resistance", 0.0)
        if self.cut:
            drone.uplink.dispatch("cf_inject_battery_cut", False)


@dataclass(frozen=True, kw_only=True)
class PayloadDrop(Fault):
    """The drone lets go of what it carries: the equality constraint ``<drone>/payload`` of the model ends."""

    kind: ClassVar[str] = "payload"
    is_instant: ClassVar[bool] = True

    def check(self, drone: Drone) -> None:
        """Refuse a drone that carries nothing which it could drop.

        Raises:
            StateError: If there is no such constraint.
        """
        if not drone.has_hook:
            raise StateError(f"{drone.id}: carries no detachable payload")

    def begin(self, drone: Drone, seed: int) -> None:
        """Let go."""
        drone.uplink.dispatch("drop_payload")


@dataclass(frozen=True, kw_only=True)
class Kick(Fault):
    """Something knocks against the drone: its velocity and its spin change at once."""

    kind: ClassVar[str] = "kick"
    is_instant: ClassVar[bool] = True

    impulse: tuple[float, float, float] = constrained(_within(1.0, "N s"), (0.0, 0.0, 0.0))
    """Force times time (N s): 0.03 moves a Crazyflie of 30 g by 1 m/s."""

    point: tuple[float, float, float] = constrained(_within(1.0, "m"), (0.0, 0.0, 0.0))
    """Where it hits (m, body frame); off the center of mass it also turns the drone."""

    frame: str = constrained(choice("world", "body"), "world")
    """Frame of the impulse: ``world`` or ``body``."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not any(self.impulse):
            raise RangeError("kick: impulse is missing, allowed: one that is not zero")

    def begin(self, drone: Drone, seed: int) -> None:
        """Hit."""
        drone.uplink.dispatch("kick", list(map(float, self.impulse)), list(map(float, self.point)), self.frame)


@dataclass(frozen=True, kw_only=True)
class Gust(Fault):
    """The wind rises to a velocity and falls again, as one minus a cosine over the duration."""

    kind: ClassVar[str] = "gust"

    duration: float = constrained(number(0.001, 3600.0, "s"), 1.0)
    """From calm to calm (s)."""

    velocity: tuple[float, float, float] = constrained(_within(50.0, "m/s"), (0.0, 0.0, 0.0))
    """Of the air at its height (m/s, world)."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not any(self.velocity):
            raise RangeError("gust: velocity is missing, allowed: one that is not zero")

    def begin(self, drone: Drone, seed: int) -> None:
        """Let it blow; it ends by itself."""
        velocity = [float(number) for number in self.velocity]
        ticks = round(self.duration * TICKS_PER_SECOND)
        check(drone.uplink.dispatch("cf_inject_gust", velocity, ticks), f"{drone.id}: gust")
