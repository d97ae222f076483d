"""A recorded flight and its mission: the same commands in simulation, and all figures of both flights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.comparison.figures import (
    Attempts,
    Figures,
    chain_figures,
    controller_figures,
    hover_figures,
    motor_figures,
    plant_figures,
)
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases, find_phases
from crazychoir_fw.comparison.signals import Array, at
from crazychoir_fw.comparison.tuning import Tuning, tune
from crazychoir_fw.comparison.whole_chain import (
    ChainComparison,
    compare_paths,
    fly_beside,
    pack_for,
    start_place,
    start_yaw,
)
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.simulation import DroneConfig

LOG, MISSION = "log", "mission"
COMMANDS = (LOG, MISSION)
"""Where commands come from: the setpoints that the log holds, or the phases of the mission."""

_OFF_FLOOR = 0.05  # [m]
_RUNS_BEFORE = 0.3  # [s], motors of a log without motors before it leaves the floor
_RUNNING = 30_000.0
_AMPERES, _COULOMBS = 3.2, 900.0  # drawn in hover, of a pack


@dataclass(frozen=True)
class Comparison:
    """A real flight and the simulated one."""

    flight: RecordedFlight
    phases: Phases
    commands: str
    """One of `COMMANDS`."""
    chain: ChainComparison
    figures: Figures
    """By name, as docs/real_flights.md explains them; what could not be compared is not there."""
    drone: str
    """Name of the drone in the mission."""
    tuning: Tuning | None = None
    """What was taken from the hover of the flight, if anything was."""
    problems: list[str] = field(default_factory=list)
    """What could not be compared, and why."""


def compare_flight(
    flight: RecordedFlight,
    mission: Mission,
    drone: str | None = None,
    commands: str | None = None,
    tunes: bool = True,
    inner: bool = True,
) -> Comparison:
    """Fly the commands of a recorded flight in simulation, and compare.

    Args:
        flight: The flight.
        mission: Its drones say which vehicle, software and positioning flies.
        drone: Which of them; None takes the first.
        commands: One of `COMMANDS`; None takes the setpoints of the log, if it has some.
        tunes: Whether thrust scale, trim and voltage are taken from the hover of the flight, where the log shows them.
        inner: Whether controller, motors and plant are compared as well, where the log suffices.

    Raises:
        UnknownNameError: If the mission has no such drone.
        RangeError: If the log does not suffice, or the simulated drone was lost.
        CrazychoirError: If the mission cannot be flown.
    """
    number = _number(mission, drone)
    config = DroneConfig(**drone_settings(mission.fleet[number]))
    chosen = commands or (LOG if flight.setpoint is not None else MISSION)
    phases = find_phases(flight if flight.motors is not None else _with_motors(flight))
    attempt = Attempts()
    vehicle = {**config.overrides(), **({} if config.mass is None else {"mass": config.mass})}
    is_known = config.platform == "cf2" and flight.motors is not None and flight.voltage is not None
    tuning = attempt("hover", lambda: tune(flight, phases, vehicle)) if tunes and is_known else None
    if chosen == LOG:
        ours = _at_start(config, flight, phases, vehicle, tuning)
        chain = fly_beside(flight, phases, ours, tuning, mission.seed)
    else:
        chain = _fly_mission(flight, phases, mission, number)
    figures = chain_figures(chain)
    if tuning is not None:
        figures["hover"] = hover_figures(tuning)
    if inner and config.platform == "cf2":
        figures |= _inner(flight, phases, vehicle, tuning, attempt)
    return Comparison(flight, phases, chosen, chain, figures, config.id, tuning, attempt.problems)


def _number(mission: Mission, drone: str | None) -> int:
    names = [one.id for one in mission.fleet]
    if drone is None:
        return 0
    if drone not in names:
        raise UnknownNameError(f"--drone is '{drone[:40]}', but the mission has {', '.join(names)}")
    return names.index(drone)


def _with_motors(flight: RecordedFlight) -> RecordedFlight:
    """Return a flight whose motors run while it is off the floor: what `find_phases` needs to know of them.

    Raises:
        RangeError: If it never leaves the floor.
    """
    height = flight.position[:, 2]
    above = height > height.min() + _OFF_FLOOR
    if not above.any():
        raise RangeError(f"{flight.name}: it never leaves the floor")
    rows = np.flatnonzero(above)
    running = np.zeros(len(height))
    running[max(rows[0] - round(_RUNS_BEFORE / PERIOD), 0) : rows[-1] + 1] = _RUNNING
    return replace(flight, motors=np.repeat(running[:, None], 4, axis=1))


def _at_start(
    config: DroneConfig, flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any], tuning: Tuning | None
) -> DroneConfig:
    """Return the drone of the mission where the real one stood, with what its hover says of it."""
    there = replace(config, position=start_place(flight, phases), yaw_deg=start_yaw(flight, phases), motor_ctrl=None)
    if tuning is None:
        return there
    seconds = phases.hovering[0] - phases.motors_on
    charge, resistance = pack_for(tuning.hover_voltage, tuning.hover_thrust, seconds, vehicle)
    own = {**config.overrides(), **tuning.overrides(), "battery.resistance": resistance}
    return replace(there, vehicle=own, battery=min(1.0, charge + seconds * _AMPERES / _COULOMBS))


def _fly_mission(flight: RecordedFlight, phases: Phases, mission: Mission, number: int) -> ChainComparison:
    """Fly the mission itself; both clocks meet where the drones leave the floor."""
    log = fly(mission, visuals=False).log
    group = "stateEstimate" if flight.is_estimate else "sim"
    place = log.stack(*(f"{group}.{axis}" for axis in "xyz"))
    if place is None:
        raise RangeError(f"{mission.name}: backend {mission.backend} has no motion to compare with, allowed: sim")
    path = place[:, number]
    above = path[:, 2] > path[0, 2] + _OFF_FLOOR
    if not above.any():
        raise RangeError(f"{mission.name}: simulated {log.drone_ids[number]} never leaves the floor")
    leaves = float(log.time[int(np.argmax(above))])
    times = log.time - leaves + phases.airborne
    moved = path.copy()
    moved[:, 2] += float(flight.position[:, 2].min()) - path[0, 2]
    attitude = _attitude(log, group, number)
    thrust, voltage = (_signal(log, name, number) for name in ("stabilizer.thrust", "pm.vbat"))
    rows = np.concatenate([moved, attitude, thrust[:, None], voltage[:, None]], axis=1)
    reference = log.reference()
    target = moved if reference is None else np.where(np.isnan(reference[:, number]), moved, reference[:, number])
    grid = np.arange(max(times[0], 0.0), times[-1], PERIOD)
    return compare_paths(flight, phases, None, grid, at(grid, times, target), at(grid, times, rows), mission.name)


def _attitude(log: FlightLog, group: str, number: int) -> Array:
    """Return attitudes of a group of signals (w, x, y, z), shape (T, 4)."""
    from crazychoir_fw.common.attitude import quaternion_xyzw

    angles = log.stack(*(f"{group}.{name}" for name in ("roll", "pitch", "yaw")))
    assert angles is not None  # it has a position
    xyzw = quaternion_xyzw(np.radians(angles[:, number] * np.array([1.0, -1.0, 1.0])))
    flips = np.where(np.sum(xyzw[1:] * xyzw[:-1], axis=1) < 0.0, -1.0, 1.0)
    xyzw[1:] *= np.cumprod(flips)[:, None]
    return xyzw[:, [3, 0, 1, 2]]


def _signal(log: FlightLog, name: str, number: int) -> Array:
    signal = log.signals.get(name)
    return np.full(len(log.time), np.nan) if signal is None else signal[:, number].astype(float)


def _inner(
    flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any], tuning: Tuning | None, attempt: Attempts
) -> Figures:
    """Compare controller, motors and plant, as far as the log suffices."""
    found: Figures = {}
    if flight.motors is not None:
        found |= attempt("controller", lambda: controller_figures(flight, phases)) or {}
        found |= attempt("motors", lambda: motor_figures(flight, phases)) or {}
    if tuning is not None:
        found |= attempt("plant", lambda: plant_figures(flight, phases, vehicle, tuning)) or {}
    return found
