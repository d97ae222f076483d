"""Packets of ports 3 and 7 (docs/reference/planner-commander.md#9 and #17.2, docs/reference/crtp-cflib.md#21)."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packet_bytes import BAD_FLOATS, OK, UNKNOWN, VALUE, decode, floats, refusals
from setpoint_members import ABS, VELOCITY, garbage, members, modes

from crazychoir_fw._core import ffi, lib


@pytest.fixture
def cppm():
    return default_cppm()


def default_cppm():
    cppm = ffi.new("cf_cppm_t *")
    lib.cf_cppm_init(cppm)
    return cppm


def decoded(data: bytes, cppm):
    setpoint = garbage()
    assert decode(lib.cf_generic_packet_decode, setpoint, cppm, data=data) == OK
    return setpoint


WORLD = {"velocity.x": 0.1, "velocity.y": 0.2, "velocity.z": 0.3} | modes(
    x=VELOCITY, y=VELOCITY, z=VELOCITY, yaw=VELOCITY
)
HEIGHT = {"attitude.roll": 1, "attitude.pitch": 2, "position.z": 0.5} | modes(roll=ABS, pitch=ABS, yaw=VELOCITY, z=ABS)
CLIMB = {"attitude.roll": 1, "attitude.pitch": 2, "velocity.z": 0.25} | modes(
    roll=ABS, pitch=ABS, yaw=VELOCITY, z=VELOCITY
)
HOVER = {"velocity.x": 0.1, "velocity.y": 0.2, "velocity_body": True, "position.z": 0.5} | modes(
    x=VELOCITY, y=VELOCITY, yaw=VELOCITY, z=ABS
)
STICKS = {"attitudeRate.yaw": -40, "thrust": 32767.5} | modes(yaw=VELOCITY)
YAW_40 = "cdcccc3dcdcc4c3e9a99993e00002042"

# docs/reference/planner-commander.md#17.2: packet, members of the setpoint
GENERIC = [
    ("00", {}),
    (f"01{YAW_40}", WORLD | {"attitudeRate.yaw": -40}),
    (f"08{YAW_40}", WORLD | {"attitudeRate.yaw": 40}),
    ("020000803f000000400000f0410000003f", HEIGHT | {"attitudeRate.yaw": -30}),
    ("090000803f000000400000f0410000003f", HEIGHT | {"attitudeRate.yaw": 30}),
    ("040000803f000000400000f0410000803e", CLIMB | {"attitudeRate.yaw": 30}),
    ("05cdcccc3dcdcc4c3e0000f0410000003f", HOVER | {"attitudeRate.yaw": -30}),
    ("0acdcccc3dcdcc4c3e0000f0410000003f", HOVER | {"attitudeRate.yaw": 30}),
    (
        "03004006aa050e06dc05",
        STICKS | {"attitude.roll": -10, "attitude.pitch": 5} | modes(roll=ABS, pitch=ABS),
    ),
    (
        "03014006aa050e06dc05e803",
        STICKS | {"attitudeRate.roll": -144, "attitudeRate.pitch": 72} | modes(roll=VELOCITY, pitch=VELOCITY),
    ),
    (
        "06e803d007b80b6400c8002c019001f4015802d94482c41027204e3075",
        {"position.x": 1, "position.y": 2, "position.z": 3}
        | {"velocity.x": 0.1, "velocity.y": 0.2, "velocity.z": 0.3}
        | {"acceleration.x": 0.4, "acceleration.y": 0.5, "acceleration.z": 0.6}
        | {"attitudeRate.roll": 572.95776, "attitudeRate.pitch": 1145.91553, "attitudeRate.yaw": 1718.87329}
        | {"attitudeQuaternion.x": 0.09963, "attitudeQuaternion.y": 0.20065}
        | {"attitudeQuaternion.z": 0.30028, "attitudeQuaternion.w": 0.92717}
        | modes(x=ABS, y=ABS, z=ABS, quat=ABS),
    ),
    (
        "070000803f000000400000404000003442",
        {"position.x": 1, "position.y": 2, "position.z": 3, "attitude.yaw": 45} | modes(x=ABS, y=ABS, z=ABS, yaw=ABS),
    ),
    (
        "0b0000803f000000c00000f041b88801",
        {"attitudeRate.roll": 1, "attitudeRate.pitch": -2, "attitudeRate.yaw": 30, "thrust": 35000}
        | modes(roll=VELOCITY, pitch=VELOCITY, yaw=VELOCITY),
    ),
    (
        "0b0000803f000000c00000f041b88800",
        {"attitude.roll": 1, "attitude.pitch": -2, "attitudeRate.yaw": 30, "thrust": 35000}
        | modes(roll=ABS, pitch=ABS, yaw=VELOCITY),
    ),
]

# docs/reference/crtp-cflib.md#21, captured from cflib 0.1.34
CAPTURED = [
    (
        "080000803f000000400000404000008040",
        {"velocity.x": 1, "velocity.y": 2, "velocity.z": 3, "attitudeRate.yaw": 4}
        | modes(x=VELOCITY, y=VELOCITY, z=VELOCITY, yaw=VELOCITY),
    ),
    (
        "090000803f000000400000404000008040",
        {"attitude.roll": 1, "attitude.pitch": 2, "attitudeRate.yaw": 3, "position.z": 4}
        | modes(roll=ABS, pitch=ABS, yaw=VELOCITY, z=ABS),
    ),
    (
        "0a0000803f000000400000404000008040",
        {"velocity.x": 1, "velocity.y": 2, "velocity_body": True, "attitudeRate.yaw": 3, "position.z": 4}
        | modes(x=VELOCITY, y=VELOCITY, yaw=VELOCITY, z=ABS),
    ),
    (
        "06e803d007b80ba00f88137017581b401f2823000000c0e803d007b80b",
        {"position.x": 1, "position.y": 2, "position.z": 3}
        | {"velocity.x": 4, "velocity.y": 5, "velocity.z": 6}
        | {"acceleration.x": 7, "acceleration.y": 8, "acceleration.z": 9}
        | {"attitudeQuaternion.w": 1}
        | {"attitudeRate.roll": 57.295776, "attitudeRate.pitch": 114.591553, "attitudeRate.yaw": 171.887329}
        | modes(x=ABS, y=ABS, z=ABS, quat=ABS),
    ),
    (
        "070000803f00000040000040400000b442",
        {"position.x": 1, "position.y": 2, "position.z": 3, "attitude.yaw": 90} | modes(x=ABS, y=ABS, z=ABS, yaw=ABS),
    ),
    (
        "0b0000803f000000c000004040b88801",
        {"attitudeRate.roll": 1, "attitudeRate.pitch": -2, "attitudeRate.yaw": 3, "thrust": 35000}
        | modes(roll=VELOCITY, pitch=VELOCITY, yaw=VELOCITY),
    ),
]


@pytest.mark.parametrize(("packet", "expected"), GENERIC + CAPTURED)
def test_generic_packet_is_decoded(cppm, packet: str, expected) -> None:
    found = members(decoded(bytes.fromhex(packet), cppm))
    # the attitude is given there in five digits
    attitude = {path: found.pop(path) for path in list(found) if "Quaternion" in path}
    assert found == pytest.approx({p: v for p, v in expected.items() if "Quaternion" not in p}, rel=1e-7)
    assert attitude == pytest.approx({p: v for p, v in expected.items() if "Quaternion" in p}, abs=5e-6)


@pytest.mark.parametrize("packet", [packet for packet, _ in GENERIC])
def test_generic_packet_of_a_wrong_length_is_refused(cppm, packet: str) -> None:
    for data in refusals(bytes.fromhex(packet)):
        setpoint = garbage()
        assert decode(lib.cf_generic_packet_decode, setpoint, cppm, data=data) == VALUE
        assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


@pytest.mark.parametrize("bad", BAD_FLOATS, ids=bytes.hex)
@pytest.mark.parametrize(("kind", "count"), [(1, 4), (2, 4), (4, 4), (5, 4), (7, 4), (8, 4), (9, 4), (10, 4), (11, 3)])
def test_generic_packet_with_what_is_no_number_is_refused(cppm, kind: int, count: int, bad: bytes) -> None:
    for i in range(count):
        data = bytes([kind]) + floats(*[1.0] * i) + bad + floats(*[1.0] * (count - 1 - i)) + b"\0\0\0" * (kind == 11)
        setpoint = garbage()
        assert decode(lib.cf_generic_packet_decode, setpoint, cppm, data=data) == VALUE
        assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


def test_attitude_that_no_rotation_has_is_refused(cppm) -> None:
    data = bytes([6]) + bytes(18) + struct.pack("<I", 0x1FF7FDFF) + bytes(6)
    setpoint = garbage()
    assert decode(lib.cf_generic_packet_decode, setpoint, cppm, data=data) == VALUE
    assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


@pytest.mark.parametrize("kind", [12, 13, 100, 255])
def test_unknown_type_of_any_length_stops_the_motors(cppm, kind: int) -> None:
    for length in (0, 5, 29):
        assert members(decoded(bytes([kind]) + b"\xff" * length, cppm)) == {}


def test_manual_packet_asks_for_rates_with_a_one_only(cppm) -> None:
    data = floats(1, 2, 3) + struct.pack("<H", 30000)
    assert [decoded(b"\x0b" + data + bytes([flag]), cppm).mode.roll for flag in (0, 1, 2, 255)] == [
        ABS,
        VELOCITY,
        ABS,
        ABS,
    ]


@pytest.mark.parametrize("n_aux", range(16))
def test_cppm_packet_carries_up_to_ten_auxiliary_channels(cppm, n_aux: int) -> None:
    """The high half of the first byte is reserved."""
    data = bytes([3, 0xA0 | n_aux]) + struct.pack(f"<{4 + n_aux}H", 1600, 1450, 1550, 1500, *[1000] * n_aux)
    setpoint = garbage()
    status = decode(lib.cf_generic_packet_decode, setpoint, cppm, data=data)
    assert status == (OK if n_aux <= 10 else VALUE)
    if n_aux <= 10:
        assert setpoint.mode.roll == (VELOCITY if n_aux else ABS)


# --- properties: what is packed comes back

FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)
INT16 = st.integers(-32768, 32767)

# type, sign of the yaw rate, members in the order of the packet
FLOAT_TYPES = [
    (1, -1, ["velocity.x", "velocity.y", "velocity.z", "attitudeRate.yaw"]),
    (2, -1, ["attitude.roll", "attitude.pitch", "attitudeRate.yaw", "position.z"]),
    (4, 1, ["attitude.roll", "attitude.pitch", "attitudeRate.yaw", "velocity.z"]),
    (5, -1, ["velocity.x", "velocity.y", "attitudeRate.yaw", "position.z"]),
    (7, 1, ["position.x", "position.y", "position.z", "attitude.yaw"]),
    (8, 1, ["velocity.x", "velocity.y", "velocity.z", "attitudeRate.yaw"]),
    (9, 1, ["attitude.roll", "attitude.pitch", "attitudeRate.yaw", "position.z"]),
    (10, 1, ["velocity.x", "velocity.y", "attitudeRate.yaw", "position.z"]),
]


@pytest.mark.parametrize(("kind", "sign", "paths"), FLOAT_TYPES)
@given(values=st.tuples(FINITE, FINITE, FINITE, FINITE))
def test_floats_come_back(kind: int, sign: int, paths, values) -> None:
    found = members(decoded(bytes([kind]) + floats(*values), default_cppm()))
    for path, value in zip(paths, values, strict=True):
        assert found.get(path, 0.0) == (sign * value if path == "attitudeRate.yaw" else value)


@given(st.lists(INT16, min_size=9, max_size=9), st.lists(INT16, min_size=3, max_size=3))
def test_full_state_comes_back(lengths, rates) -> None:
    data = struct.pack("<B9hI3h", 6, *lengths, 0xC0000000, *rates)
    s = decoded(data, default_cppm())
    found = [getattr(v, axis) for v in (s.position, s.velocity, s.acceleration) for axis in "xyz"]
    assert found == pytest.approx([value / 1000 for value in lengths], rel=1e-6)
    found = [s.attitudeRate.roll, s.attitudeRate.pitch, s.attitudeRate.yaw]
    assert found == pytest.approx([math.degrees(rate / 1000) for rate in rates], rel=1e-6)


@given(st.tuples(FINITE, FINITE, FINITE), st.integers(0, 65535), st.booleans())
def test_manual_comes_back(values, thrust: int, is_rate: bool) -> None:
    s = decoded(b"\x0b" + floats(*values) + struct.pack("<H?", thrust, is_rate), default_cppm())
    angles = s.attitudeRate if is_rate else s.attitude
    assert (angles.roll, angles.pitch, s.attitudeRate.yaw, s.thrust) == (*values, thrust)


@given(st.binary(max_size=30))
def test_any_bytes_make_a_finite_setpoint_or_none(data: bytes) -> None:
    setpoint = garbage()
    status = decode(lib.cf_generic_packet_decode, setpoint, default_cppm(), data=data)
    assert status in (OK, VALUE)
    assert lib.cf_setpoint_is_finite(setpoint)
    if status == VALUE:
        assert bytes(ffi.buffer(setpoint)) == bytes(ffi.buffer(garbage()))


# --- port 7 channel 1


@pytest.mark.parametrize(
    ("packet", "status"),
    [
        ("0064000000", OK),
        ("00ffffffff", OK),
        ("", VALUE),
        ("00", VALUE),
        ("00640000", VALUE),
        ("006400000000", VALUE),
        ("01", UNKNOWN),
        ("0164000000", UNKNOWN),
    ],
)
def test_meta_packet(packet: str, status: int) -> None:
    assert decode(lib.cf_meta_packet_decode, None, data=bytes.fromhex(packet)) == status


# --- port 3


def rpyt_decoded(data: bytes):
    packet = ffi.new("cf_rpyt_packet_t *")
    return packet, decode(lib.cf_rpyt_packet_decode, packet, data=data)


def test_rpyt_packet_of_cflib_is_decoded() -> None:
    """send_setpoint(1, 2, 3, 40000): the client negates the pitch."""
    packet, status = rpyt_decoded(bytes.fromhex("0000803f000000c000004040409c"))
    assert status == OK
    assert [packet.roll, packet.pitch, packet.yaw, packet.thrust] == [1.0, -2.0, 3.0, 40000]


def test_rpyt_packet_of_a_closing_client_is_all_zero() -> None:
    packet, status = rpyt_decoded(bytes(14))
    assert status == OK
    assert [packet.roll, packet.pitch, packet.yaw, packet.thrust] == [0.0, 0.0, 0.0, 0]


def test_rpyt_packet_of_a_wrong_length_is_refused() -> None:
    for data in refusals(bytes(14)):
        assert rpyt_decoded(data)[1] == VALUE


@pytest.mark.parametrize("bad", BAD_FLOATS, ids=bytes.hex)
@pytest.mark.parametrize("place", range(3))
def test_rpyt_packet_with_what_is_no_number_is_refused(place: int, bad: bytes) -> None:
    data = floats(*[1.0] * place) + bad + floats(*[1.0] * (2 - place)) + b"\0\0"
    assert rpyt_decoded(data)[1] == VALUE


@given(st.tuples(FINITE, FINITE, FINITE), st.integers(0, 65535))
def test_rpyt_comes_back(values, thrust: int) -> None:
    packet, status = rpyt_decoded(floats(*values) + struct.pack("<H", thrust))
    assert status == OK
    assert (packet.roll, packet.pitch, packet.yaw, packet.thrust) == (*values, thrust)
