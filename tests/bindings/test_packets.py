"""Packets that a whole drone receives.

docs/reference/planner-commander.md#8.4, docs/reference/crtp-cflib.md#12 and #14.
"""

import struct

import pytest

from crazychoir_fw._core import ffi, lib

RPYT, LOCALIZATION, GENERIC, HIGH_LEVEL, SUPERVISOR = 3, 6, 7, 8, 9
HOVER = b"\x0a" + struct.pack("<4f", 0.1, 0.2, 30.0, 0.5)
DEGREE_POSE = struct.pack("<7f", 1, 2, 3, 0, 0, 0, 1)


def new_drone(**config):
    options = ffi.new("cf_config_t *")
    assert lib.cf_config_default(options, lib.CF_PLATFORM_CF2) == lib.CF_OK
    for name, value in config.items():
        setattr(options, name, value)
    cf = ffi.new("cf_t *")
    status = lib.cf_init(cf, options)
    return cf if status == lib.CF_OK else status


@pytest.fixture
def cf():
    """A drone that has just booted, by the radio id 1."""
    return new_drone()


def receive(cf, port: int, channel: int, data: bytes, length: int | None = None):
    reply = ffi.new("cf_packet_reply_t *")
    ffi.memmove(reply, b"\x55" * ffi.sizeof("cf_packet_reply_t"), ffi.sizeof("cf_packet_reply_t"))
    block = ffi.new("uint8_t[]", data) if data else ffi.NULL
    status = lib.cf_receive_packet(cf, port, channel, block, len(data) if length is None else length, reply)
    return status, reply


def accepted(cf, port: int, channel: int, data: bytes):
    status, reply = receive(cf, port, channel, data)
    assert status == lib.CF_OK
    return reply


def queued(cf):
    """Return the newest measurement that waits for the estimator."""
    estimator = cf.onboard.estimator
    assert estimator.queue_count > 0
    return estimator.queue[estimator.queue_count - 1]


def peers(cf):
    """Return the positions of peers that the drone has received, by id."""
    return {peer.id: [peer.pos.x, peer.pos.y, peer.pos.z] for peer in cf.onboard.peers.peers if peer.id}


# --- setpoints


def test_generic_setpoint_reaches_the_commander_with_the_priority_of_a_client(cf) -> None:
    cf.onboard.tick = 1234
    reply = accepted(cf, GENERIC, 0, HOVER)
    assert reply.length == 0
    commander = cf.onboard.commander
    assert commander.priority == lib.COMMANDER_PRIORITY_CRTP
    assert commander.setpoint.timestamp == 1234
    assert commander.setpoint.velocity.x == pytest.approx(0.1)
    assert commander.setpoint.mode.z == lib.modeAbs


def test_unknown_generic_type_cuts_the_motors(cf) -> None:
    accepted(cf, GENERIC, 0, HOVER)
    accepted(cf, GENERIC, 0, b"\x0c\x01\x02")
    assert cf.onboard.commander.setpoint.mode.z == lib.modeDisable
    assert cf.onboard.commander.setpoint.thrust == 0.0


def test_legacy_setpoint_keeps_what_a_generic_one_left(cf) -> None:
    """docs/reference/planner-commander.md#10.3, over the wire."""
    accepted(cf, GENERIC, 0, struct.pack("<B9hI3h", 6, *range(9), 0xC0000000, 0, 0, 0))
    accepted(cf, RPYT, 0, bytes(14))
    assert cf.onboard.commander.setpoint.mode.quat == lib.modeAbs
    accepted(cf, GENERIC, 0, HOVER)
    accepted(cf, RPYT, 0, bytes(14))
    assert cf.onboard.commander.setpoint.mode.quat == lib.modeDisable


def test_legacy_setpoint_needs_the_zero_of_the_thrust_lock(cf) -> None:
    """docs/reference/planner-commander.md#17.2: before any other setpoint the priority is 0, which locks."""
    packet = struct.pack("<3fH", 1, -2, 30, 20000)
    thrusts = []
    for data in [packet, bytes(14), packet]:
        accepted(cf, RPYT, 0, data)
        thrusts.append(cf.onboard.commander.setpoint.thrust)
    assert thrusts == [0.0, 0.0, 20000.0]


def test_meta_packet_gives_way_to_the_high_level_commander(cf) -> None:
    accepted(cf, GENERIC, 0, HOVER)
    cf.onboard.estimate.position.y = 4.0
    accepted(cf, GENERIC, 1, bytes.fromhex("0064000000"))
    assert cf.onboard.commander.priority == lib.COMMANDER_PRIORITY_LOWEST
    assert cf.onboard.high_level.pos.y == 4.0


def test_sender_of_a_higher_priority_keeps_the_commander(cf) -> None:
    cf.onboard.commander.priority = lib.COMMANDER_PRIORITY_EXTRX
    assert receive(cf, GENERIC, 0, HOVER)[0] == lib.CF_ERR_STATE
    assert receive(cf, RPYT, 0, bytes(14))[0] == lib.CF_ERR_STATE
    assert cf.onboard.commander.setpoint.mode.z == lib.modeDisable


def test_sticks_are_scaled_by_the_parameters_of_the_drone(cf) -> None:
    cf.onboard.cppm.angRoll = 10.0
    accepted(cf, GENERIC, 0, bytes.fromhex("03004006aa050e06dc05"))
    assert cf.onboard.commander.setpoint.attitude.roll == pytest.approx(-2.0)


# --- localization


def test_external_position_is_queued_with_the_parameter_as_its_deviation(cf) -> None:
    cf.onboard.tick = 70000
    cf.onboard.ext_pos_std_dev = 0.5
    accepted(cf, LOCALIZATION, 0, struct.pack("<3f", 1, 2, 3))
    measurement = queued(cf)
    assert measurement.type == lib.MeasurementTypePosition
    assert list(measurement.data.position.pos) == [1, 2, 3]
    assert measurement.data.position.stdDev == 0.5
    assert cf.onboard.external_tick == 70000 - 65536


def test_external_pose_is_queued(cf) -> None:
    accepted(cf, LOCALIZATION, 1, b"\x08" + DEGREE_POSE)
    measurement = queued(cf)
    assert measurement.type == lib.MeasurementTypePose
    assert [*measurement.data.pose.pos, measurement.data.pose.quat.w] == [1, 2, 3, 1]
    # as the simulated client of a good motion capture has set them
    assert measurement.data.pose.stdDevPos == pytest.approx(0.003)
    assert measurement.data.pose.stdDevQuat == pytest.approx(0.04)


def test_packed_positions_locate_the_drone_and_its_peers() -> None:
    cf = new_drone(radio_id=7)
    data = struct.pack("<B3h", 3, 1, 2, 3) + struct.pack("<B3h", 7, 1000, 2000, 3000) + struct.pack("<B3h", 9, 4, 5, 6)
    accepted(cf, LOCALIZATION, 2, data)
    assert cf.onboard.estimator.queue_count == 1
    assert list(queued(cf).data.position.pos) == [1, 2, 3]
    assert peers(cf) == {3: pytest.approx([0.001, 0.002, 0.003]), 9: pytest.approx([0.004, 0.005, 0.006])}


def test_packed_poses_locate_the_drone_and_its_peers() -> None:
    cf = new_drone(radio_id=255)
    data = struct.pack("<B3hI", 255, 1000, 2000, 3000, 0x000001FF) + struct.pack("<B3hI", 1, 5, 0, 0, 0xC0000000)
    accepted(cf, LOCALIZATION, 1, b"\x09" + data)
    assert queued(cf).type == lib.MeasurementTypePose
    assert queued(cf).data.pose.quat.x == pytest.approx(0.70710677)
    assert peers(cf) == {1: pytest.approx([0.005, 0, 0])}


def test_full_queue_of_the_estimator_is_told(cf) -> None:
    for _ in range(lib.CF_ESTIMATOR_QUEUE_SIZE):
        accepted(cf, LOCALIZATION, 0, bytes(12))
    assert receive(cf, LOCALIZATION, 0, bytes(12))[0] == lib.CF_ERR_CAPACITY
    data = struct.pack("<B3h", 1, 0, 0, 0) + struct.pack("<B3h", 9, 0, 0, 0)
    assert receive(cf, LOCALIZATION, 2, data)[0] == lib.CF_ERR_CAPACITY
    assert list(peers(cf)) == [9]


def test_peers_that_do_not_fit_into_the_table_are_forgotten(cf) -> None:
    for peer in range(10, 22):
        accepted(cf, LOCALIZATION, 2, struct.pack("<B3h", peer, 0, 0, 0))
    assert list(peers(cf)) == list(range(10, 20))


def test_emergency_stop_of_the_localization_port_is_latched(cf) -> None:
    accepted(cf, LOCALIZATION, 1, b"\x03")
    assert cf.onboard.supervisor.emergency_stop_requested


def test_watchdog_of_the_localization_port_is_fed(cf) -> None:
    cf.onboard.tick = 2000
    accepted(cf, LOCALIZATION, 1, b"\x04")
    assert cf.onboard.supervisor.emergency_watchdog_started
    assert cf.onboard.supervisor.emergency_watchdog_tick == 2000
    assert not cf.onboard.supervisor.emergency_stop_requested


def test_lighthouse_data_is_answered_with_no(cf) -> None:
    reply = accepted(cf, LOCALIZATION, 1, bytes.fromhex("0b03000400"))
    assert bytes(reply.data[0 : reply.length]) == b"\x0b\x00"


# --- supervisor and the rest


def test_supervisor_is_asked_over_the_wire(cf) -> None:
    reply = accepted(cf, SUPERVISOR, 0, b"\x0c")
    assert bytes(reply.data[0 : reply.length]) == b"\x8c\x00\x00"


def test_high_level_commands_are_answered(cf) -> None:
    cf.onboard.high_level.is_blocked = True
    takeoff = struct.pack("<BBff?f", 7, 0, 1.0, 0.0, False, 2.0)
    reply = accepted(cf, HIGH_LEVEL, 0, takeoff)
    assert bytes(reply.data[0 : reply.length]) == takeoff[:3] + bytes([lib.CF_HIGH_LEVEL_REPLY_BUSY])


FREE_CHANNELS = {
    RPYT: [1, 2, 3],
    LOCALIZATION: [3, 4],
    GENERIC: [2, 3, 255],
    HIGH_LEVEL: [1, 2, 3],
    SUPERVISOR: [2, 3],
}


@pytest.mark.parametrize("port", range(256))
def test_other_ports_and_channels_are_unknown(cf, port: int) -> None:
    channels = FREE_CHANNELS.get(port, range(4))
    before = bytes(ffi.buffer(cf))
    for channel in channels:
        assert receive(cf, port, channel, HOVER)[0] == lib.CF_ERR_UNKNOWN
    assert bytes(ffi.buffer(cf)) == before


@pytest.mark.parametrize("port", [RPYT, LOCALIZATION, GENERIC, SUPERVISOR, 0])
@pytest.mark.parametrize("length", [-1, 31, 255, 2**31 - 1, -(2**31)])
def test_impossible_length_is_refused_before_a_byte_is_read(cf, port: int, length: int) -> None:
    before = bytes(ffi.buffer(cf))
    status, reply = receive(cf, port, 0, b"\0", length)
    assert (status, reply.length) == (lib.CF_ERR_VALUE, 0)
    assert bytes(ffi.buffer(cf)) == before


@pytest.mark.parametrize(
    ("config", "radio_id"),
    [({}, 1), ({"id": 4}, 5), ({"id": 254}, 255), ({"id": 255}, 1), ({"id": 2**32 - 1}, 1), ({"radio_id": 231}, 231)],
)
def test_radio_id_follows_the_id_unless_it_is_chosen(config, radio_id: int) -> None:
    assert new_drone(**config).onboard.radio_id == radio_id


def test_radio_id_is_a_byte() -> None:
    assert new_drone(radio_id=256) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_whole_setpoint_is_looked_at_before_it_is_taken(cf, value: float) -> None:
    setpoint = ffi.new("setpoint_t *")
    setpoint.jerk.z = value
    before = bytes(ffi.buffer(cf))
    assert lib.cf_send_setpoint(cf, setpoint) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(cf)) == before
