"""Values of log blocks: read as they are stored, sent as the client wants them (docs/reference/crtp-cflib.md#8.3)."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

STORED = {
    lib.CF_LOG_UINT8: np.uint8,
    lib.CF_LOG_UINT16: np.uint16,
    lib.CF_LOG_UINT32: np.uint32,
    lib.CF_LOG_INT8: np.int8,
    lib.CF_LOG_INT16: np.int16,
    lib.CF_LOG_INT32: np.int32,
    lib.CF_LOG_FLOAT: np.float32,
}
BYTES = {1: 1, 2: 2, 3: 4, 4: 1, 5: 2, 6: 4, 7: 4, 8: 2}


@pytest.fixture(scope="module")
def cf():
    return ffi.new("cf_t *")


def packed(cf, values, number=1):
    """Pack numbers that lie one after the other in the memory of a drone: (NumPy number, type to fetch) each."""
    block = ffi.new("cf_log_block_t *")
    block.drone, block.number, block.count = cf, number, len(values)
    at = 1 + ffi.offsetof("cf_t", "provider_state")  # not aligned
    for index, (value, fetched) in enumerate(values):
        stored = next(kind for kind, dtype in STORED.items() if dtype is type(value))
        ffi.memmove(ffi.cast("char *", cf) + at, value.tobytes(), value.nbytes)
        block.values[index] = (at, stored, fetched)
        at += value.nbytes
    packet = ffi.new("uint8_t[]", lib.CF_LOG_PACKET_BYTES)
    lib.cf_log_pack(block, 1, packet)
    return bytes(packet)


def to_int(value):
    """Return what C makes of a number: cut towards zero, what does not fit saturates."""
    if np.isnan(value):
        return 0
    if isinstance(value, np.floating):
        return int(max(min(float(value), 2.0**31 - 1), -(2.0**31)))
    return (int(value) + 2**31) % 2**32 - 2**31


def expected(value, fetched):
    whole = to_int(value)
    real = value if isinstance(value, np.floating) else np.float32(whole)
    if fetched == lib.CF_LOG_FLOAT:
        return real.tobytes()
    if fetched == lib.CF_LOG_FP16:
        return struct.pack("<H", lib.single2half(float(real)))
    return (whole % 2**32).to_bytes(4, "little")[: BYTES[fetched]]


def numbers(dtype):
    if dtype is np.float32:
        return st.floats(width=32).map(np.float32)
    limits = np.iinfo(dtype)
    return st.integers(int(limits.min), int(limits.max)).map(dtype)


def check(cf, values):
    packet = packed(cf, values)
    reference = b"".join(expected(value, fetched) for value, fetched in values)
    assert packet[5 : 5 + len(reference)] == reference
    assert not any(packet[5 + len(reference) :]), "nothing is written behind the values"


WHOLE = [
    0,
    1,
    -1,
    127,
    128,
    255,
    256,
    -129,
    2**15 - 1,
    2**15,
    2**16,
    -(2**15) - 1,
    2**31 - 1,
    2**31,
    2**32 - 1,
    -(2**31),
]
REAL = [0.5, -0.5, 1.999, -1e-9, 65504.0, 65536.0, 6e-5, 2.0**31, -(2.0**31), 1e20, -1e38, np.inf, -np.inf, np.nan]


@pytest.mark.parametrize("fetched", BYTES)
@pytest.mark.parametrize("stored", STORED)
def test_every_pair_of_types_is_converted_as_in_the_reference(cf, stored, fetched):
    dtype = STORED[stored]
    if dtype is np.float32:
        values = [np.float32(value) for value in WHOLE + REAL]
    else:
        values = [dtype(value) for value in WHOLE if np.iinfo(dtype).min <= value <= np.iinfo(dtype).max]
    for value in values:
        check(cf, [(value, fetched)])


@given(st.lists(st.tuples(st.sampled_from([*STORED.values()]).flatmap(numbers), st.sampled_from([*BYTES])), max_size=6))
def test_packets_are_those_of_the_reference(cf, values):
    check(cf, values)


@pytest.mark.parametrize(
    ("value", "fetched", "payload"),
    [
        (np.float32(-1.75), 5, "ffff"),  # cut towards zero
        (np.float32(300.0), 1, "2c"),  # wraps
        (np.float32(70000.5), 2, "7011"),
        (np.int16(-2), 1, "fe"),
        (np.int16(-2), 3, "feffffff"),
        (np.uint32(2**32 - 1), 7, "000080bf"),  # through a signed integer
        (np.uint16(40000), 7, "00401c47"),
        (np.float32(1.5), 8, "003e"),
        (np.int8(-2), 8, "00c0"),
        (np.float32(1e6), 8, "007c"),
        (np.float32("nan"), 6, "00000000"),
    ],
)
def test_conversions(cf, value, fetched, payload):
    assert packed(cf, [(value, fetched)])[5 : 5 + BYTES[fetched]].hex() == payload


def test_head_of_a_packet(cf):
    cf.onboard.tick = 0x12345678
    assert packed(cf, [], number=7)[:5].hex() == "5e07785634"


def test_what_is_computed_when_read_is_computed_once_for_each_drone():
    drones = [ffi.new("cf_t *"), ffi.new("cf_t *")]
    config = ffi.new("cf_config_t *")
    assert lib.cf_config_default(config, lib.CF_PLATFORM_CF2) == lib.CF_OK
    offset = ffi.offsetof("cf_t", "onboard") + ffi.offsetof("cf_onboard_t", "compressed_state")
    blocks = ffi.new("cf_log_block_t[]", 4)
    for index, block in enumerate(blocks):
        block.drone, block.count, block.needs_refresh = drones[index // 2], 1, True
        block.values[0] = (offset, lib.CF_LOG_INT16, lib.CF_LOG_INT16)
    for number, drone in enumerate(drones):
        assert lib.cf_init(drone, config) == lib.CF_OK
        drone.onboard.estimate.position.x = number + 1.5
    packets = ffi.new("uint8_t[]", 4 * lib.CF_LOG_PACKET_BYTES)
    lib.cf_log_pack(blocks, 4, packets)
    sent = np.frombuffer(bytes(packets), np.uint8).reshape(4, -1)[:, 5:7].copy().view(np.int16).ravel()
    assert sent.tolist() == [1500, 1500, 2500, 2500]


@pytest.mark.parametrize(("fetched", "size"), [*BYTES.items(), (0, 0), (9, 0), (15, 0), (255, 0)])
def test_sizes_of_types(fetched, size):
    assert lib.cf_log_value_bytes(fetched) == size
