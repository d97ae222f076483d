"""`RadioHandlerFPQR`: thrust and body rates."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from crazychoir_fw.common.finite import finite
from crazychoir_fw.onboard.thrust import ThrustWord
from crazychoir_fw.radio.agents import AgentId, Uris
from crazychoir_fw.radio.limits import limited
from crazychoir_fw.radio.thrusting import ThrustDrone, ThrustHandler

_RATE, _ANGLE = 0, 1


class FPQRDrone(ThrustDrone):
    """Takes thrust and body rates."""

    # yaw too: another program may have left it at angles
    presets: ClassVar[Mapping[str, Any]] = {
        "flightmode.stabModeRoll": _RATE,
        "flightmode.stabModePitch": _RATE,
        "flightmode.stabModeYaw": _RATE,
    }
    max_rate: float
    """Largest rate about x and y (rad/s)."""
    max_yaw_rate: float
    """Largest rate about z (rad/s)."""

    def command(self, f: float, p: float, q: float, r: float) -> bool:
        """Give a command; it is repeated until the next one, or until the command time-out.

        Args:
            f: Thrust of all rotors (N), along body z.
            p: Body rate about x (rad/s), to the right.
            q: Body rate about y (rad/s), nose down.
            r: Body rate about z (rad/s), to the left.

        Returns:
            Whether it is taken; not before `takeoff`.

        Raises:
            RangeError: If one of them is no finite number.
        """
        f, p, q, r = finite(self._call("command"), f=f, p=p, q=q, r=r)
        thrust = self.thrust.raw(f)
        roll = math.degrees(limited(p, self.max_rate))
        pitch = math.degrees(limited(q, self.max_rate))  # cflib negates it: positive lifts the nose on board
        yaw = -math.degrees(limited(r, self.max_yaw_rate))  # the drone negates it: positive turns right in this packet
        return self._flight.give(lambda cf: cf.commander.send_setpoint(roll, pitch, yaw, thrust))


class RadioHandlerFPQR(ThrustHandler):
    """Flies drones by thrust (N) and body rates (rad/s); the twin of `MotorCtrlFPQR`."""

    drone_class = FPQRDrone
    defaults: ClassVar[Mapping[str, Any]] = {"command_timeout_s": 0.2, "on_silence": "level"}

    def __init__(
        self,
        uris: Uris,
        agent_ids: Iterable[AgentId] | None = None,
        *,
        thrust: ThrustWord | Mapping[AgentId, ThrustWord] = "cf2",
        weight: float | Mapping[AgentId, float] | None = None,
        max_rate: float = math.radians(720.0),
        max_yaw_rate: float = math.radians(450.0),
        **options: Any,
    ) -> None:
        """Prepare; `connect`, or a ``with`` statement, connects.

        Args:
            uris: URIs in a list, or by agent.
            agent_ids: Agents of a list of URIs.
            thrust: Calibration of the thrust, or one for each agent: see `ThrustCalibration`.
            weight: Weight (N), or one for each agent, for leveling out; that of the platform without.
            max_rate: Largest rate about x and y (rad/s); more is cut.
            max_yaw_rate: Largest rate about z (rad/s); more is cut.
            options: See `Options`.

        Raises:
            RangeError: If a value is out of its range.
            UnknownNameError: If there is no such platform, agent or option.
        """
        limits = {"max_rate": max_rate, "max_yaw_rate": max_yaw_rate}
        super().__init__(uris, agent_ids, thrust, weight, limits, options)
