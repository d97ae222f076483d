"""High-level commands, trajectory memory and setpoints (docs/reference/planner-commander.md#7)."""

import math
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

IDLE = lib.TRAJECTORY_STATE_IDLE
FLYING = lib.TRAJECTORY_STATE_FLYING
LANDING = lib.TRAJECTORY_STATE_LANDING
DISABLED = lib.TRAJECTORY_STATE_DISABLED

MEMORY_BYTES = lib.CF_TRAJECTORY_MEMORY_BYTES
NOT_FINITE = [math.nan, math.inf, -math.inf]


@dataclass
class Vehicle:
    """A high-level commander over a provider, with short names for its commands."""

    provider: Any
    now_us: int = 0
    commander: Any = field(default_factory=lambda: ffi.new("cf_high_level_commander_t *"))
    estimate: Any = field(default_factory=lambda: ffi.new("state_t *"))

    def __post_init__(self) -> None:
        lib.cf_high_level_commander_init(self.commander)

    @property
    def plan(self) -> int:
        return self.provider.plan_state

    def call(self, name: str, *args):
        function = getattr(lib, f"cf_high_level_commander_{name}")
        return function(self.commander, self.provider.table, self.provider.state, *args)

    def takeoff(self, height=1.0, duration=2.0, yaw=0.0, use_current_yaw=True) -> int:
        return self.call("takeoff", height, duration, yaw, use_current_yaw, self.now_us)

    def takeoff_with_velocity(self, height=1.0, relative=False, velocity=0.5, yaw=0.0, use_current_yaw=True) -> int:
        return self.call("takeoff_with_velocity", height, relative, velocity, yaw, use_current_yaw, self.now_us)

    def land(self, height=0.0, duration=2.0, yaw=0.0, use_current_yaw=True) -> int:
        return self.call("land", height, duration, yaw, use_current_yaw, self.now_us)

    def land_with_velocity(self, height=0.0, relative=False, velocity=0.5, yaw=0.0, use_current_yaw=True) -> int:
        return self.call("land_with_velocity", height, relative, velocity, yaw, use_current_yaw, self.now_us)

    def go_to(self, position=(1.0, 0.0, 1.0), yaw=0.0, duration=2.0, relative=False, linear=False) -> int:
        return self.call("go_to", list(position), yaw, duration, relative, linear, self.now_us)

    def spiral(self, angle=1.0, r0=1.0, rF=0.5, ascent=0.5, duration=2.0, sideways=False, clockwise=False) -> int:
        spiral = ffi.new("cf_spiral_t *", [sideways, clockwise, angle, r0, rF, ascent, duration])
        return self.call("spiral", spiral, self.now_us)

    def define(self, id=0, type=lib.CF_TRAJECTORY_TYPE_POLY4D, offset=0, n_pieces=1) -> int:
        return lib.cf_high_level_commander_define_trajectory(self.commander, id, type, offset, n_pieces)

    def start(self, id=0, timescale=1.0, relative_position=False, relative_yaw=False, reversed=False) -> int:
        return self.call("start_trajectory", id, timescale, relative_position, relative_yaw, reversed, self.now_us)

    def write(self, offset: int, data: bytes) -> int:
        return lib.cf_high_level_commander_write_trajectory(self.commander, offset, len(data), data)

    def block(self, block: bool) -> None:
        self.call("block", block)

    def setpoint(self, step: int = 10):
        """Return the setpoint at this step, or None."""
        setpoint = ffi.new("setpoint_t *")
        made = self.call("get_setpoint", self.estimate, step, self.now_us, setpoint)
        return setpoint if made else None

    def setpoint_at(self, seconds: float):
        self.now_us = round(seconds * 1e6)
        return self.setpoint()


@pytest.fixture
def vehicle(provider) -> Vehicle:
    return Vehicle(provider)


@pytest.fixture
def hovering(provider) -> Vehicle:
    """A vehicle that took off to 1 m and hovers since 2 s; it is 5 s now."""
    vehicle = Vehicle(provider)
    vehicle.takeoff()
    vehicle.setpoint_at(5.0)
    return vehicle


def xyz(v) -> list[float]:
    return [v.x, v.y, v.z]


def line_piece(duration=2.0, start=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), yaw=0.0) -> bytes:
    """Return one piece in its wire format: a straight line at constant speed."""
    piece = np.zeros(33, dtype="<f4")
    for axis in range(3):
        piece[8 * axis : 8 * axis + 2] = start[axis], velocity[axis]
    piece[24], piece[32] = yaw, duration
    return piece.tobytes()


# --- setpoints


def test_setpoints_come_at_100_hz(vehicle: Vehicle) -> None:
    vehicle.takeoff()
    assert [step for step in range(1, 41) if vehicle.setpoint(step)] == [10, 20, 30, 40]


def test_idle_planner_asks_for_the_null_setpoint(vehicle: Vehicle) -> None:
    setpoint = vehicle.setpoint()
    assert not any(bytes(ffi.buffer(setpoint)))


def test_disabled_planner_asks_for_nothing_and_follows_the_estimate(vehicle: Vehicle) -> None:
    lib.cf_planner_disable(vehicle.provider.state)
    vehicle.estimate.position.x = 3.0
    vehicle.estimate.velocity.y = 4.0
    vehicle.estimate.attitude.yaw = 90.0
    assert vehicle.setpoint() is None
    assert vehicle.commander.pos.x == 3.0
    assert vehicle.commander.vel.y == 4.0
    assert vehicle.commander.yaw == pytest.approx(math.pi / 2)


def test_setpoint_holds_the_goal_in_degrees(vehicle: Vehicle) -> None:
    vehicle.takeoff(yaw=1.0, use_current_yaw=False)
    setpoint = vehicle.setpoint_at(0.5)
    # docs/reference/planner-commander.md#17.2: take-off at t = 0.5
    assert xyz(setpoint.position) == [0.0, 0.0, pytest.approx(0.070556641, rel=1e-6)]
    assert xyz(setpoint.velocity) == [0.0, 0.0, pytest.approx(0.46142578, rel=1e-6)]
    assert xyz(setpoint.acceleration) == [0.0, 0.0, pytest.approx(1.8457031, rel=1e-6)]
    assert xyz(setpoint.jerk) == [0.0, 0.0, pytest.approx(1.2304688, rel=1e-6)]
    assert setpoint.attitude.yaw == pytest.approx(math.degrees(0.070556641), rel=1e-5)
    assert setpoint.attitudeRate.yaw == pytest.approx(math.degrees(0.46142578), rel=1e-5)
    mode = setpoint.mode
    assert [mode.x, mode.y, mode.z, mode.yaw] == [lib.modeAbs] * 4
    assert [mode.roll, mode.pitch, mode.quat] == [lib.modeDisable] * 3


def test_members_that_goals_do_not_name_are_kept(vehicle: Vehicle) -> None:
    vehicle.takeoff()
    vehicle.commander.setpoint.thrust = 123.0
    vehicle.commander.setpoint.mode.quat = lib.modeAbs
    setpoint = vehicle.setpoint_at(1.0)
    assert setpoint.thrust == 123.0
    assert setpoint.mode.quat == lib.modeDisable


@pytest.mark.parametrize("power", [0, 1, 7])
@pytest.mark.parametrize("axis", range(4))
def test_goal_that_is_no_number_disables_the_planner(vehicle: Vehicle, axis: int, power: int) -> None:
    vehicle.takeoff()
    vehicle.provider.state.planned.p[axis][power] = math.nan
    assert vehicle.setpoint_at(0.0) is None
    assert vehicle.plan == DISABLED


# a velocity, an acceleration, and a yaw that is finite in radians only
@pytest.mark.parametrize(("axis", "power", "value"), [(0, 1, math.inf), (2, 2, 2e38), (3, 0, 1e38)])
def test_goal_with_any_number_without_bounds_disables_the_planner(
    vehicle: Vehicle, axis: int, power: int, value: float
) -> None:
    """The firmware looks at the position alone; a controller would turn the others into duties that are no numbers."""
    vehicle.takeoff()
    vehicle.provider.state.planned.p[axis][power] = value
    assert vehicle.setpoint_at(0.0) is None
    assert vehicle.plan == DISABLED


def test_free_fall_has_no_body_rates(vehicle: Vehicle) -> None:
    vehicle.takeoff()
    vehicle.provider.state.planned.p[2][2] = np.float32(-9.81) / 2
    setpoint = vehicle.setpoint_at(0.0)
    assert setpoint.acceleration.z == np.float32(-9.81)
    rates = setpoint.attitudeRate
    assert [rates.roll, rates.pitch, rates.yaw] == [0.0, 0.0, 0.0]


def test_time_is_rounded_to_float32(vehicle: Vehicle) -> None:
    vehicle.now_us = 3_600_000_100  # beyond the resolution of a float32 second
    vehicle.takeoff()
    assert vehicle.provider.state.t_begin == np.float32(3600.0001)


# --- take-off and landing


def test_takeoff_rises_to_its_height_and_stays(hovering: Vehicle) -> None:
    setpoint = hovering.setpoint()
    assert xyz(setpoint.position) == [0.0, 0.0, 1.0]
    assert hovering.plan == FLYING


def test_takeoff_starts_at_the_estimate(vehicle: Vehicle) -> None:
    vehicle.estimate.position.x, vehicle.estimate.position.z = 2.0, 0.25
    vehicle.estimate.attitude.yaw = 45.0
    vehicle.setpoint()
    vehicle.takeoff()
    assert xyz(vehicle.setpoint().position) == [2.0, 0.0, 0.25]
    end = vehicle.setpoint_at(3.0)
    assert [*xyz(end.position), end.attitude.yaw] == pytest.approx([2.0, 0.0, 1.0, 45.0], abs=1e-4)


def test_takeoff_in_flight_is_refused(hovering: Vehicle) -> None:
    assert hovering.takeoff() == lib.CF_ERR_STATE


def test_landing_ends_with_motors_off(hovering: Vehicle) -> None:
    assert hovering.land(duration=1.0) == lib.CF_OK
    assert hovering.plan == LANDING
    assert hovering.land() == lib.CF_ERR_STATE
    assert hovering.setpoint_at(5.99).mode.z == lib.modeAbs
    # the evaluation that ends the landing finds the planner stopped already
    assert not any(bytes(ffi.buffer(hovering.setpoint_at(6.0))))
    assert hovering.plan == IDLE


def test_landing_turns_to_its_yaw(hovering: Vehicle) -> None:
    hovering.land(duration=1.0, yaw=0.5, use_current_yaw=False)
    assert hovering.setpoint_at(5.99).attitude.yaw == pytest.approx(math.degrees(0.5), rel=1e-4)


@pytest.mark.parametrize(
    ("height", "relative", "velocity", "duration", "goal"),
    [
        (1.0, False, 0.25, 3.0, 1.0),
        (1.0, True, 0.25, 4.0, 1.25),
        (1.0, False, 0.0, 1.5, 1.0),  # default speed 0.5 m/s
        (1.0, False, -3.0, 1.5, 1.0),
        (0.25, False, 1.0, 0.0, 0.25),
    ],
)
def test_takeoff_speed_gives_the_duration(
    vehicle: Vehicle, height: float, relative: bool, velocity: float, duration: float, goal: float
) -> None:
    vehicle.commander.pos.z = 0.25
    assert vehicle.takeoff_with_velocity(height, relative, velocity) == lib.CF_OK
    assert vehicle.provider.state.planned.duration == duration
    vehicle.now_us = 10_000_000
    assert vehicle.setpoint().position.z == pytest.approx(goal, abs=1e-6)


def test_landing_speed_gives_the_duration(hovering: Vehicle) -> None:
    assert hovering.land_with_velocity(0.75, relative=True, velocity=0.25) == lib.CF_OK
    assert hovering.provider.state.planned.duration == 3.0
    assert hovering.setpoint_at(7.99).position.z == pytest.approx(0.25, abs=1e-5)


def test_default_speeds_are_parameters(vehicle: Vehicle) -> None:
    vehicle.commander.vtoff = 0.25
    vehicle.commander.vland = 0.125
    vehicle.takeoff_with_velocity(1.0, velocity=0.0)
    assert vehicle.provider.state.planned.duration == 4.0
    vehicle.setpoint_at(10.0)
    vehicle.land_with_velocity(0.0, velocity=0.0)
    assert vehicle.provider.state.planned.duration == 8.0


@pytest.mark.parametrize("default", [0.0, -1.0, *NOT_FINITE])
def test_useless_default_speed_is_refused(vehicle: Vehicle, default: float) -> None:
    vehicle.commander.vtoff = vehicle.commander.vland = default
    assert vehicle.takeoff_with_velocity(velocity=0.0) == lib.CF_ERR_VALUE
    assert vehicle.land_with_velocity(velocity=0.0) == lib.CF_ERR_VALUE


def test_speed_too_small_for_a_finite_duration_is_refused(vehicle: Vehicle) -> None:
    assert vehicle.takeoff_with_velocity(1e38, velocity=1e-30) == lib.CF_ERR_VALUE


# --- go-to and stop


def test_go_to_reaches_its_goal(hovering: Vehicle) -> None:
    assert hovering.go_to((1.0, 2.0, 1.5), yaw=0.5, duration=3.0) == lib.CF_OK
    assert xyz(hovering.setpoint().position) == [0.0, 0.0, 1.0]
    end = hovering.setpoint_at(8.5)
    assert [*xyz(end.position), end.attitude.yaw] == pytest.approx([1.0, 2.0, 1.5, math.degrees(0.5)], rel=1e-5)


def test_relative_go_to_counts_from_here(hovering: Vehicle) -> None:
    hovering.go_to((1.0, 0.0, 0.5), relative=True, linear=True, duration=2.0)
    middle = hovering.setpoint_at(6.0)
    assert xyz(middle.position) == pytest.approx([0.5, 0.0, 1.25], abs=1e-6)
    assert xyz(middle.velocity) == pytest.approx([0.5, 0.0, 0.25], abs=1e-6)


def test_go_to_takes_off_from_idle(vehicle: Vehicle) -> None:
    vehicle.estimate.position.x = 2.0
    vehicle.setpoint()
    assert vehicle.go_to((2.0, 0.0, 1.0)) == lib.CF_OK
    assert xyz(vehicle.setpoint().position) == [2.0, 0.0, 0.0]


def test_spiral_begins_here_and_climbs(hovering: Vehicle) -> None:
    assert hovering.spiral(angle=math.pi, r0=1.0, rF=1.0, duration=4.0) == lib.CF_OK
    begin = hovering.setpoint()
    assert xyz(begin.position) == [0.0, 0.0, 1.0]
    # counter-clockwise, forward: the center is a radius to the left
    end = hovering.setpoint_at(9.0)
    assert xyz(end.position) == pytest.approx([0.0, 2.0, 1.5], abs=1e-4)
    assert end.attitude.yaw == pytest.approx(180.0, abs=1e-3)
    assert hovering.plan == FLYING


def test_spiral_takes_off_from_idle(vehicle: Vehicle) -> None:
    assert vehicle.spiral() == lib.CF_OK
    assert vehicle.plan == FLYING


def test_stop_cuts_the_motors(hovering: Vehicle) -> None:
    assert hovering.call("stop") == lib.CF_OK
    assert hovering.plan == IDLE
    assert not any(bytes(ffi.buffer(hovering.setpoint())))


# --- refused arguments


COMMANDS = {
    "takeoff": ["height", "duration"],
    "takeoff_with_velocity": ["height", "velocity"],
    "land": ["height", "duration"],
    "land_with_velocity": ["height", "velocity"],
    "go_to": ["yaw", "duration"],
    "spiral": ["angle", "r0", "rF", "ascent", "duration"],
    "start": ["timescale"],
}


@pytest.mark.parametrize("value", NOT_FINITE)
@pytest.mark.parametrize(("command", "argument"), [(c, a) for c, names in COMMANDS.items() for a in names])
def test_argument_that_is_not_finite_is_refused(vehicle: Vehicle, command: str, argument: str, value: float) -> None:
    vehicle.define()
    before = bytes(ffi.buffer(vehicle.provider.state))
    assert getattr(vehicle, command)(**{argument: value}) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(vehicle.provider.state)) == before


@pytest.mark.parametrize("value", NOT_FINITE)
def test_yaw_counts_only_when_it_is_used(vehicle: Vehicle, value: float) -> None:
    assert vehicle.takeoff(yaw=value, use_current_yaw=False) == lib.CF_ERR_VALUE
    assert vehicle.takeoff(yaw=value, use_current_yaw=True) == lib.CF_OK


@pytest.mark.parametrize("axis", range(3))
def test_position_that_is_not_finite_is_refused(vehicle: Vehicle, axis: int) -> None:
    position = [0.0, 0.0, 1.0]
    position[axis] = math.nan
    assert vehicle.go_to(position) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("value", [0.0, -1.0])
@pytest.mark.parametrize(
    ("command", "argument"),
    [
        ("takeoff", "duration"),
        ("land", "duration"),
        ("go_to", "duration"),
        ("spiral", "duration"),
        ("start", "timescale"),
    ],
)
def test_duration_and_timescale_have_to_be_positive(
    vehicle: Vehicle, command: str, argument: str, value: float
) -> None:
    vehicle.define()
    assert getattr(vehicle, command)(**{argument: value}) == lib.CF_ERR_VALUE


# --- blocking


@pytest.mark.parametrize("command", COMMANDS)
def test_blocked_commands_are_refused(vehicle: Vehicle, command: str) -> None:
    vehicle.define()
    vehicle.block(True)
    assert getattr(vehicle, command)() == lib.CF_ERR_BLOCKED
    assert vehicle.plan == IDLE
    vehicle.block(False)
    assert getattr(vehicle, command)() == lib.CF_OK


def test_block_stops_a_plan_when_it_begins(hovering: Vehicle) -> None:
    hovering.block(True)
    assert hovering.plan == IDLE
    assert hovering.commander.is_blocked
    # a block that goes on touches nothing
    hovering.provider.state.state = FLYING
    hovering.block(True)
    assert hovering.plan == FLYING


def test_block_leaves_a_disabled_planner_disabled(vehicle: Vehicle) -> None:
    lib.cf_planner_disable(vehicle.provider.state)
    vehicle.block(True)
    assert vehicle.plan == DISABLED


def test_stop_and_definitions_pass_a_block(vehicle: Vehicle) -> None:
    vehicle.block(True)
    assert vehicle.call("stop") == lib.CF_OK
    assert vehicle.define() == lib.CF_OK


# --- trajectories


def test_uploaded_trajectory_is_flown(hovering: Vehicle) -> None:
    assert hovering.write(132, line_piece(2.0, (1.0, 0.0, 1.0))) == lib.CF_OK
    assert hovering.define(id=7, offset=132) == lib.CF_OK
    assert hovering.start(id=7, timescale=2.0) == lib.CF_OK
    assert xyz(hovering.setpoint().position) == [1.0, 0.0, 1.0]
    setpoint = hovering.setpoint_at(7.0)
    assert xyz(setpoint.position) == pytest.approx([2.0, 0.0, 1.0])
    assert xyz(setpoint.velocity) == pytest.approx([0.5, 0.0, 0.0])
    finished = lib.cf_high_level_commander_is_trajectory_finished
    table, state = hovering.provider.table, hovering.provider.state
    assert not finished(hovering.commander, table, state, 8_900_000)
    assert finished(hovering.commander, table, state, 9_000_000)


def test_relative_and_reversed_trajectory_starts_here(hovering: Vehicle) -> None:
    hovering.write(0, line_piece(2.0, (5.0, 5.0, 5.0)))
    hovering.define()
    hovering.start(relative_position=True, reversed=True)
    setpoint = hovering.setpoint_at(6.0)
    assert xyz(setpoint.position) == pytest.approx([-1.0, 0.0, 1.0])
    assert xyz(setpoint.velocity) == pytest.approx([-1.0, 0.0, 0.0])


def test_yaw_relative_trajectory_is_turned(vehicle: Vehicle) -> None:
    vehicle.estimate.attitude.yaw = 90.0
    vehicle.setpoint()
    vehicle.write(0, line_piece(2.0))
    vehicle.define()
    vehicle.start(relative_position=True, relative_yaw=True)
    setpoint = vehicle.setpoint_at(1.0)
    assert xyz(setpoint.position) == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    assert setpoint.attitude.yaw == pytest.approx(90.0)


@pytest.mark.parametrize("id", [0, 30, 31, 255])
def test_trajectory_that_is_not_defined_is_unknown(vehicle: Vehicle, id: int) -> None:
    assert not lib.cf_high_level_commander_is_trajectory_defined(vehicle.commander, id)
    assert vehicle.start(id=id) == lib.CF_ERR_UNKNOWN


# id, offset, pieces
@pytest.mark.parametrize(
    ("id", "offset", "n_pieces", "status"),
    [
        (0, 0, 31, lib.CF_OK),
        (30, 4, 31, lib.CF_OK),
        (30, 3964, 1, lib.CF_OK),
        (31, 0, 1, lib.CF_ERR_CAPACITY),
        (255, 0, 1, lib.CF_ERR_CAPACITY),
        (0, 2, 1, lib.CF_ERR_CAPACITY),
        (0, 8, 31, lib.CF_ERR_CAPACITY),
        (0, 0, 32, lib.CF_ERR_CAPACITY),
        (0, 0, 255, lib.CF_ERR_CAPACITY),
        (0, 3968, 1, lib.CF_ERR_CAPACITY),
        (0, 4096, 1, lib.CF_ERR_CAPACITY),
        (0, 2**32 - 4, 1, lib.CF_ERR_CAPACITY),
        (0, 0, 0, lib.CF_ERR_VALUE),
    ],
)
def test_definition_has_to_lie_in_the_memory(
    vehicle: Vehicle, id: int, offset: int, n_pieces: int, status: int
) -> None:
    assert vehicle.define(id=id, offset=offset, n_pieces=n_pieces) == status
    assert lib.cf_high_level_commander_is_trajectory_defined(vehicle.commander, id) == (status == lib.CF_OK)


# from (1, 2, 3) m: 2 s to (2, 2, 3)
COMPRESSED = struct.pack("<4h", 1000, 2000, 3000, 0) + struct.pack("<BHh", 1, 2000, 2000) + bytes(3)


def define_compressed(vehicle: Vehicle, offset=0, id=0, n_pieces=1) -> int:
    vehicle.write(offset, COMPRESSED)
    return vehicle.define(id=id, type=lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED, offset=offset, n_pieces=n_pieces)


@pytest.mark.parametrize("n_pieces", [0, 1, 255])
def test_compressed_trajectory_is_flown(hovering: Vehicle, n_pieces: int) -> None:
    assert define_compressed(hovering, offset=7, id=30, n_pieces=n_pieces) == lib.CF_OK
    assert hovering.start(id=30) == lib.CF_OK
    setpoint = hovering.setpoint_at(6.0)
    assert [xyz(setpoint.position), xyz(setpoint.velocity)] == [[1.5, 2, 3], [0.5, 0, 0]]
    end = hovering.setpoint_at(8.0)
    assert [xyz(end.position), xyz(end.velocity)] == [[2, 2, 3], [0, 0, 0]]
    assert hovering.plan == FLYING


def test_relative_compressed_trajectory_starts_here(hovering: Vehicle) -> None:
    define_compressed(hovering)
    assert hovering.start(relative_position=True, relative_yaw=True) == lib.CF_OK
    assert xyz(hovering.setpoint().position) == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("how", [{"timescale": 2.0}, {"timescale": 0.5}, {"reversed": True}])
def test_compressed_trajectory_flies_forward_at_its_own_pace_only(hovering: Vehicle, how) -> None:
    define_compressed(hovering)
    before = bytes(ffi.buffer(hovering.provider.state))
    assert hovering.start(**how) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(hovering.provider.state)) == before


@pytest.mark.parametrize(
    ("id", "offset", "status"),
    [
        (0, 4088, lib.CF_OK),
        (0, 4089, lib.CF_ERR_CAPACITY),
        (0, 4096, lib.CF_ERR_CAPACITY),
        (0, 2**32 - 1, lib.CF_ERR_CAPACITY),
        (31, 0, lib.CF_ERR_CAPACITY),
    ],
)
def test_compressed_definition_needs_room_for_its_start(vehicle: Vehicle, id: int, offset: int, status: int) -> None:
    assert vehicle.define(id=id, type=lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED, offset=offset) == status


@pytest.mark.parametrize("type", [2, 255])
def test_trajectories_of_other_types_are_unknown(vehicle: Vehicle, type: int) -> None:
    assert vehicle.define(type=type) == lib.CF_ERR_UNKNOWN
    assert not lib.cf_high_level_commander_is_trajectory_defined(vehicle.commander, 0)


@given(st.integers(0, 2**32 - 1) | st.integers(0, 4200), st.binary(max_size=4200))
def test_memory_keeps_what_fits_and_refuses_the_rest(offset: int, data: bytes) -> None:
    commander = ffi.new("cf_high_level_commander_t *")
    lib.cf_high_level_commander_init(commander)
    fits = offset + len(data) <= MEMORY_BYTES
    status = lib.cf_high_level_commander_write_trajectory(commander, offset, len(data), data)
    assert status == (lib.CF_OK if fits else lib.CF_ERR_CAPACITY)

    copy = ffi.new("uint8_t[]", max(len(data), 1))
    status = lib.cf_high_level_commander_read_trajectory(commander, offset, len(data), copy)
    assert status == (lib.CF_OK if fits else lib.CF_ERR_CAPACITY)
    if fits:
        assert bytes(ffi.buffer(copy, len(data))) == data


@pytest.mark.parametrize(("offset", "length"), [(0, 4097), (4096, 1), (1, 2**32 - 1), (2**32 - 1, 2**32 - 1)])
def test_memory_lengths_cannot_overflow(vehicle: Vehicle, offset: int, length: int) -> None:
    read = lib.cf_high_level_commander_read_trajectory
    assert read(vehicle.commander, offset, length, ffi.NULL) == lib.CF_ERR_CAPACITY
    write = lib.cf_high_level_commander_write_trajectory
    assert write(vehicle.commander, offset, length, ffi.NULL) == lib.CF_ERR_CAPACITY


# --- groups, parameters


@pytest.mark.parametrize(
    ("mask", "group", "concerns"), [(0, 0, True), (0, 1, False), (0b0101, 0b0100, True), (0b0101, 0b1010, False)]
)
def test_group_decides_whom_a_command_concerns(vehicle: Vehicle, mask: int, group: int, concerns: bool) -> None:
    lib.cf_high_level_commander_set_group_mask(vehicle.commander, mask)
    assert lib.cf_high_level_commander_is_in_group(vehicle.commander, group) == concerns


def test_parameters_have_names_types_flags_and_defaults(vehicle: Vehicle) -> None:
    table = lib.cf_high_level_commander_parameters()
    rows = [table.rows[i] for i in range(table.count)]
    assert {ffi.string(row.group) for row in rows} == {b"hlCommander"}
    assert [(ffi.string(row.name), row.type, row.flags) for row in rows] == [
        (b"vtoff", lib.CF_TYPE_FLOAT, lib.CF_CORE),
        (b"vland", lib.CF_TYPE_FLOAT, lib.CF_CORE),
        (b"groupmask", lib.CF_TYPE_UINT8, lib.CF_CORE),
    ]
    commander = vehicle.commander
    assert [commander.vtoff, commander.vland, commander.group_mask] == [0.5, 0.5, 0]
