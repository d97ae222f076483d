"""Log blocks are put together, and every refusal has its number (docs/reference/crtp-cflib.md#8.2, #22)."""

import errno
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_requests import (
    APPEND,
    CREATE,
    DELETE,
    FLOAT,
    FP16,
    INT16,
    RESET,
    START,
    START_MS,
    STOP,
    UINT8,
    control,
    entries,
)

from crazychoir_fw.crtp.packet import Packet, parse
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World

SEVEN_FLOATS = [("stateEstimate.x", FLOAT)] * 7


@pytest.fixture(scope="module")
def world():
    return World([DroneConfig("cf1")], visuals=False)


@pytest.fixture
def station(world):
    station = Station(world, world["cf1"])
    yield station
    station.end_session()
    station.context.carry_out()
    world.reset()


def packets(station, ticks=100):
    """Let time pass and return the log packets."""
    station.context.carry_out()
    station.context.take_out()
    station.context.world.step(ticks)
    return [parse(datagram).payload for datagram, _ in station.context.take_out()]


def test_a_session_begins_with_a_reset(station):
    assert station.receive(bytes.fromhex("5d 05")) == [bytes.fromhex("5d 05 00 00")]


def test_stray_bytes_are_ignored_and_the_rest_comes_by_append(station):
    # as captured from cflib: nine whole entries and one byte of the tenth, then the tenth to the twentieth
    create = bytes.fromhex("5d 06 02") + b"".join(struct.pack("<BH", 0x11, i) for i in range(9)) + b"\x11"
    append = bytes.fromhex("5d 07 02") + b"".join(struct.pack("<BH", 0x11, i) for i in range(9, 18))
    assert len(create) == 31
    assert station.receive(create) == [bytes.fromhex("5d 06 02 00")]
    assert station.receive(append) == [bytes.fromhex("5d 07 02 00")]
    assert control(station, START, 2, b"\x01") == 0
    assert {len(payload) for payload in packets(station)} == {4 + 18}


@pytest.mark.parametrize("command", [0, 1, 9, 200])
def test_old_and_unknown_commands(station, command):
    assert control(station, command, 3, b"\x01\x01\x01") == errno.ENOEXEC


@pytest.mark.parametrize(
    ("command", "rest"), [(DELETE, b""), (START, b"\1"), (STOP, b""), (APPEND, b""), (START_MS, b"\1\0")]
)
def test_a_block_that_there_is_not(station, command, rest):
    assert control(station, command, 9, rest) == errno.ENOENT


@pytest.mark.parametrize(("command", "rest"), [(START, b""), (START_MS, b""), (START_MS, b"\x0a")])
def test_a_start_without_its_period(station, command, rest):
    assert control(station, CREATE, 1) == 0
    assert control(station, command, 1, rest) == errno.ENOEXEC


@pytest.mark.parametrize("command", [DELETE, START, STOP, CREATE, APPEND, START_MS])
def test_a_command_without_its_block(station, command):
    assert station.receive(bytes((0x5D, command))) == [bytes((0x5D, command, 0, errno.ENOEXEC))]
    assert station.receive(b"\x5d") == []


def test_a_block_exists_once(station):
    assert control(station, CREATE, 1) == 0
    assert control(station, CREATE, 1) == errno.EEXIST
    assert control(station, DELETE, 1) == 0
    assert control(station, CREATE, 1) == 0


def test_a_block_has_26_bytes_and_keeps_what_fits(station):
    assert control(station, CREATE, 1, entries(*SEVEN_FLOATS)) == errno.E2BIG
    assert control(station, APPEND, 1, entries(("stateEstimate.y", FLOAT))) == errno.E2BIG
    assert control(station, APPEND, 1, entries(("stateEstimate.y", FP16))) == 0
    assert control(station, START, 1, b"\x01") == 0
    assert {len(payload) for payload in packets(station)} == {4 + 26}


@pytest.mark.parametrize("entry", [b"\x07\xff\xff", b"\x07\xff\x7f", b"\x00\x00\x00", b"\x09\x00\x00", b"\x0f\x00\x00"])
def test_an_unknown_variable_or_type_ends_the_request(station, entry):
    known = entries(("stateEstimate.x", FLOAT))
    assert control(station, CREATE, 1, known + entry + known) == errno.ENOENT
    assert control(station, START, 1, b"\x01") == 0
    assert {len(payload) for payload in packets(station)} == {4 + 4}


def test_the_high_nibble_of_a_type_does_not_matter(station):
    (request,) = [entries(("stateEstimate.x", FLOAT))]
    assert control(station, CREATE, 1, bytes((request[0] | 0x50,)) + request[1:]) == 0


def test_there_are_16_blocks(station):
    assert [control(station, CREATE, number) for number in range(17)] == [0] * 16 + [errno.ENOMEM]
    assert control(station, DELETE, 5) == 0
    assert control(station, CREATE, 99) == 0


def test_there_are_128_values(station):
    nine = entries(*[("supervisor.info", UINT8)] * 9)
    for number in range(14):
        assert control(station, CREATE, number, nine) == 0
    assert control(station, CREATE, 14, nine) == errno.ENOMEM
    assert control(station, START, 14, b"\x01") == 0
    assert {len(payload) for payload in packets(station)} == {4 + 2}
    assert control(station, DELETE, 0) == 0
    assert control(station, APPEND, 14, nine) == 0


def test_a_reset_deletes_all(station):
    assert control(station, CREATE, 1, entries(("stateEstimate.x", FLOAT))) == 0
    assert control(station, START, 1, b"\x01") == 0
    assert packets(station)
    assert control(station, RESET) == 0
    assert packets(station) == []
    assert control(station, START, 1, b"\x01") == errno.ENOENT


def test_starts_beyond_what_can_wait_are_refused(station):
    assert control(station, CREATE, 1) == 0
    while station.context.later(lambda: None):
        pass
    assert control(station, START, 1, b"\x01") == errno.ENOMEM
    station.context.carry_out()
    assert control(station, START, 1, b"\x01") == 0


def test_a_flood_of_starts_waits_as_one(station):
    assert control(station, CREATE, 1, entries(("stabilizer.roll", INT16))) == 0
    waiting = []
    station.context.later = lambda change: waiting.append(change) or True
    for period in range(1, 200):
        assert control(station, START, 1, bytes((period,))) == 0
    assert len(waiting) == 1


@st.composite
def control_packets(draw):
    command = draw(st.sampled_from([*range(10), 255]))
    number = draw(st.integers(0, 3))
    size = draw(st.integers(0, 28))
    return (bytes((command, number)) + draw(st.binary(min_size=size, max_size=size)))[: draw(st.integers(0, 30))]


@given(st.lists(st.tuples(st.sampled_from([0, 1, 1, 1, 2, 3]), control_packets(), st.booleans()), max_size=30))
def test_any_packets_are_answered_in_the_right_shape(world, requests):
    station = Station(world, world["cf1"])
    for channel, payload, is_stepped in requests:
        for reply in station.receive(Packet(5, channel, payload).to_bytes()):
            answer = parse(reply)
            assert (answer.port, answer.channel) == (5, channel)
            if channel == 1:
                assert answer.payload[0] == payload[0]
                assert answer.payload[2] in (0, errno.ENOENT, errno.E2BIG, errno.ENOEXEC, errno.ENOMEM, errno.EEXIST)
        if is_stepped:
            station.context.carry_out()
            world.step(5)
    for datagram, _ in station.context.take_out():
        assert parse(datagram).port in (0, 5)
        assert len(datagram) <= 31
    station.end_session()
    world.step(20)
