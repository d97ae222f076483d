"""Packets of port 8: bytes captured from cflib, every field, every return code, and bytes that are no packet.

docs/reference/planner-commander.md#7.1 and #7.2, docs/reference/crtp-cflib.md#13 and #21.
"""

import math
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planning_provider import planning_provider
from setpoint_numbers import setpoint_numbers

from crazychoir_fw._core import ffi, lib

OK, REFUSED, NOEXEC, BUSY = 0, 1, 8, 16

# command: struct format of its record
RECORDS = {
    0: "<B",
    1: "<Bff",
    2: "<Bff",
    3: "<B",
    4: "<BBfffff",
    5: "<BBBBf",
    6: "<BBBIB",
    7: "<BffBf",
    8: "<BffBf",
    9: "<BfBfBf",
    10: "<BfBfBf",
    11: "<BBBfffff",
    12: "<BBBfffff",
    13: "<BBBBBf",
}
# docs/reference/planner-commander.md#7.2
SIZES = {0: 1, 1: 9, 2: 9, 3: 1, 4: 22, 5: 8, 6: 8, 7: 14, 8: 14, 9: 15, 10: 15, 11: 23, 12: 23, 13: 9}


def packet(command: int, *values) -> bytes:
    return bytes([command]) + struct.pack(RECORDS[command], *values)


@dataclass
class Receiver:
    """A high-level commander over a provider that gets packets."""

    provider: Any
    now_us: int = 0
    commander: Any = field(default_factory=lambda: ffi.new("cf_high_level_commander_t *"))

    def __post_init__(self) -> None:
        lib.cf_high_level_commander_init(self.commander)

    def answer(self, data: bytes) -> bytes:
        """Return the whole reply."""
        reply = ffi.new("uint8_t[4]")
        buffer = ffi.new("uint8_t[]", data) if data else ffi.NULL  # exactly as long as the packet
        size = lib.cf_high_level_commander_packet(
            self.commander, self.provider.table, self.provider.state, buffer, len(data), self.now_us, reply
        )
        return bytes(ffi.buffer(reply, size))

    def send(self, command: int, *values) -> int:
        """Return the return code."""
        return self.answer(packet(command, *values))[3]

    def block(self, block: bool = True) -> None:
        lib.cf_high_level_commander_block(self.commander, self.provider.table, self.provider.state, block)

    @property
    def plan(self) -> int:
        return self.provider.plan_state

    def end(self) -> list[float]:
        """Return the end of the plan: x, y, z, yaw, duration."""
        piece = self.provider.state.planned
        ev = lib.poly4d_eval(ffi.new("struct poly4d *", piece), piece.duration)
        return [ev.pos.x, ev.pos.y, ev.pos.z, ev.yaw, piece.duration]


@pytest.fixture
def receiver(provider) -> Receiver:
    """At (1, 2, 0.5) m, yaw 0.25 rad."""
    receiver = Receiver(provider)
    receiver.commander.pos = [1.0, 2.0, 0.5]
    receiver.commander.yaw = 0.25
    return receiver


@pytest.fixture
def flying(receiver) -> Receiver:
    receiver.send(7, 0, 1.0, 0.0, 1, 2.0)
    receiver.now_us = 5_000_000
    return receiver


@pytest.mark.parametrize("command", SIZES)
def test_records_have_the_expected_sizes(command: int) -> None:
    assert struct.calcsize(RECORDS[command]) == SIZES[command]


# --- bytes captured from cflib 0.1.34 (docs/reference/crtp-cflib.md#21)


def test_captured_takeoff(receiver: Receiver) -> None:
    assert receiver.answer(bytes.fromhex("07 00 0000803F 00000000 00 00000040")) == bytes([7, 0, 0, OK])
    assert receiver.plan == lib.TRAJECTORY_STATE_FLYING
    assert receiver.end() == pytest.approx([1.0, 2.0, 1.0, 0.0, 2.0], abs=1e-6)


def test_captured_land(flying: Receiver) -> None:
    assert flying.answer(bytes.fromhex("08 00 00000000 00000000 01 00000040")) == bytes([8, 0, 0, OK])
    assert flying.plan == lib.TRAJECTORY_STATE_LANDING
    assert flying.end() == pytest.approx([1.0, 2.0, 0.0, 0.25, 2.0], abs=1e-6)


def test_captured_go_to(flying: Receiver) -> None:
    go_to = bytes.fromhex("0C 00 01 00 0000803F 00000040 00004040 0000003F 00000040")
    assert flying.answer(go_to) == bytes([12, 0, 1, OK])
    assert flying.end() == pytest.approx([2.0, 4.0, 4.0, 0.75, 2.0], abs=1e-4)


def test_captured_spiral(flying: Receiver) -> None:
    spiral = bytes.fromhex("0B 00 00 00 0000803F 0000003F 9A99193F CDCCCC3D 00000040")
    assert flying.answer(spiral) == bytes([11, 0, 0, OK])
    wanted = ffi.new("cf_spiral_t *", [False, False, 1.0, 0.5, 0.6, 0.1, 2.0])
    expected = ffi.new("cf_planner_t *")
    lib.cf_planner_spiral(expected, ffi.new("cf_plan_start_t *", [[1.0, 2.0, 0.5], [0, 0, 0], 0.25]), wanted, 5.0)
    assert bytes(ffi.buffer(expected)) == bytes(ffi.buffer(flying.provider.state))


def test_captured_definition_and_start(flying: Receiver) -> None:
    assert flying.answer(bytes.fromhex("06 01 01 00 00000000 0A")) == bytes([6, 1, 1, OK])
    definition = flying.commander.definitions[1]
    assert [definition.location, definition.type, definition.offset, definition.n_pieces] == [1, 0, 0, 10]

    assert flying.answer(bytes.fromhex("0D 00 01 00 00 01 0000803F")) == bytes([13, 0, 1, OK])
    state = flying.provider.state
    assert [state.source, state.offset, state.n_pieces, state.timescale] == [lib.CF_PLAN_UPLOADED, 0, 10, 1.0]
    assert [state.shift.x, state.shift.y, state.shift.z] == [1.0, 2.0, 0.5]


def test_captured_stop_and_group_mask(flying: Receiver) -> None:
    assert flying.answer(bytes.fromhex("03 00")) == bytes([3, 0, 0, OK])
    assert flying.plan == lib.TRAJECTORY_STATE_IDLE
    assert flying.answer(bytes.fromhex("00 03")) == bytes([0, 3, 0, OK])
    assert flying.commander.group_mask == 3


def test_captured_compressed_bytes_are_flown(flying: Receiver) -> None:
    data = bytes.fromhex("00000000E8030000 E4D007E803E803D007B80B" + 7 * "3900")  # 0.1 rad is 57 tenths of a degree
    lib.cf_high_level_commander_write_trajectory(flying.commander, 100, len(data), data)
    assert flying.send(6, 5, 1, 1, 100, 1) == OK
    assert flying.send(13, 0, 0, 0, 0, 5, 1.0) == OK
    goal = lib.cf_planner_current_goal(flying.provider.state, flying.commander.memory, 7.0)
    assert [goal.pos.x, goal.pos.y, goal.pos.z] == pytest.approx([0.0, 1.0, 3.0], abs=1e-5)
    assert goal.yaw == pytest.approx(math.radians(5.7), abs=1e-5)


# --- every field


@pytest.mark.parametrize("command", [1, 2])
def test_first_versions_turn_to_yaw_zero(receiver: Receiver, command: int) -> None:
    assert receiver.send(command, 0, 1.25, 3.0) == OK
    assert receiver.end() == pytest.approx([1.0, 2.0, 1.25, 0.0, 3.0], abs=1e-6)


@pytest.mark.parametrize(("use_current_yaw", "yaw"), [(0, -0.5), (1, 0.25), (255, 0.25)])
@pytest.mark.parametrize("command", [7, 8])
def test_second_versions_choose_their_yaw(receiver: Receiver, command: int, use_current_yaw: int, yaw: float) -> None:
    assert receiver.send(command, 0, 1.25, -0.5, use_current_yaw, 3.0) == OK
    assert receiver.end() == pytest.approx([1.0, 2.0, 1.25, yaw, 3.0], abs=1e-6)


# command, height, relative, velocity; height and duration of the plan
@pytest.mark.parametrize(
    ("command", "height", "relative", "velocity", "goal", "duration"),
    [
        (9, 1.5, 0, 0.25, 1.5, 4.0),
        (9, 1.5, 1, 0.5, 2.0, 3.0),
        (9, 1.5, 0, 0.0, 1.5, 2.0),  # vtoff
        (10, 0.25, 0, 0.125, 0.25, 2.0),
        (10, 0.25, 1, 0.125, 0.25, 2.0),
        (10, 0.0, 0, -1.0, 0.0, 0.5),  # vland
    ],
)
def test_velocity_versions_find_their_duration(
    receiver: Receiver, command: int, height: float, relative: int, velocity: float, goal: float, duration: float
) -> None:
    receiver.commander.vland = 1.0
    assert receiver.send(command, 0, height, relative, -0.5, 0, velocity) == OK
    assert receiver.end() == pytest.approx([1.0, 2.0, goal, -0.5, duration], abs=1e-6)
    assert receiver.plan == (lib.TRAJECTORY_STATE_FLYING if command == 9 else lib.TRAJECTORY_STATE_LANDING)


def test_velocity_versions_keep_the_present_yaw(receiver: Receiver) -> None:
    assert receiver.send(9, 0, 1.5, 0, -0.5, 1, 0.25) == OK
    assert receiver.end()[3] == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize(("relative", "x"), [(0, 3.0), (1, 4.0)])
def test_first_go_to_is_smooth(flying: Receiver, relative: int, x: float) -> None:
    assert flying.send(4, 0, relative, 3.0, 2.0, 1.0, 0.5, 4.0) == OK
    assert flying.end()[0] == pytest.approx(x, abs=1e-4)
    assert flying.end()[4] == 4.0
    assert flying.provider.state.planned.p[0][1] == 0.0  # from rest


def test_second_go_to_may_be_linear(flying: Receiver) -> None:
    assert flying.send(12, 0, 0, 1, 3.0, 2.0, 1.0, 0.25, 4.0) == OK
    assert list(flying.provider.state.planned.p[0])[1] == 0.5


@pytest.mark.parametrize("sideways", [0, 1])
@pytest.mark.parametrize("clockwise", [0, 1])
def test_spiral_has_its_sense(flying: Receiver, sideways: int, clockwise: int) -> None:
    assert flying.send(11, 0, sideways, clockwise, 1.0, 2.0, 3.0, 4.0, 5.0) == OK
    wanted = ffi.new("cf_spiral_t *", [sideways, clockwise, 1.0, 2.0, 3.0, 4.0, 5.0])
    expected = ffi.new("cf_planner_t *")
    lib.cf_planner_spiral(expected, ffi.new("cf_plan_start_t *", [[1.0, 2.0, 0.5], [0, 0, 0], 0.25]), wanted, 5.0)
    assert bytes(ffi.buffer(expected)) == bytes(ffi.buffer(flying.provider.state))


def test_starts_have_their_fields(flying: Receiver) -> None:
    memory = np.zeros((2, 33), dtype="<f4")
    memory[:, 0], memory[:, 24], memory[:, 32] = 5.0, 1.0, 2.0
    lib.cf_high_level_commander_write_trajectory(flying.commander, 132, memory.nbytes, memory.tobytes())
    assert flying.send(6, 30, 1, 0, 132, 2) == OK
    state = flying.provider.state

    assert flying.send(5, 0, 1, 1, 30, 0.5) == OK
    assert [state.offset, state.n_pieces, state.timescale, state.reversed] == [132, 2, 0.5, True]
    assert [state.shift.x, state.shift_yaw] == [-4.0, 0.0]

    assert flying.send(13, 0, 1, 1, 0, 30, 2.0) == OK
    assert [state.timescale, state.reversed, state.shift.x] == [2.0, False, -4.0]
    assert state.shift_yaw == pytest.approx(-0.75)

    assert flying.send(13, 0, 0, 1, 1, 30, 2.0) == OK
    assert [state.reversed, state.shift.x, state.shift_yaw] == [True, 0.0, 0.0]


# --- return codes


@pytest.mark.parametrize("command", [*range(14, 256)])
def test_unknown_command_cannot_be_executed(receiver: Receiver, command: int) -> None:
    assert receiver.answer(bytes([command, 1, 2, 3, 4])) == bytes([command, 1, 2, NOEXEC])


def test_empty_packet_has_no_reply(receiver: Receiver) -> None:
    assert receiver.answer(b"") == b""


VALID = {
    0: (5,),
    1: (0, 1.0, 2.0),
    2: (0, 1.0, 2.0),
    3: (0,),
    4: (0, 0, 1.0, 1.0, 1.0, 0.5, 2.0),
    5: (0, 0, 0, 1, 1.0),
    6: (1, 1, 0, 0, 1),
    7: (0, 1.0, 0.0, 0, 2.0),
    8: (0, 1.0, 0.0, 0, 2.0),
    9: (0, 1.0, 0, 0.0, 0, 0.5),
    10: (0, 1.0, 0, 0.0, 0, 0.5),
    11: (0, 0, 0, 1.0, 1.0, 1.0, 1.0, 2.0),
    12: (0, 0, 0, 1.0, 1.0, 1.0, 0.5, 2.0),
    13: (0, 0, 0, 0, 1, 1.0),
}


def state_of(receiver: Receiver) -> bytes:
    return bytes(ffi.buffer(receiver.provider.state)) + bytes(ffi.buffer(receiver.commander))


@pytest.mark.parametrize("command", VALID)
def test_every_shorter_record_is_refused_and_every_longer_one_taken(receiver: Receiver, command: int) -> None:
    receiver.send(6, *VALID[6])
    whole = packet(command, *VALID[command])
    before = state_of(receiver)
    for size in range(1, len(whole)):
        short = whole[:size]
        echo = (short[1:3] + bytes(2))[:2]
        assert receiver.answer(short) == bytes([command]) + echo + bytes([NOEXEC])
    assert state_of(receiver) == before
    assert receiver.answer(whole + b"\xff\xff\xff")[3] == OK


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("command", "place"), [(c, i) for c, fmt in RECORDS.items() for i, kind in enumerate(fmt[1:]) if kind == "f"]
)
def test_numbers_have_to_be_finite(receiver: Receiver, command: int, place: int, value: float) -> None:
    receiver.send(6, *VALID[6])
    values = list(VALID[command])
    values[place] = value
    before = state_of(receiver)
    assert receiver.send(command, *values) == NOEXEC
    assert state_of(receiver) == before


def test_planner_refuses_a_second_takeoff_and_a_second_landing(receiver: Receiver) -> None:
    assert receiver.send(7, *VALID[7]) == OK
    assert [receiver.send(c, *VALID[c]) for c in (1, 7, 9)] == [REFUSED] * 3
    assert receiver.send(8, *VALID[8]) == OK
    assert [receiver.send(c, *VALID[c]) for c in (2, 8, 10)] == [REFUSED] * 3


@pytest.mark.parametrize("command", VALID)
def test_block_holds_all_but_stop_and_settings(receiver: Receiver, command: int) -> None:
    receiver.send(6, *VALID[6])
    receiver.block()
    assert receiver.send(command, *VALID[command]) == (OK if command in (0, 3, 6) else BUSY)


@pytest.mark.parametrize("command", [c for c in VALID if c not in (0, 6)])
def test_command_for_another_group_does_nothing(flying: Receiver, command: int) -> None:
    flying.send(0, 0b0101)
    flying.send(6, *VALID[6])
    before = state_of(flying)
    assert flying.send(command, 0b1010, *VALID[command][1:]) == OK
    assert state_of(flying) == before
    # nor is a command for another group refused while commands are blocked
    flying.block()
    assert flying.send(command, 0b1010, *VALID[command][1:]) == OK


def test_command_for_one_of_the_groups_is_obeyed(receiver: Receiver) -> None:
    receiver.send(0, 0b0101)
    assert receiver.send(7, 0b0100, *VALID[7][1:]) == OK
    assert receiver.plan == lib.TRAJECTORY_STATE_FLYING


@pytest.mark.parametrize("id", [0, 30, 31, 255])
@pytest.mark.parametrize("command", [5, 13])
def test_undefined_trajectory_is_answered_with_success_and_not_flown(flying: Receiver, command: int, id: int) -> None:
    before = state_of(flying)
    values = list(VALID[command])
    values[-2] = id
    assert flying.send(command, *values) == OK
    assert state_of(flying) == before


@pytest.mark.parametrize(
    "definition",
    [
        (31, 1, 0, 0, 1),
        (0, 0, 0, 0, 1),  # no place
        (0, 2, 0, 0, 1),
        (0, 1, 2, 0, 1),  # no type
        (0, 1, 0, 0, 0),
        (0, 1, 0, 0, 32),
        (0, 1, 0, 2, 1),
        (0, 1, 0, 2**32 - 4, 1),
        (0, 1, 1, 4089, 1),
    ],
)
def test_definition_that_cannot_be_flown_is_refused(receiver: Receiver, definition) -> None:
    assert receiver.send(6, *definition) == NOEXEC
    assert not lib.cf_high_level_commander_is_trajectory_defined(receiver.commander, definition[0])


@pytest.mark.parametrize(("reversed", "timescale", "code"), [(0, 1.0, OK), (1, 1.0, NOEXEC), (0, 2.0, NOEXEC)])
def test_compressed_trajectory_runs_forward_at_its_own_pace(
    flying: Receiver, reversed: int, timescale: float, code: int
) -> None:
    assert flying.send(6, 0, 1, 1, 0, 0) == OK
    assert flying.send(13, 0, 1, 1, reversed, 0, timescale) == code
    assert flying.send(5, 0, 1, reversed, 0, timescale) == code


# --- bytes that are no packet


plausible = st.sampled_from(sorted(RECORDS)).flatmap(
    lambda c: st.binary(min_size=SIZES[c], max_size=SIZES[c]).map(lambda record: bytes([c, 0]) + record[1:])
)


@given(st.binary(max_size=512), st.lists(plausible | st.binary(max_size=31), max_size=12))
def test_random_memory_and_packets_never_give_a_setpoint_that_is_not_finite(memory: bytes, packets) -> None:
    receiver = Receiver(planning_provider())
    lib.cf_high_level_commander_write_trajectory(receiver.commander, 0, len(memory), memory)
    receiver.send(6, 0, 1, 1, 0, 0)
    receiver.send(6, 1, 1, 0, 0, 3)
    estimate, setpoint = ffi.new("state_t *"), ffi.new("setpoint_t *")
    for data in [packet(13, 0, 1, 1, 0, 1, 1.0), packet(13, 0, 0, 0, 0, 0, 1.0), *packets]:
        reply = receiver.answer(data)
        assert len(reply) == (4 if data else 0)
        for _ in range(3):
            receiver.now_us += 330_000
            made = lib.cf_high_level_commander_get_setpoint(
                receiver.commander,
                receiver.provider.table,
                receiver.provider.state,
                estimate,
                10,
                receiver.now_us,
                setpoint,
            )
            if made:
                assert np.isfinite(setpoint_numbers(setpoint)).all()
