"""From the phases of a mission to commands at ticks, and to the places where each drone must then be.

The plan is arithmetic on the mission alone: no simulation, no clock. It follows each drone from phase to phase, so
that a phase that makes no sense there (a landing on the floor) is refused before anything flies.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.common.trajectory_files import MEMORY_PIECES, end_points, total_duration
from crazychoir_fw.mission.phases import GoTo, Hover, Land, Maneuver, PhaseEntry, Route, Takeoff, Trajectory
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.mission.values import did_you_mean

SETTLE_TICKS = 2500
"""Time after the last phase, in which the drones come to rest; supervisors see a landing 2 s after the last thrust."""

ARMING_TICKS = 500
"""Pause before a second take-off, in which a vehicle that disarms after landing arms again."""

LARGEST_PLAN = 1_000_000  # commands, about 1 GB of them

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Command:
    """One call of a drone's high-level commander (or of `arm`)."""

    tick: int
    drone: int  # index into the fleet
    verb: str  # name of the method
    arguments: dict[str, float | bool | int | None]


@dataclass(frozen=True)
class Waypoint:
    """A place that a drone must have reached about a tick."""

    tick: int
    drone: int  # index into the fleet
    phase: str  # key path of what asks for it
    position: Point  # [m], world frame


@dataclass
class Course:
    """One drone as the plan follows it."""

    start: Point  # [m], world frame, on the floor
    yaw: float  # [rad]
    position: Point = (0.0, 0.0, 0.0)  # latest position set-point [m], world frame
    is_flying: bool = False
    flies_itself: bool = False  # by a motor control of its own
    airborne: list[tuple[int, int]] = field(default_factory=list)  # from the take-off to the end of the landing [ticks]


@dataclass(frozen=True)
class Upload:
    """A trajectory in the memory of every drone."""

    number: int  # trajectory id
    offset: int  # [bytes]
    rows: NDArray[np.float32]  # (n, 33)


@dataclass
class FlightPlan:
    """All of a flight, by tick."""

    fleet: list[str]  # ids
    courses: list[Course]
    commands: list[Command] = field(default_factory=list)
    waypoints: list[Waypoint] = field(default_factory=list)
    uploads: list[Upload] = field(default_factory=list)
    ticks: int = 0
    windows: list[tuple[str, int, int]] = field(default_factory=list)
    """Name, begin and end (ticks) of each phase."""

    def command(self, tick: int, drone: int, verb: str, **arguments: float | bool | int | None) -> None:
        """Add a command."""
        if len(self.commands) >= LARGEST_PLAN:
            raise MissionError(f"flight asks for more than {LARGEST_PLAN} commands, one per drone, leg and repetition")
        self.commands.append(Command(tick, drone, verb, arguments))

    def aim(self, tick: int, drone: int, phase: str, position: Point) -> None:
        """Add a waypoint, and remember it as the place of the drone."""
        self.courses[drone].position = position
        self.waypoints.append(Waypoint(tick, drone, phase, position))


def plan_flight(mission: Mission) -> FlightPlan:
    """Return the plan of a mission.

    Raises:
        MissionError: If a phase is impossible where it stands; the text names the phase, the drone and the remedy.
    """
    courses = []
    for drone in mission.fleet:
        start = (*drone.position, 0.0)[:3]
        own = drone.motor_ctrl is not None
        courses.append(Course(start=start, yaw=math.radians(drone.yaw_deg), position=start, flies_itself=own))
    plan = FlightPlan(fleet=[drone.id for drone in mission.fleet], courses=courses)

    now = 0
    for i, phase in enumerate(mission.flight):
        begin, now = now, _plan_phase(plan, phase, f"flight[{i}]", now)
        plan.windows.append((_name_of(phase), begin, now))
    for course in plan.courses:
        if course.is_flying:
            course.airborne[-1] = (course.airborne[-1][0], now + SETTLE_TICKS)
    plan.ticks = now + SETTLE_TICKS
    plan.commands.sort(key=lambda command: command.tick)
    return plan


def _plan_phase(plan: FlightPlan, phase: PhaseEntry, path: str, now: int) -> int:
    """Add one phase that begins at tick *now*, and return the tick of its end."""
    path = f"{path}.{phase.name}"
    if not isinstance(phase.maneuver, Maneuver):
        _refuse_double_orders(plan, phase.maneuver, path)
        return max(_plan_phase(plan, child, f"{path}[{i}]", now) for i, child in enumerate(phase.maneuver))
    return _PLANNERS[type(phase.maneuver)](plan, phase.maneuver, path, now)


def _name_of(phase: PhaseEntry) -> str:
    """Return what a phase is called: those that begin together by what they are, each kind once."""
    if isinstance(phase.maneuver, Maneuver):
        return phase.name
    return ", ".join(dict.fromkeys(_name_of(child) for child in phase.maneuver))


def _refuse_double_orders(plan: FlightPlan, phases: list[PhaseEntry], path: str) -> None:
    seen: dict[int, int] = {}
    for i, child in enumerate(phases):
        for drone in sorted(_everyone_in(plan, child, f"{path}[{i}]")):
            if drone in seen:
                raise MissionError(
                    f"{path} gives {plan.fleet[drone]} two orders at once, in [{seen[drone]}] and [{i}]; "
                    f"name the drones of each phase with drones: [ids]"
                )
            seen[drone] = i


def _everyone_in(plan: FlightPlan, phase: PhaseEntry, path: str) -> set[int]:
    if isinstance(phase.maneuver, Maneuver):
        return set(_selected(plan, phase.maneuver, path))
    return set().union(*(_everyone_in(plan, child, path) for child in phase.maneuver))


def _selected(plan: FlightPlan, maneuver: Maneuver, path: str) -> list[int]:
    """Return the indices of the drones of a maneuver, in the order of the fleet.

    A drone with its own program is only commanded by name.
    """
    if maneuver.drones is None:
        return [i for i, course in enumerate(plan.courses) if not course.flies_itself]
    for name in maneuver.drones:
        if name not in plan.fleet:
            hint = did_you_mean(name, plan.fleet)
            raise MissionError(f"{path}.drones names '{name[:40]}', but must name drones of the mission{hint}")
    return [i for i, name in enumerate(plan.fleet) if name in maneuver.drones]


def _flying(plan: FlightPlan, maneuver: Maneuver, path: str) -> list[int]:
    """Return the indices of the drones of a maneuver that needs flying drones."""
    drones = _selected(plan, maneuver, path)
    for i in drones:
        if not plan.courses[i].is_flying:
            raise MissionError(f"{path}: {plan.fleet[i]} is on the floor there, and must take off first")
    return drones


def _ticks(seconds: float) -> int:
    return max(1, round(seconds * TICKS_PER_SECOND))


def _takeoff(plan: FlightPlan, takeoff: Takeoff, path: str, now: int) -> int:
    drones = _selected(plan, takeoff, path)
    again = any(plan.courses[i].airborne for i in drones)
    begin = now + ARMING_TICKS if again else now
    end = begin + _ticks(takeoff.duration)
    for order, i in enumerate(drones):
        course = plan.courses[i]
        height = takeoff.height + order * takeoff.stagger
        if course.is_flying:
            raise MissionError(f"{path}: {plan.fleet[i]} flies already there, and must land first")
        if not height > course.start[2]:
            raise MissionError(
                f"{path} takes {plan.fleet[i]} to {height:g} m, but must end above its start at {course.start[2]:g} m"
            )
        if again:
            # twice, because for some 100 ms after its landing a vehicle cannot be armed
            plan.command(now, i, "arm")
            plan.command(now + ARMING_TICKS // 2, i, "arm")
        plan.command(begin, i, "takeoff", absolute_height_m=height, duration_s=takeoff.duration, yaw=None)
        plan.aim(end, i, path, (*course.position[:2], height))
        course.is_flying = True
        course.airborne.append((begin, end))
    return end


def _hover(plan: FlightPlan, hover: Hover, path: str, now: int) -> int:
    end = now + _ticks(hover.duration)
    for i in _selected(plan, hover, path):
        if plan.courses[i].is_flying:
            plan.aim(end, i, path, plan.courses[i].position)
    return end


def _go_to(plan: FlightPlan, go_to: GoTo, path: str, now: int) -> int:
    drones = _flying(plan, go_to, path)
    if go_to.position is not None and len(drones) > 1:
        raise MissionError(
            f"{path}.position sends {len(drones)} drones to one point; name one with drones: [id], or use offset"
        )
    end = now + _ticks(go_to.duration)
    for i in drones:
        course = plan.courses[i]
        if go_to.yaw_deg is not None:
            course.yaw = math.radians(go_to.yaw_deg)
        target = go_to.position or tuple(a + b for a, b in zip(course.position, go_to.offset, strict=True))
        _leg(plan, i, f"{path}", now, target, go_to.duration, go_to.linear)
    return end


def _route(plan: FlightPlan, route: Route, path: str, now: int) -> int:
    drones = _flying(plan, route, path)
    for k, (x, y, z) in enumerate(route.points):
        for order, i in enumerate(drones):
            start = plan.courses[i].start
            target = (start[0] + x, start[1] + y, z + order * route.stagger)
            _leg(plan, i, f"{path}.points[{k}]", now, target, route.leg_duration, route.linear)
        now += _ticks(route.leg_duration)
    return now


def _leg(plan: FlightPlan, drone: int, path: str, now: int, target: Point, duration: float, linear: bool) -> None:
    """Add one go-to of one drone."""
    if target[2] < plan.courses[drone].start[2]:
        raise MissionError(
            f"{path} sends {plan.fleet[drone]} to z = {target[2]:.3g} m, below the floor it started from"
        )
    x, y, z = target
    yaw = plan.courses[drone].yaw
    plan.command(now, drone, "go_to", x=x, y=y, z=z, yaw=yaw, duration_s=duration, linear=linear)
    plan.aim(now + _ticks(duration), drone, path, target)


def _trajectory(plan: FlightPlan, trajectory: Trajectory, path: str, now: int) -> int:
    drones = _flying(plan, trajectory, path)
    number = _upload(plan, trajectory.rows, path)
    first, last = end_points(trajectory.rows)
    if trajectory.reversed:
        first, last = last, first
    duration = _ticks(total_duration(trajectory.rows) * trajectory.time_scale)
    for _ in range(trajectory.repeat):
        for i in drones:
            course = plan.courses[i]
            shift = np.array(course.position) - first[:3] if trajectory.relative else np.zeros(3)
            target = tuple(float(v) for v in last[:3] + shift)
            course.yaw = float(last[3])
            plan.command(
                now,
                i,
                "start_trajectory",
                trajectory_id=number,
                time_scale=trajectory.time_scale,
                relative_position=trajectory.relative,
                reversed=trajectory.reversed,
            )
            plan.aim(now + duration, i, path, target)
        now += duration
    return now


def _upload(plan: FlightPlan, rows: NDArray[np.float32], path: str) -> int:
    """Return the id of a trajectory in memory; the same pieces are uploaded once."""
    for upload in plan.uploads:
        if np.array_equal(upload.rows, rows):
            return upload.number
    used = sum(len(upload.rows) for upload in plan.uploads)
    if used + len(rows) > MEMORY_PIECES:
        raise MissionError(
            f"{path} brings the trajectories of the mission to {used + len(rows)} pieces, "
            f"but a Crazyflie remembers {MEMORY_PIECES}"
        )
    plan.uploads.append(Upload(number=len(plan.uploads), offset=used * rows[0].nbytes, rows=rows))
    return plan.uploads[-1].number


def _land(plan: FlightPlan, land: Land, path: str, now: int) -> int:
    end = now + _ticks(land.duration)
    for i in _flying(plan, land, path):
        course = plan.courses[i]
        height = land.height + course.start[2]
        plan.command(now, i, "land", absolute_height_m=height, duration_s=land.duration, yaw=None)
        course.position = (*course.position[:2], course.start[2])
        course.is_flying = False
        course.airborne[-1] = (course.airborne[-1][0], end)
    return end


_PLANNERS: dict[type[Maneuver], Callable[..., int]] = {
    Takeoff: _takeoff,
    Hover: _hover,
    GoTo: _go_to,
    Route: _route,
    Trajectory: _trajectory,
    Land: _land,
}
