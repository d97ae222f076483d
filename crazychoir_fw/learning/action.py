"""What a policy does: numbers in [-1, 1] become commands of the onboard software, one class per kind.

Every kind is affine: command = clip(offset + gain * action, low, high). That is all the exported C has to know.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning.reading import Floats, Reading
from crazychoir_fw.learning.swarm_port import SwarmPort
from crazychoir_fw.onboard.thrust import platform_max_thrust, platform_weight

FULL_THRUST = 65535.0
"""Thrust of a setpoint at full command."""


@dataclass(frozen=True)
class Scale:
    """command = clip(offset + gain * action, low, high), each of shape (A,), float32."""

    offset: Floats
    gain: Floats
    low: Floats
    high: Floats

    def of(self, action: NDArray[np.floating]) -> Floats:
        """Return commands, shape (N, A), of actions, shape (N, A)."""
        inside = np.clip(np.asarray(action, np.float32), np.float32(-1.0), np.float32(1.0))
        return np.clip(self.offset + self.gain * inside, self.low, self.high)


def _scale(offset: list[float], gain: list[float], low: list[float], high: list[float]) -> Scale:
    return Scale(*(np.array(numbers, np.float32) for numbers in (offset, gain, low, high)))


@dataclass(frozen=True)
class Action:
    """Base of all kinds; four numbers each."""

    kind = ""
    """How the exported C knows it."""
    size = 4

    def scale(self, platform: str) -> Scale:
        """Return how actions become commands on a platform (``cf2`` or ``cf21bl``)."""
        raise NotImplementedError

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Hand commands, shape (N, 4), to the onboard software of all drones."""
        raise NotImplementedError


@dataclass(frozen=True)
class _WithThrust(Action):
    thrust_span: float = 0.8
    """Thrust at action 1, beyond the weight, by the weight: 0.8 is 0.2 to 1.8 times the weight."""

    def _thrust(self, platform: str) -> tuple[float, float]:
        """Return counts at action 0, and per action."""
        if not 0.0 < self.thrust_span <= 3.0:
            raise RangeError(f"action: thrust_span is {self.thrust_span}, allowed: above 0 to 3")
        hover = platform_weight(platform) / platform_max_thrust(platform) * FULL_THRUST
        return hover, self.thrust_span * hover

    def _with_angles(self, platform: str, tilt: float, yaw: float) -> Scale:
        """Return the scale of thrust (counts), two angles or rates (rad, rad/s), and a yaw rate (rad/s)."""
        hover, span = self._thrust(platform)
        tilt, yaw = math.degrees(tilt), math.degrees(yaw)
        # without any thrust the PID controller forgets everything
        return _scale([hover, 0, 0, 0], [span, tilt, tilt, yaw], [1000, -tilt, -tilt, -yaw], [65535, tilt, tilt, yaw])


@dataclass(frozen=True)
class ThrustRates(_WithThrust):
    """Thrust and body rates; the rate loops on board fly them (collective thrust and body rates, CTBR)."""

    kind = "thrust_rates"
    max_rate: float = 6.0
    """Of roll and pitch (rad/s), at action 1."""
    max_yaw_rate: float = 3.0
    """(rad/s)."""

    def scale(self, platform: str) -> Scale:
        """Commands: thrust (counts), rates about x, y, z (deg/s, body, right-handed)."""
        return self._with_angles(platform, self.max_rate, self.max_yaw_rate)

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Send setpoints with thrust and rates."""
        del reading
        setpoint = port.setpoints
        setpoint["thrust"] = commands[:, 0]
        rate = setpoint["attitudeRate"]
        rate["roll"], rate["pitch"], rate["yaw"] = commands[:, 1], -commands[:, 2], commands[:, 3]
        port.send(roll=lib.modeVelocity, pitch=lib.modeVelocity, yaw=lib.modeVelocity)


@dataclass(frozen=True)
class Attitude(_WithThrust):
    """Thrust, roll, pitch and yaw rate; the attitude loops on board fly them."""

    kind = "attitude"
    max_tilt: float = 0.5
    """Roll and pitch (rad) at action 1."""
    max_yaw_rate: float = 3.0
    """(rad/s)."""

    def scale(self, platform: str) -> Scale:
        """Commands: thrust (counts), roll, pitch (deg, right-handed), yaw rate (deg/s)."""
        return self._with_angles(platform, self.max_tilt, self.max_yaw_rate)

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Send setpoints with thrust and angles."""
        del reading
        setpoint = port.setpoints
        setpoint["thrust"] = commands[:, 0]
        setpoint["attitude"]["roll"], setpoint["attitude"]["pitch"] = commands[:, 1], -commands[:, 2]
        setpoint["attitudeRate"]["yaw"] = commands[:, 3]
        port.send(roll=lib.modeAbs, pitch=lib.modeAbs, yaw=lib.modeVelocity)


@dataclass(frozen=True)
class Velocity(Action):
    """Velocity and yaw rate; the velocity loops on board fly them."""

    kind = "velocity"
    max_speed: float = 1.0
    """Per axis (m/s), at action 1."""
    max_yaw_rate: float = 3.0
    """(rad/s)."""

    def scale(self, platform: str) -> Scale:
        """Commands: velocity (m/s, world), yaw rate (deg/s)."""
        speed, yaw = self.max_speed, math.degrees(self.max_yaw_rate)
        ends = [speed, speed, speed, yaw]
        return _scale([0, 0, 0, 0], ends, [-end for end in ends], ends)

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Send setpoints with velocities."""
        self._send(port, commands[:, :3], commands[:, 3])

    def _send(self, port: SwarmPort, velocity: Floats, yaw_rate: Floats) -> None:
        speed = port.setpoints["velocity"]
        speed["x"], speed["y"], speed["z"] = velocity.T
        port.setpoints["attitudeRate"]["yaw"] = yaw_rate
        port.send(x=lib.modeVelocity, y=lib.modeVelocity, z=lib.modeVelocity, yaw=lib.modeVelocity)


@dataclass(frozen=True)
class Residual(Velocity):
    """A residual on a law: velocity = reference velocity + gain * (reference - estimate) + action."""

    kind = "residual"
    max_speed: float = 0.5
    gain: float = 2.0
    """Of the law (1/s)."""

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Send setpoints with the velocities of the law and of the policy together."""
        error = reading.reference.position - reading.estimate.position
        velocity = reading.reference.velocity + np.float32(self.gain) * error + commands[:, :3]
        self._send(port, velocity, commands[:, 3])


@dataclass(frozen=True)
class Motors(Action):
    """Duties of the four motors, as an onboard controller gives them: the battery is compensated behind them."""

    kind = "motors"
    span: float = 0.4
    """Share of full thrust that an action of 1 adds to hover, and -1 takes away."""

    def scale(self, platform: str) -> Scale:
        """Commands: share of full thrust of M1 to M4."""
        if not 0.0 < self.span <= 1.0:
            raise RangeError(f"action: span is {self.span}, allowed: above 0 to 1")
        hover = platform_weight(platform) / platform_max_thrust(platform)
        return _scale([hover] * 4, [self.span] * 4, [0.0] * 4, [1.0] * 4)

    def write(self, port: SwarmPort, commands: Floats, reading: Reading) -> None:
        """Hold the duties in place of the controller's."""
        del reading
        port.hold_motors(commands)


KINDS: dict[str, type[Action]] = {kind.kind: kind for kind in (ThrustRates, Attitude, Velocity, Residual, Motors)}
"""The kinds by name."""
