"""Ports 3, 7 and 8: setpoints and the high-level commander (docs/reference/crtp-cflib.md#12, #13 and #21)."""

import struct

import pytest
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Packet, Port, parse
from crazychoir_fw.crtp.service_context import MAX_WAITING
from crazychoir_fw.crtp.services.commands import CommanderService, HighLevelService
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World


def bench():
    world = World([DroneConfig("cf1")], visuals=False)
    return Station(world, world["cf1"])


def service_of(station, kind):
    return next(service for service in station.services if isinstance(service, kind))


def send(station, port, channel, payload):
    """Send a packet as a client does, let the drone take it, and return what it sends then."""
    assert station.receive(Packet(port, channel, payload).to_bytes()) == []
    station.context.carry_out()
    return [parse(datagram) for datagram, _ in station.context.take_out()]


@pytest.fixture
def station():
    return bench()


@pytest.fixture
def flying(station):
    """The station of a drone whose supervisor lets it fly."""
    station.context.world.wait_until_ready()
    return station


# ------------------------------------------------------------------- bytes of cflib, docs/reference/crtp-cflib.md#21

SETPOINTS = [
    ("send_setpoint", (1, 2, 3, 40000), 3, 0, "0000803F 000000C0 00004040 409C"),
    ("send_notify_setpoint_stop", (100,), 7, 1, "00 64000000"),
    ("send_stop_setpoint", (), 7, 0, "00"),
    ("send_velocity_world_setpoint", (1, 2, 3, 4), 7, 0, "08 0000803F 00000040 00004040 00008040"),
    ("send_zdistance_setpoint", (1, 2, 3, 4), 7, 0, "09 0000803F 00000040 00004040 00008040"),
    ("send_hover_setpoint", (1, 2, 3, 4), 7, 0, "0A 0000803F 00000040 00004040 00008040"),
    (
        "send_full_state_setpoint",
        ((1, 2, 3), (4, 5, 6), (7, 8, 9), (0, 0, 0, 1), 1, 2, 3),
        7,
        0,
        "06 E803 D007 B80B A00F 8813 7017 581B 401F 2823 000000C0 E803 D007 B80B",
    ),
    ("send_position_setpoint", (1, 2, 3, 90), 7, 0, "07 0000803F 00000040 00004040 0000B442"),
    ("send_setpoint_manual", (1, 2, 3, 50, True), 7, 0, "0B 0000803F 000000C0 00004040 B888 01"),
]

COMMANDS = [
    ("define_trajectory", (1, 0, 10), "06 01 01 00 00000000 0A"),
    ("start_trajectory", (1, 1.0, True), "0D 00 01 00 00 01 0000803F"),
    ("takeoff", (1.0, 2.0), "07 00 0000803F 00000000 00 00000040"),
    ("land", (0, 2, 0, None), "08 00 00000000 00000000 01 00000040"),
    ("go_to", (1, 2, 3, 0.5, 2, True), "0C 00 01 00 0000803F 00000040 00004040 0000003F 00000040"),
    ("spiral", (1, 0.5, 0.6, 0.1, 2), "0B 00 00 00 0000803F 0000003F 9A99193F CDCCCC3D 00000040"),
    ("stop", (), "03 00"),
    ("set_group_mask", (3,), "00 03"),
]


@pytest.mark.parametrize(("call", "arguments", "port", "channel", "payload"), SETPOINTS)
def test_setpoints_of_cflib_reach_the_commander(flying, call, arguments, port, channel, payload):
    client = Client(flying)
    getattr(client.cf.commander, call)(*arguments)
    assert client.link.sent == [(port, channel, bytes.fromhex(payload))]
    flying.context.carry_out()
    service = service_of(flying, CommanderService)
    assert (service.packets.refused, service.packets.lost) == (0, 0)
    requests = [request.arguments for request in flying.context.world.journal if request.verb == "packet"]
    assert requests == [(port, channel, bytes.fromhex(payload))]
    commander = flying.context.drone.struct.onboard.commander
    assert commander.priority == (1 if channel == 1 else 2)  # that of a client, until it lets go


@pytest.mark.parametrize(("call", "arguments", "payload"), COMMANDS)
def test_commands_of_cflib_are_answered_with_0(flying, call, arguments, payload):
    client = Client(flying)
    getattr(client.cf.high_level_commander, call)(*arguments)
    request = bytes.fromhex(payload)
    assert client.link.sent == [(8, 0, request)]
    flying.context.carry_out()
    (answer,) = [parse(datagram) for datagram, _ in flying.context.take_out()]
    assert answer == (8, 0, (request + b"\0")[:3].ljust(3, b"\0") + b"\0")
    assert service_of(flying, HighLevelService).packets.refused == 0


def test_what_cflib_flies_is_flown(flying):
    client, world, drone = Client(flying), flying.context.world, flying.context.drone
    client.cf.high_level_commander.takeoff(0.5, 1.0)
    flying.context.carry_out()
    world.run(1.5)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.05)
    for _ in range(50):
        client.cf.commander.send_position_setpoint(0.3, 0.0, 0.7, 0.0)
        flying.context.carry_out()
        world.run(0.04)
    assert drone.true_position == pytest.approx([0.3, 0.0, 0.7], abs=0.1)


def test_zero_setpoint_at_the_end_of_a_session_unlocks_and_owns(flying):
    """What `close_link` sends (docs/reference/crtp-cflib.md#12 and #21)."""
    assert send(flying, 3, 0, bytes(14)) == []
    onboard = flying.context.drone.struct.onboard
    assert (onboard.commander.priority, onboard.rpyt.thrust_is_locked) == (2, False)


@pytest.mark.parametrize(
    ("payload", "error"),
    [
        ("63 00 00", 8),  # no such command
        ("07 00 00", 8),  # too short
        ("00 03", 0),  # the group mask may be set at any time
    ],
)
def test_refusals_of_the_high_level_commander_are_its_answer(station, payload, error):
    request = bytes.fromhex(payload)
    assert send(station, 8, 0, request) == [(8, 0, request.ljust(3, b"\0")[:3] + bytes((error,)))]


def test_a_locked_drone_is_busy(flying):
    flying.context.drone.emergency_stop()
    flying.context.world.run(0.1)
    takeoff = bytes.fromhex("07 00 0000803F 00000000 00 00000040")
    assert send(flying, 8, 0, takeoff) == [(8, 0, takeoff[:3] + b"\x10")]


def test_high_level_commands_come_on_any_channel(station):
    assert send(station, 8, 2, b"\0\3") == [(8, 0, b"\0\3\0\0")]
    assert station.context.drone.param["hlCommander.groupmask"] == 3


@pytest.mark.parametrize(
    ("port", "channel", "payload"),
    [
        (3, 0, b""),
        (3, 1, bytes(14)),
        (3, 0, bytes(13)),
        (3, 0, struct.pack("<3fH", float("nan"), 0, 0, 0)),
        (7, 0, b""),
        (7, 0, b"\x07" + bytes(15)),
        (7, 0, b"\x07" + b"\xff" * 16),
        (7, 1, b"\x00\x00"),
        (7, 2, b"\x00"),
    ],
)
def test_bad_setpoints_are_swallowed_and_counted(station, port, channel, payload):
    before = bytes(ffi.buffer(ffi.addressof(station.context.drone.struct.onboard, "commander")))
    assert send(station, port, channel, payload) == []
    assert service_of(station, CommanderService).packets.refused == 1
    assert bytes(ffi.buffer(ffi.addressof(station.context.drone.struct.onboard, "commander"))) == before


def test_setpoints_do_not_pile_up_while_the_simulation_is_paused(flying):
    """The newest one stays, and commands on other ports have room."""
    positions = [float(i) for i in range(2 * MAX_WAITING)]
    for x in positions:
        flying.receive(Packet(7, 0, b"\x07" + struct.pack("<4f", x, 0, 1, 0)).to_bytes())
    service = service_of(flying, CommanderService)
    assert service.packets.lost == len(positions) - 100
    flying.receive(Packet(8, 0, b"\0\5").to_bytes())
    flying.context.carry_out()
    assert flying.context.drone.struct.onboard.commander.setpoint.position.x == positions[-1]
    assert flying.context.drone.param["hlCommander.groupmask"] == 5
    assert len(flying.context.world.journal) >= 101


def test_high_level_commands_beyond_are_lost(station):
    for mask in range(200):
        station.receive(Packet(8, 0, bytes((0, mask))).to_bytes())
    station.context.carry_out()
    assert station.context.drone.param["hlCommander.groupmask"] == 99
    assert service_of(station, HighLevelService).packets.lost == 100
    station.receive(Packet(8, 0, b"\0\7").to_bytes())
    station.context.carry_out()
    assert station.context.drone.param["hlCommander.groupmask"] == 7


@pytest.mark.parametrize("port", [Port.SUPERVISOR, Port.LOCALIZATION])
def test_no_flood_of_other_requests_keeps_a_stop_from_the_drone(station, port):
    station.context.world.wait_until_ready()
    arm = Packet(Port.PLATFORM, 0, b"\1\1").to_bytes()
    for _ in range(2000):
        station.receive(arm)
    station.receive(Packet(port, 1, b"\3").to_bytes())
    send(station, 8, 0, b"\0\7")
    assert station.context.drone.param["hlCommander.groupmask"] == 7
    station.context.world.run(0.1)
    assert station.context.drone.is_locked


SHARED = bench()


@given(
    st.sampled_from([Port.COMMANDER, Port.COMMANDER_GENERIC, Port.COMMANDER_HIGH_LEVEL]),
    st.integers(0, 3),
    st.binary(max_size=MAX_PAYLOAD),
)
def test_any_payload_is_survived(port, channel, payload):
    answers = send(SHARED, port, channel, payload)
    if port == Port.COMMANDER_HIGH_LEVEL and payload:
        ((back, _, answer),) = answers
        assert back == port
        assert answer[:3] == payload[:3].ljust(3, b"\0")
        assert len(answer) == lib.CF_HIGH_LEVEL_REPLY_BYTES
    else:
        assert answers == []
