"""`RadioHandlerFRPY`: thrust and attitude."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from crazychoir_fw.common.finite import finite
from crazychoir_fw.onboard.thrust import ThrustWord
from crazychoir_fw.radio.agents import AgentId, Uris
from crazychoir_fw.radio.limits import limited
from crazychoir_fw.radio.thrusting import ThrustDrone, ThrustHandler

_ANGLE = 1


class FRPYDrone(ThrustDrone):
    """Takes thrust and attitude."""

    # roll and pitch too: another program may have left them at rates
    presets: ClassVar[Mapping[str, Any]] = {
        "flightmode.stabModeRoll": _ANGLE,
        "flightmode.stabModePitch": _ANGLE,
        "flightmode.stabModeYaw": _ANGLE,
    }
    max_tilt: float
    """Largest roll and pitch (rad)."""

    def command(self, f: float, roll: float, pitch: float, yaw: float) -> bool:
        """Give a command; it is repeated until the next one, or until the command time-out.

        Args:
            f: Thrust of all rotors (N), along body z.
            roll: Right-handed about x (rad): positive flies to the right.
            pitch: Right-handed about y (rad): positive lowers the nose and flies forward.
            yaw: Right-handed about z (rad): positive turns to the left.

        Returns:
            Whether it is taken; not before `takeoff`.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, roll, pitch, yaw = finite(self._call("command"), f=f, roll=roll, pitch=pitch, yaw=yaw)
        thrust = self.thrust.raw(f)
        roll = math.degrees(limited(math.remainder(roll, math.tau), self.max_tilt))
        # cflib negates it: positive lifts the nose on board
        pitch = math.degrees(limited(math.remainder(pitch, math.tau), self.max_tilt))
        yaw = math.degrees(math.remainder(yaw, math.tau))  # an angle, which the drone does not negate
        return self._flight.give(lambda cf: cf.commander.send_setpoint(roll, pitch, yaw, thrust))


class RadioHandlerFRPY(ThrustHandler):
    """Flies drones by thrust (N) and attitude (rad); the twin of `MotorCtrlFRPY`."""

    drone_class = FRPYDrone
    defaults: ClassVar[Mapping[str, Any]] = {"command_timeout_s": 0.5, "on_silence": "level"}

    def __init__(
        self,
        uris: Uris,
        agent_ids: Iterable[AgentId] | None = None,
        *,
        thrust: ThrustWord | Mapping[AgentId, ThrustWord] = "cf2",
        weight: float | Mapping[AgentId, float] | None = None,
        max_tilt: float = math.radians(60.0),
        **options: Any,
    ) -> None:
        """Prepare; `connect`, or a ``with`` statement, connects.

        Args:
            uris: URIs in a list, or by agent.
            agent_ids: Agents of a list of URIs.
            thrust: Calibration of the thrust, or one for each agent: see `ThrustCalibration`.
            weight: Weight (N), or one for each agent, for leveling out; that of the platform without.
            max_tilt: Largest roll and pitch (rad); more is cut.
            options: See `Options`.

        Raises:
            RangeError: If a value is out of its range.
            UnknownNameError: If there is no such platform, agent or option.
        """
        limits = {"max_tilt": max_tilt}
        super().__init__(uris, agent_ids, thrust, weight, limits, options)
