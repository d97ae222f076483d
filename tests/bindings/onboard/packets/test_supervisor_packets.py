"""Packets of port 9 (docs/reference/planner-commander.md#14.10, docs/reference/crtp-cflib.md#7)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packet_bytes import OK, UNKNOWN, VALUE, new_reply, reply_of

from crazychoir_fw._core import ffi, lib

INFO, COMMAND = 0, 1
NOW = 5000


def new_supervisor(auto_arming: bool = False):
    supervisor = ffi.new("cf_supervisor_t *")
    lib.cf_supervisor_init(supervisor, auto_arming)
    return supervisor


@pytest.fixture
def supervisor():
    return new_supervisor()


def receive(supervisor, channel: int, data: bytes):
    reply = new_reply()
    block = ffi.new("uint8_t[]", data) if data else ffi.NULL
    status = lib.cf_supervisor_packet(supervisor, NOW, channel, block, len(data), reply)
    return status, reply_of(reply).hex()


@pytest.mark.parametrize("query", range(1, 12))
def test_question_is_answered_with_the_bit_of_its_number(supervisor, query: int) -> None:
    supervisor.info = 1 << (query - 1)
    # the reply has the current value of these two, not that of the last update
    supervisor.is_armed = query == 2
    supervisor.is_crashed = query == 8
    for other in range(1, 12):
        assert receive(supervisor, INFO, bytes([other])) == (OK, f"{other | 0x80:02x}{other == query:02x}")


def test_bitfield_is_sent_as_a_whole(supervisor) -> None:
    supervisor.info = 0x0423
    assert receive(supervisor, INFO, b"\x0c") == (OK, "8c2304")


def test_arming_is_seen_before_the_next_update(supervisor) -> None:
    supervisor.state = lib.supervisorStatePreFlChecksPassed
    assert receive(supervisor, INFO, b"\x02") == (OK, "8200")
    assert receive(supervisor, COMMAND, b"\x01\x01") == (OK, "810101")
    assert receive(supervisor, INFO, b"\x02") == (OK, "8201")


@pytest.mark.parametrize("argument", [1, 2, 255])
def test_arming_is_refused_in_the_wrong_state(supervisor, argument: int) -> None:
    assert receive(supervisor, COMMAND, bytes([1, argument])) == (OK, "810000")
    assert not supervisor.is_armed


def test_disarming_is_obeyed(supervisor) -> None:
    supervisor.is_armed = True
    assert receive(supervisor, COMMAND, b"\x01\x00") == (OK, "810100")
    assert not supervisor.is_armed


def test_recovery_succeeds_unless_tumbled(supervisor) -> None:
    supervisor.is_crashed = True
    supervisor.is_tumbled = 1
    assert receive(supervisor, COMMAND, b"\x02") == (OK, "820000")
    assert supervisor.is_crashed
    supervisor.is_tumbled = 0
    assert receive(supervisor, COMMAND, b"\x02") == (OK, "820101")
    assert not supervisor.is_crashed


def test_emergency_stop_is_latched_without_an_answer(supervisor) -> None:
    assert receive(supervisor, COMMAND, b"\x03") == (OK, "")
    assert supervisor.emergency_stop_requested


def test_watchdog_is_fed_without_an_answer(supervisor) -> None:
    assert receive(supervisor, COMMAND, b"\x04") == (OK, "")
    assert (supervisor.emergency_watchdog_started, supervisor.emergency_watchdog_tick) == (True, NOW)
    assert not supervisor.emergency_stop_requested


@pytest.mark.parametrize(
    ("channel", "packet", "status"),
    [
        (INFO, "", VALUE),
        (INFO, "0100", VALUE),
        (INFO, "0c00", VALUE),
        (INFO, "00", UNKNOWN),
        (INFO, "0d", UNKNOWN),
        (INFO, "ff", UNKNOWN),
        (COMMAND, "", VALUE),
        (COMMAND, "01", VALUE),
        (COMMAND, "010100", VALUE),
        (COMMAND, "0200", VALUE),
        (COMMAND, "0300", VALUE),
        (COMMAND, "0400", VALUE),
        (COMMAND, "00", UNKNOWN),
        (COMMAND, "05", UNKNOWN),
        (COMMAND, "81", UNKNOWN),
        (2, "01", UNKNOWN),
        (3, "", UNKNOWN),
    ],
)
def test_other_packets_change_nothing_and_are_not_answered(supervisor, channel: int, packet: str, status: int) -> None:
    supervisor.state = lib.supervisorStatePreFlChecksPassed
    before = bytes(ffi.buffer(supervisor))
    assert receive(supervisor, channel, bytes.fromhex(packet)) == (status, "")
    assert bytes(ffi.buffer(supervisor)) == before


@given(st.integers(0, 3), st.binary(max_size=30))
def test_any_bytes_are_answered_or_refused(channel: int, data: bytes) -> None:
    supervisor = new_supervisor(auto_arming=True)
    before = bytes(ffi.buffer(supervisor))
    status, reply = receive(supervisor, channel, data)
    if status == OK:
        assert not reply or bytes.fromhex(reply)[0] == data[0] | 0x80
    else:
        assert (reply, bytes(ffi.buffer(supervisor))) == ("", before)
