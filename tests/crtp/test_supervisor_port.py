"""Port 9: the supervisor (docs/reference/crtp-cflib.md#7)."""

import pytest
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Packet, parse
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World

INFO, COMMAND = range(2)


def bench(platform="cf2"):
    world = World([DroneConfig("cf1", platform=platform)], visuals=False)
    return Station(world, world["cf1"])


@pytest.fixture
def station():
    """The station of a drone that must be armed, and can be."""
    station = bench("cf21bl")
    while not station.context.drone.can_arm:
        station.context.world.run(0.1)
    return station


def ask(station, payload):
    return [parse(datagram).payload for datagram in station.receive(Packet(9, INFO, payload).to_bytes())]


def answers(station):
    """Return what the drone sends, but for text on its console."""
    return [parse(datagram) for datagram, is_droppable in station.context.take_out() if not is_droppable]


def command(station, payload):
    """Return what the drone answers when it has obeyed."""
    assert station.receive(Packet(9, COMMAND, payload).to_bytes()) == []
    station.context.carry_out()
    return answers(station)


def test_questions_are_answered_at_once_and_leave_no_trace(station):
    before = station.context.drone.memory.copy()
    requests = len(station.context.world.journal)
    info = int(station.context.drone.log["supervisor.info"])
    for query in range(1, 12):
        assert ask(station, bytes((query,))) == [bytes((query | 0x80, info >> (query - 1) & 1))]
    assert ask(station, b"\x0c") == [b"\x8c" + info.to_bytes(2, "little")]
    assert (station.context.drone.memory == before).all()
    assert len(station.context.world.journal) == requests


@pytest.mark.parametrize("payload", [b"", b"\x00", b"\x0d", b"\x81", b"\x01\x02"])
def test_other_questions_are_not_answered(station, payload):
    assert ask(station, payload) == []


def test_arming_and_disarming(station):
    assert command(station, b"\1\1") == [(9, COMMAND, b"\x81\1\1")]
    station.context.world.run(0.1)
    assert station.context.drone.can_fly
    assert ask(station, b"\2") == [b"\x82\1"]
    assert station.context.drone.log["sys.armed"] == 1
    assert command(station, b"\1\0") == [(9, COMMAND, b"\x81\1\0")]
    assert station.context.drone.log["sys.armed"] == 0


def test_arming_that_is_refused_says_so():
    assert command(bench("cf21bl"), b"\1\1") == [(9, COMMAND, b"\x81\0\0")]


def test_recovery_of_what_has_not_crashed(station):
    assert command(station, b"\2") == [(9, COMMAND, b"\x82\1\1")]


@pytest.mark.parametrize(("port", "channel", "payload"), [(9, 1, b"\3"), (6, 1, b"\3")])
def test_emergency_stop_locks(port, channel, payload):
    station = bench()
    station.context.world.wait_until_ready()
    assert station.receive(Packet(port, channel, payload).to_bytes()) == []
    station.context.carry_out()
    station.context.world.run(0.1)
    assert station.context.drone.is_locked
    assert answers(station) == []


@pytest.mark.parametrize(("port", "channel", "payload"), [(9, 1, b"\4"), (6, 1, b"\4")])
def test_emergency_watchdog_locks_after_a_second_of_silence(port, channel, payload):
    station = bench()
    world, drone = station.context.world, station.context.drone
    world.wait_until_ready()
    for _ in range(3):
        station.receive(Packet(port, channel, payload).to_bytes())
        station.context.carry_out()
        world.run(0.9)
        assert not drone.is_locked
    world.run(0.2)
    assert drone.is_locked


@pytest.mark.parametrize("port", [9, 6])
def test_a_flood_does_not_keep_an_emergency_stop_away(port):
    station = bench()
    station.context.world.wait_until_ready()
    for _ in range(2000):
        station.receive(Packet(port, 1, b"\1\1" if port == 9 else b"\2\0").to_bytes())
    station.receive(Packet(port, 1, b"\3").to_bytes())
    station.context.carry_out()
    station.context.world.run(0.1)
    assert station.context.drone.is_locked


def test_cflib_arms_and_reads_the_state(station):
    """Its questions wait for an answer in a thread of their own; here it comes by hand."""
    client = Client(station)
    supervisor = client.cf.supervisor
    supervisor.send_arming_request(True)
    supervisor.send_crash_recovery_request()
    supervisor.send_emergency_stop_watchdog()
    assert client.link.sent == [(9, 1, b"\1\1"), (9, 1, b"\2"), (9, 1, b"\4")]
    station.context.carry_out()
    client.read()
    station.context.world.run(0.1)
    info = int(station.context.drone.log["supervisor.info"])
    words = supervisor.decode_bitfield(info)
    assert "Is armed" in words
    assert "Can fly" in words


SHARED = bench()


@given(st.integers(0, 3), st.binary(max_size=MAX_PAYLOAD))
def test_any_payload_is_survived(channel, payload):
    answers = [parse(datagram) for datagram in SHARED.receive(Packet(9, channel, payload).to_bytes())]
    SHARED.context.carry_out()
    answers += [parse(datagram) for datagram, _ in SHARED.context.take_out()]
    assert len(answers) <= 1
    for port, back, answer in answers:
        assert (port, back) == (9, channel)
        assert answer[0] == payload[0] | 0x80
