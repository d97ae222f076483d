"""Packets of port 6 (docs/reference/crtp-cflib.md#14 and #21)."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packet_bytes import BAD_FLOATS, OK, UNKNOWN, VALUE, decode, floats, refusals

from crazychoir_fw._core import ffi, lib

OWN = 7
POSITION, GENERIC, PACKED = 0, 1, 2
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)
INT16 = st.integers(-32768, 32767)


def try_decode(channel: int, data: bytes):
    packet = ffi.new("cf_localization_packet_t *")
    ffi.memmove(packet, b"\x55" * ffi.sizeof("cf_localization_packet_t"), ffi.sizeof("cf_localization_packet_t"))
    before = bytes(ffi.buffer(packet))
    status = decode(lib.cf_localization_packet_decode, packet, OWN, channel, data=data)
    assert (status == OK) == (bytes(ffi.buffer(packet)) != before)
    return status, packet


def decoded(channel: int, data: bytes):
    status, packet = try_decode(channel, data)
    assert status == OK
    return packet


def items(packet):
    """Return (id, position, attitude or None) of each vehicle."""
    return [
        (item.id, list(item.position), list(item.quat_xyzw) if item.has_attitude else None)
        for item in packet.items[0 : packet.n_items]
    ]


# docs/reference/crtp-cflib.md#21, captured from cflib 0.1.34
EXTPOS = bytes.fromhex("0000803f0000004000004040")
EXTPOSE = bytes.fromhex("080000803f00000040000040400000000000000000000000000000803f")
PERSIST = bytes.fromhex("0b03000400")


def test_external_position_is_about_the_own_vehicle() -> None:
    packet = decoded(POSITION, EXTPOS)
    assert items(packet) == [(OWN, [1, 2, 3], None)]
    assert (packet.request, packet.reply_length) == (lib.CF_LOCALIZATION_ASKS_NOTHING, 0)


def test_external_pose_is_about_the_own_vehicle() -> None:
    assert items(decoded(GENERIC, EXTPOSE)) == [(OWN, [1, 2, 3], [0, 0, 0, 1])]


def test_packed_positions_name_their_vehicles() -> None:
    data = struct.pack("<B3h", OWN, 1000, -2000, 3) + struct.pack("<B3h", 9, -32768, 32767, 0)
    assert items(decoded(PACKED, data)) == [
        (OWN, pytest.approx([1.0, -2.0, 0.003]), None),
        (9, pytest.approx([-32.768, 32.767, 0]), None),
    ]


def test_packed_poses_name_their_vehicles() -> None:
    data = struct.pack("<B3hI", 9, 1000, -2000, 3, 0xC0000000) + struct.pack("<B3hI", 0, 0, 0, 0, 0x000001FF)
    assert items(decoded(GENERIC, b"\x09" + data)) == [
        (9, pytest.approx([1.0, -2.0, 0.003]), [0, 0, 0, 1]),
        (0, [0, 0, 0], pytest.approx([0.70710677, 0, 0, 0.70710677])),
    ]


def test_packed_pose_that_no_rotation_has_refuses_the_whole_packet() -> None:
    data = struct.pack("<B3hI", 9, 1, 2, 3, 0xC0000000) + struct.pack("<B3hI", OWN, 1, 2, 3, 0x1FF7FDFF)
    assert try_decode(GENERIC, b"\x09" + data)[0] == VALUE


@pytest.mark.parametrize(
    ("packet", "request_"),
    [("03", lib.CF_LOCALIZATION_ASKS_TO_STOP), ("04", lib.CF_LOCALIZATION_ASKS_TO_WATCH)],
)
def test_emergency_packets_ask_for_a_stop_or_a_watch(packet: str, request_: int) -> None:
    found = decoded(GENERIC, bytes.fromhex(packet))
    assert (found.request, found.n_items, found.reply_length) == (request_, 0, 0)


@pytest.mark.parametrize(
    ("data", "reply"), [(PERSIST, "0b00"), (b"\x02\x03", "020300"), (b"\x02\x03" + b"x" * 28, "020300")]
)
def test_packet_for_a_deck_that_is_missing_is_answered_with_no(data: bytes, reply: str) -> None:
    packet = decoded(GENERIC, data)
    assert packet.request == lib.CF_LOCALIZATION_ASKS_FOR_AN_ANSWER
    assert bytes(packet.reply[0 : packet.reply_length]) == bytes.fromhex(reply)
    assert packet.n_items == 0


@pytest.mark.parametrize(
    ("channel", "good"),
    [(POSITION, EXTPOS), (GENERIC, EXTPOSE), (GENERIC, PERSIST), (GENERIC, b"\x03"), (GENERIC, b"\x04")],
)
def test_packet_of_a_wrong_length_is_refused(channel: int, good: bytes) -> None:
    assert {try_decode(channel, data)[0] for data in refusals(good)} == {VALUE}


@pytest.mark.parametrize(("channel", "head", "size", "most"), [(PACKED, b"", 7, 4), (GENERIC, b"\x09", 11, 2)])
def test_packed_vehicles_come_whole_and_not_too_many(channel: int, head: bytes, size: int, most: int) -> None:
    for length in range(31 - len(head)):
        status, packet = try_decode(channel, head + bytes(length))
        assert status == (OK if length in [size * n for n in range(1, most + 1)] else VALUE)
        assert status == VALUE or packet.n_items == length // size


@pytest.mark.parametrize("bad", BAD_FLOATS, ids=bytes.hex)
def test_what_is_no_number_is_refused(bad: bytes) -> None:
    for i in range(3):
        assert try_decode(POSITION, floats(*[1.0] * i) + bad + floats(*[1.0] * (2 - i)))[0] == VALUE
    for i in range(7):
        assert try_decode(GENERIC, b"\x08" + floats(*[1.0] * i) + bad + floats(*[1.0] * (6 - i)))[0] == VALUE


def test_lps_packet_needs_a_destination() -> None:
    assert try_decode(GENERIC, b"\x02")[0] == VALUE


@pytest.mark.parametrize("kind", sorted(set(range(256)) - {2, 3, 4, 8, 9, 11}))
def test_other_types_are_unknown(kind: int) -> None:
    assert try_decode(GENERIC, bytes([kind]))[0] == UNKNOWN


def test_empty_packet_is_refused_and_other_channels_are_unknown() -> None:
    assert [try_decode(channel, b"")[0] for channel in range(4)] == [VALUE, VALUE, VALUE, UNKNOWN]


@given(st.tuples(*[FINITE] * 7))
def test_pose_comes_back(values) -> None:
    assert items(decoded(POSITION, floats(*values[:3]))) == [(OWN, list(values[:3]), None)]
    assert items(decoded(GENERIC, b"\x08" + floats(*values))) == [(OWN, list(values[:3]), list(values[3:]))]


@given(st.lists(st.tuples(st.integers(0, 255), INT16, INT16, INT16), min_size=1, max_size=4))
def test_packed_positions_come_back(vehicles) -> None:
    data = b"".join(struct.pack("<B3h", *vehicle) for vehicle in vehicles)
    expected = [(v[0], pytest.approx([n / 1000 for n in v[1:]], rel=1e-6), None) for v in vehicles]
    assert items(decoded(PACKED, data)) == expected


@given(st.integers(0, 3), st.binary(max_size=30))
def test_any_bytes_locate_in_numbers_or_are_refused(channel: int, data: bytes) -> None:
    status, packet = try_decode(channel, data)
    assert status in (OK, VALUE, UNKNOWN)
    if status == OK:
        assert all(abs(number) < 4e38 for item in packet.items[0 : packet.n_items] for number in item.position)
        assert all(abs(number) < 4e38 for item in packet.items[0 : packet.n_items] for number in item.quat_xyzw)
