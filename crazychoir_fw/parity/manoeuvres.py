"""The commands to drones of a comparison: legs with every kind of set-point, and the pilot that flies them."""

from __future__ import annotations

import bisect
import itertools
import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart
from crazychoir_fw.simulation.drone import Drone

PERIOD = 10
"""Time between two set-points of the pilot (ms)."""

_RPYT, _GENERIC, _HIGH_LEVEL = 3, 7, 8  # ports of packets
_CODE = 3  # where the answer to a high-level command says whether it was taken


@dataclass(frozen=True)
class Leg:
    """A stretch of a flight."""

    seconds: float
    begin: Callable[[Pilot], None] | None = None
    """Called once."""
    keep: Callable[[Pilot, float], None] | None = None
    """Called every 10 ms with the time since the begin (s)."""


class Pilot:
    """Flies one drone through its legs; commands that the drone refuses are counted and noted."""

    def __init__(self, drone: Drone, legs: Sequence[Leg]) -> None:
        self.drone = drone
        self.home = drone.true_position
        self.refused: list[str] = []
        self.start: int | None = None
        """Tick of the world at which the legs begin (ms); None while the drone cannot fly."""
        self._legs = list(legs)
        self._ends = list(itertools.accumulate(round(leg.seconds * 1000) for leg in legs))
        self.ticks = self._ends[-1]
        """What all legs together take (ms)."""

    @property
    def is_waiting(self) -> bool:
        """Whether the drone may still become able to fly."""
        return self.start is None and self.drone.struct.onboard.fault == lib.CF_FAULT_NONE

    def act(self, tick: int) -> None:
        """Send what is due at this time since the start (ms)."""
        if tick % PERIOD or tick >= self.ticks:
            return
        index = bisect.bisect_right(self._ends, tick)
        leg = self._legs[index]
        start = self._ends[index - 1] if index else 0
        try:
            if leg.begin is not None and tick == -(-start // PERIOD) * PERIOD:
                leg.begin(self)
            if leg.keep is not None:
                leg.keep(self, (tick - start) / 1000)
        except CrazychoirError as error:
            self.refused.append(f"{tick} ms: {error}")

    def place(self, dx: float, dy: float, z: float) -> tuple[float, float, float]:
        """Return a position (m, world) from one beside the home of this drone."""
        return float(self.home[0] + dx), float(self.home[1] + dy), z


# ------------------------------------------------------------------------------------------ legs


def _takeoff(pilot: Pilot) -> None:
    pilot.drone.high_level_commander.takeoff(0.6, 1.3, yaw=None)


def _land(pilot: Pilot) -> None:
    pilot.drone.commander.send_notify_setpoint_stop()
    pilot.drone.high_level_commander.land(0.02, 1.6, yaw=None)


def _position(pilot: Pilot, t: float) -> None:
    pilot.drone.commander.send_position_setpoint(*pilot.place(0.0, 0.05, 0.65), 15.0)


def _velocity(pilot: Pilot, t: float) -> None:
    pilot.drone.commander.send_velocity_world_setpoint(0.2 * math.cos(6 * t), 0.2 * math.sin(6 * t), 0.1, 20.0)


def _hover(pilot: Pilot, t: float) -> None:
    pilot.drone.commander.send_hover_setpoint(0.15 * math.cos(7 * t), 0.15 * math.sin(7 * t), -30.0, 0.6)


def _zdistance(pilot: Pilot, t: float) -> None:
    pilot.drone.commander.send_zdistance_setpoint(2.0 * math.cos(9 * t), 1.5 * math.sin(9 * t), 10.0, 0.65)


def _descend(pilot: Pilot, t: float) -> None:
    pilot.drone.commander.send_zdistance_setpoint(0.0, 0.0, 0.0, max(0.05, 0.65 - 0.9 * t))


def _altitude_hold(pilot: Pilot, t: float) -> None:
    # a packet that cflib has no call for
    lib.cf_send_altitude_hold(pilot.drone.struct, 2.0 * math.sin(9 * t), -1.5 * math.cos(9 * t), 5.0, 0.1)


def _manual(is_rate: bool) -> Callable[[Pilot, float], None]:
    def keep(pilot: Pilot, t: float) -> None:
        swing = 8.0 * math.sin(20 * t) if is_rate else 2.0 * math.sin(12 * t)
        pilot.drone.commander.send_setpoint_manual(swing, -swing, 10.0, 54.0, is_rate)

    return keep


def _unlock_thrust(pilot: Pilot) -> None:
    pilot.drone.commander.send_setpoint(0.0, 0.0, 0.0, 0)


def _rpyt(pilot: Pilot, t: float) -> None:
    if t >= PERIOD / 1000:
        pilot.drone.commander.send_setpoint(1.5 * math.sin(12 * t), 1.5 * math.cos(12 * t), 15.0, 37000)


def _full_state(pilot: Pilot, t: float) -> None:
    w, r = 3.0, 0.08
    pilot.drone.commander.send_full_state_setpoint(
        pilot.place(r * math.sin(w * t), 0.05 + r * (1 - math.cos(w * t)), 0.65),
        (r * w * math.cos(w * t), r * w * math.sin(w * t), 0.0),
        (-r * w * w * math.sin(w * t), r * w * w * math.cos(w * t), 0.0),
        (0.0, 0.0, math.sin(0.1), math.cos(0.1)),
        0.0,
        0.0,
        0.1,
    )


def _high_level(pilot: Pilot) -> None:
    pilot.drone.commander.send_notify_setpoint_stop()
    pilot.drone.high_level_commander.go_to(*pilot.place(0.0, 0.0, 0.7), yaw=0.4, duration_s=1.0)


def _relative_linear(pilot: Pilot) -> None:
    pilot.drone.high_level_commander.go_to(0.1, 0.05, 0.05, yaw=-0.4, duration_s=0.8, relative=True, linear=True)


def _spiral(pilot: Pilot) -> None:
    pilot.drone.high_level_commander.spiral(math.pi, 0.1, 0.15, 0.05, 1.4, sideways=True, clockwise=True)


def _trajectory(pilot: Pilot) -> None:
    pilot.drone.high_level_commander.upload_trajectory(1, example_pieces())
    pilot.drone.high_level_commander.start_trajectory(1, 0.9, relative_position=True, relative_yaw=True)


def _compressed(pilot: Pilot) -> None:
    commander = pilot.drone.high_level_commander
    commander.upload_compressed_trajectory(2, *example_compressed(), offset=1024)
    commander.start_trajectory(2, relative_position=True)


def _toward(dx: float) -> Callable[[Pilot, float], None]:
    def keep(pilot: Pilot, t: float) -> None:
        pilot.drone.commander.send_position_setpoint(*pilot.place(dx, 0.02, 0.6), 0.0)

    return keep


def _packet(port: int, channel: int, form: str, *values: float) -> Callable[[Pilot], None]:
    """Return a step that sends a packet; an answer that says no counts as refused."""
    data = struct.pack(form, *values)

    def send(pilot: Pilot) -> None:
        answer = pilot.drone.receive_packet(port, channel, data)
        if answer is not None and len(answer) > _CODE and answer[_CODE] != 0:
            pilot.refused.append(f"packet {data.hex(' ')}: {answer[_CODE]}")

    return send


def _all(*steps: Callable[[Pilot], None]) -> Callable[[Pilot], None]:
    def begin(pilot: Pilot) -> None:
        for step in steps:
            step(pilot)

    return begin


def _hover_packet(pilot: Pilot, t: float) -> None:
    _packet(_GENERIC, 0, "<Bffff", 5, 0.1 * math.sin(4 * t), 0.05, 10.0, 0.6)(pilot)


def _position_packet(pilot: Pilot, t: float) -> None:
    _packet(_GENERIC, 0, "<Bffff", 7, *pilot.place(0.05, -0.05, 0.6), 0.0)(pilot)


def _unlock_packet(pilot: Pilot) -> None:
    _packet(_RPYT, 0, "<fffH", 0.0, 0.0, 0.0, 0)(pilot)


def _rpyt_packet(pilot: Pilot, t: float) -> None:
    if t >= PERIOD / 1000:
        _packet(_RPYT, 0, "<fffH", math.sin(12 * t), math.cos(12 * t), 5.0, 37000)(pilot)


def _relax_packet(pilot: Pilot) -> None:
    _packet(_GENERIC, 1, "<BI", 0, 0)(pilot)
    pilot.drone.high_level_commander.go_to(*pilot.place(0.0, 0.0, 0.6), yaw=0.0, duration_s=1.0)


def _set(name: str, value: int) -> Callable[[Pilot], None]:
    def begin(pilot: Pilot) -> None:
        pilot.drone.param[name] = value

    return begin


def _emergency_stop(pilot: Pilot) -> None:
    pilot.drone.emergency_stop()


def _refused_by_the_planner(pilot: Pilot) -> None:
    # a second take-off, an unknown command, a trajectory that is not defined
    _packet(_HIGH_LEVEL, 0, "<BBffBf", 7, 0, 0.9, 0.0, 1, 1.0)(pilot)
    _packet(_HIGH_LEVEL, 0, "<BB", 99, 0)(pilot)
    _packet(_HIGH_LEVEL, 0, "<BBBBBBf", 13, 0, 0, 0, 0, 17, 1.0)(pilot)


def _not_for_this_group(pilot: Pilot) -> None:
    pilot.drone.high_level_commander.set_group_mask(2)
    _packet(_HIGH_LEVEL, 0, "<BBBBfffff", 12, 4, 0, 0, 9.0, 9.0, 1.0, 0.0, 1.0)(pilot)


def example_pieces() -> np.ndarray:
    """Return two polynomial pieces that start and end at rest, shape (2, 33)."""
    rows = np.zeros((2, 33))
    for row, (x, y, z, yaw) in enumerate(((0.12, -0.08, 0.1, 0.5), (-0.12, 0.08, -0.1, -0.3))):
        before = np.array([0.0, 0.0, 0.0, 0.0]) if row == 0 else np.array([0.12, -0.08, 0.1, 0.5])
        duration = 0.8 + 0.2 * row
        # 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7
        smooth = np.array([0, 0, 0, 0, 35.0, -84.0, 70.0, -20.0]) / duration ** np.arange(8)
        for axis, way in enumerate((x, y, z, yaw)):
            rows[row, 8 * axis : 8 * axis + 8] = way * smooth
            rows[row, 8 * axis] = before[axis]
        rows[row, 32] = duration
    return rows


def example_compressed() -> tuple[CompressedStart, list[CompressedSegment]]:
    """Return a compressed trajectory with an axis of every form."""
    start = CompressedStart(0.0, 0.0, 0.5, 0.0)
    return start, [
        CompressedSegment(0.7, [0.1], [0.0, 0.05, 0.05], [], [0.0, 0.0, 0.05, 0.1, 0.15, 0.2, 0.2]),
        CompressedSegment(0.8, [0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0], [], [0.55], [0.2, 0.1, 0.0]),
    ]


_UP, _DOWN = Leg(1.5, _takeoff), Leg(2.2, _land)
_STAY, _STAY_SHORT, _STAY_LONG = (Leg(seconds, keep=_position) for seconds in (0.8, 0.6, 1.0))
_GO, _GO_ON = Leg(1.1, _high_level), Leg(0.9, _relative_linear)
_VELOCITY, _HOVER = Leg(0.8, keep=_velocity), Leg(0.8, keep=_hover)
_CURVES = (Leg(1.5, _spiral), Leg(1.7, _trajectory), Leg(1.6, _compressed))

_ATTITUDES = (
    Leg(0.25, keep=_manual(False)),
    Leg(0.2, keep=_manual(True)),
    _STAY,
    Leg(0.25, _unlock_thrust, _rpyt),
    _STAY,
)
_HEIGHTS = (Leg(0.5, keep=_zdistance), Leg(0.5, keep=_altitude_hold), _STAY_SHORT)
_SETPOINTS = (Leg(0.9, keep=_position), _VELOCITY, _HOVER, *_HEIGHTS, *_ATTITUDES, Leg(1.0, keep=_full_state))
EVERY_SETPOINT = (_UP, *_SETPOINTS, _GO, _GO_ON, *_CURVES, _DOWN)

# INDI loses a few degrees of yaw for a moment where a turn passes 180 deg, more or less by chance
NO_SPIRAL = tuple(leg for leg in EVERY_SETPOINT if leg.begin is not _spiral)

# Mellinger, Brescianini and Lee cannot fly velocities or bare attitudes
POSITIONS_ONLY = (_UP, _STAY_LONG, Leg(1.2, keep=_full_state), _GO, _GO_ON, *_CURVES, _DOWN)
STANDING = (Leg(3.0),)
SIMPLE = (_UP, _STAY_LONG, _VELOCITY, _HOVER, _GO, _GO_ON, _DOWN)
HEIGHT_ALONE = (
    *(Leg(1.2, keep=_zdistance), Leg(0.6, keep=_altitude_hold), Leg(0.6, keep=_zdistance), Leg(0.8, keep=_descend)),
    Leg(0.1, lambda pilot: pilot.drone.commander.send_stop_setpoint()),
)


def trade_places(dx: float) -> tuple[Leg, ...]:
    """Return the flight of a drone that goes to a place `dx` (m) beside its own."""
    return (_UP, Leg(2.5, keep=_toward(dx)), _DOWN)


# in the pause the setpoint grows old: the supervisor levels out
COMMANDED = (_UP, _STAY, Leg(0.7), _STAY, _GO, _GO_ON, _DOWN)
_SENT_POSITION = Leg(0.8, keep=_position_packet)
_SENT = (Leg(0.8, keep=_hover_packet), _SENT_POSITION, Leg(0.25, _unlock_packet, _rpyt_packet), _SENT_POSITION)
PACKETS = (_UP, *_SENT, Leg(1.1, _relax_packet), _DOWN)
PLANS = (_UP, Leg(0.5, _refused_by_the_planner), Leg(0.3, _not_for_this_group), _GO_ON, *_CURVES, _DOWN)
STOPPED = (_UP, _STAY_SHORT, Leg(1.2, _emergency_stop), Leg(0.3, _takeoff))
FORGOTTEN = (_UP, _STAY, Leg(3.0))
SWITCHED = (
    *(_UP, _STAY_SHORT),
    *(Leg(1.0, _set("stabilizer.controller", number), _position) for number in (2, 4, 1)),
    *(_GO, _DOWN),
)
ESTIMATED_AGAIN = (
    Leg(0.5, _set("stabilizer.estimator", 1)),
    Leg(0.8, _all(_set("stabilizer.estimator", 2), _set("kalman.resetEstimation", 1))),
    *(_UP, _STAY, _HOVER, _GO, _DOWN),
)
TESTED = (Leg(4.6, _set("health.startPropTest", 1)),)
