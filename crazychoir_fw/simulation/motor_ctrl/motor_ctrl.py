"""`MotorCtrl`: the program that flies one drone of a simulated world, and the parent of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.motor_ctrl.devices import Devices
from crazychoir_fw.simulation.world_base import WorldBase

SafeZone = tuple[Sequence[float], Sequence[float]]

_NULL = bytes(ffi.sizeof("setpoint_t"))
_STAMP = slice(ffi.offsetof("setpoint_t", "timestamp"), ffi.offsetof("setpoint_t", "timestamp") + 4)


class MotorCtrl(Devices):
    """Flies one drone: reads its devices, receives a command, and writes it as a setpoint of the onboard software.

    A subclass overrides `step`, which is called `rate_hz` times per simulated second while the motors may run::

        class Hover(MotorCtrlFPQR):
            rate_hz = 100

            def step(self):
                self.command(self.weight - 0.3 * self.velocity[2], *(-4.0 * self.roll_pitch_yaw))

    The subclasses in `commands.py` bring a `command` each. Another setpoint of the firmware's commander is written
    with `send`. A subclass that raises stops its own drone: motors off, `Drone.failure` says why.

    The last setpoint and the latch of `stop` live in the drone, so that a restored snapshot flies on with the same
    bits. What a subclass remembers itself is its own affair: `init` is called again when the world is reset,
    `restored` when it goes back to a snapshot.
    """

    rate_hz: ClassVar[int] | int = 100
    """Steps per simulated second; a divisor of 1000. `init` may set another one, ``self.rate_hz = 50``."""

    keep_alive_s: float | None = None
    """How long the last command is repeated to the onboard software (s): None without end, 0 not at all. Then the
    firmware's watchdog takes over: level after 0.5 s without a setpoint, locked after 2 s."""

    safe_zone: SafeZone | None = None
    """Lowest and highest corner of a box (m, world); a drone that leaves it is stopped. None is no limit."""

    arms: bool = True
    """Whether a drone that must be armed is armed as soon as it can be."""

    controllers: ClassVar[tuple[str, ...] | None] = None
    """Controllers of the built-in provider that follow these setpoints; None when it does not matter."""

    others: ClassVar[str] = ""
    """What the other controllers lack, for the message that refuses them."""

    # ---------------------------------------------------------------- to be overridden

    def init(self, drone: Drone, properties: Mapping[str, str]) -> None:
        """Called once before the flight, and again when the world is reset.

        Args:
            drone: The drone, also as `self.drone`.
            properties: The words ``key=value`` of ``motor_ctrl_properties``, also as `self.properties`.
        """

    def step(self) -> None:
        """Called at the rate of the class while the motors may run: read devices, give a command."""

    def restored(self) -> None:
        """Called when the world went to another time without a reset: forget what is no longer true."""

    # ---------------------------------------------------------------- commands

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Give a command in the vocabulary of a Twist, shape (3,) each; the classes with a `command` say what it is.

        Raises:
            StateError: If this class knows no such command.
        """
        del linear, angular
        raise StateError(f"{self._who('cmd_vel')}: this class takes no such command")

    def new_setpoint(self) -> Any:
        """Return an empty setpoint, a cffi pointer to the firmware's ``setpoint_t`` (degrees, legacy pitch).

        Sent as it is, with all modes disabled, it is a `stop`.
        """
        return ffi.new("setpoint_t *")

    def send(self, setpoint: Any) -> None:
        """Hand a setpoint to the onboard software, and repeat it as `keep_alive_s` says.

        After `stop` it is dropped, until `resume`.

        Raises:
            RangeError: If a number of it is not finite.
            StateError: If the drone has failed.
        """
        if self.is_stopped:
            return
        setpoint.timestamp = self._stamp
        self._request(bytes(ffi.buffer(setpoint)))

    # ---------------------------------------------------------------- stop

    @property
    def is_stopped(self) -> bool:
        """Whether `stop` has been called and `resume` has not."""
        data = self._client_setpoint
        return data[_STAMP] != _NULL[_STAMP] and data[4:] == _NULL[4:]

    def stop(self) -> None:
        """Stop the motors, and drop all commands until `resume`. A drone that had to be armed is disarmed."""
        setpoint = self.new_setpoint()
        setpoint.timestamp = self._stamp
        self._request(bytes(ffi.buffer(setpoint)))
        if self._must_be_armed:
            self.drone.uplink.request("cf_arm", False)
        self.world.note("stop", self.drone.id)

    def resume(self) -> None:
        """Take commands again. What was commanded before the stop is forgotten."""
        if self.is_stopped:
            # without its stamp it is not ours: not repeated, and no latch
            self._request(_NULL)
            # the planner, at rest, keeps the watchdog quiet until the next command
            self.drone.uplink.request("cf_notify_setpoint_stop")

    # ---------------------------------------------------------------- life, for the world

    def attach(self, world: WorldBase, drone: Drone, properties: Mapping[str, str]) -> None:
        """Bind to a drone; the world calls this.

        Raises:
            RangeError: If the class asks for something impossible; the message names drone, value and what is allowed.
        """
        self.world, self.drone = world, drone
        self.properties = {key: str(value) for key, value in properties.items()}
        self._client = ffi.buffer(ffi.addressof(drone.struct.onboard, "client_setpoint"))
        facts = lib.cf_platform_facts(drone.struct.config.platform)
        self._max_thrust = 4.0 * float(facts.thrust.thrust_max)
        self._must_be_armed = bool(facts.requires_arming)
        self._check_controller()
        self.init(drone, self.properties)
        rate = self.rate_hz
        if isinstance(rate, bool) or not isinstance(rate, int) or not (1 <= rate <= 1000 and 1000 % rate == 0):
            raise RangeError(f"{self._who('rate_hz')} is {rate!r}, allowed: a divisor of 1000")
        self._zone = self._checked_zone()

    def advance(self) -> None:
        """One step of its life: the world calls this at the rate of the class."""
        drone = self.drone
        if drone.struct.onboard.fault != lib.CF_FAULT_NONE:
            return
        if self.is_stopped:
            self._repeat()
            return
        if drone.can_fly:
            if self._zone is not None and not self._is_in_zone():
                position = [round(float(value), 4) for value in self.position]
                self.world.note("safe_zone", drone.id, position=position)
                self.stop()
                return
            self.step()
        elif self.arms and self._must_be_armed and drone.can_arm:
            drone.arm()
        self._repeat()

    def _repeat(self) -> None:
        """Keep the last command alive, unless it is of this very tick, too old, or another client's."""
        data = self._client_setpoint
        given = int.from_bytes(data[_STAMP], "little")
        if given in (0, self._stamp):
            return
        is_stop = data[4:] == _NULL[4:]
        age = (self._stamp - given) % 2**32 / 1000.0
        if is_stop or self.keep_alive_s is None or age < self.keep_alive_s:
            self._request(data)

    # ---------------------------------------------------------------- parts

    @property
    def _stamp(self) -> int:
        """The tick, as the setpoint remembers it; 0 means that it is not from here."""
        return self.world.tick % 2**32 or 1

    @property
    def _client_setpoint(self) -> bytes:
        """The last setpoint of a client, from the memory of the drone."""
        return bytes(self._client)

    def _request(self, data: bytes) -> None:
        status = self.drone.uplink.request("setpoint", data)
        if status != lib.CF_OK:
            check(status, self._who("setpoint"))

    def _who(self, what: str) -> str:
        return f"{self.drone.id}: {type(self).__name__}: {what}"

    def _check_controller(self) -> None:
        config = self.drone.config
        chosen = config.controller or "pid"
        is_ours = config.provider == "builtin" and not config.app
        if self.controllers is not None and is_ours and chosen not in self.controllers:
            because = f" ({self.others})" if self.others else ""
            raise RangeError(
                f"{self._who('controller')} is '{chosen}', allowed: {', '.join(self.controllers)}{because}"
            )

    def _checked_zone(self) -> np.ndarray | None:
        zone = self.properties.get("safe_zone", self.safe_zone)
        if zone is None:
            return None
        if isinstance(zone, str):
            zone = zone.split(",")
        try:
            box = np.array(zone, float).reshape(2, 3)
        except (TypeError, ValueError):
            box = np.full((2, 3), np.nan)
        if not (np.all(np.isfinite(box)) and np.all(box[0] < box[1])):
            raise RangeError(
                f"{self._who('safe_zone')} is {zone!r}, allowed: lowest and highest corner, six finite numbers (m)"
            )
        return box

    def _is_in_zone(self) -> bool:
        position = self.position
        return bool(np.all(position >= self._zone[0]) and np.all(position <= self._zone[1]))
