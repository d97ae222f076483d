"""The way of a packet through a drone's station."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Packet, parse
from crazychoir_fw.crtp.services.log_sampler import sampler_of
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture(scope="module")
def station():
    world = World([DroneConfig("cf1")], visuals=False)
    return Station(world, world["cf1"])


@given(st.integers(0, 15), st.integers(0, 3), st.binary(max_size=MAX_PAYLOAD))
def test_what_is_packed_is_parsed(port, channel, payload):
    assert parse(Packet(port, channel, payload).to_bytes()) == (port, channel, payload)


def test_reserved_bits_are_ignored():
    assert parse(bytes.fromhex("f1 00")) == parse(bytes.fromhex("fd 00")) == (15, 1, b"\0")


@pytest.mark.parametrize("datagram", [b"", bytes(32), bytes(1000)])
def test_what_is_no_packet_is_ignored(station, datagram):
    assert parse(datagram) is None
    assert station.receive(datagram) == []


def test_it_greets(station):
    (reply,) = station.receive(bytes.fromhex("fd 00"))
    assert reply == b"\xfd" + b"Bitcraze Crazyflie" + bytes(12)


def test_it_echoes(station):
    assert station.receive(b"\xfc12345678") == [b"\xfc12345678"]


@given(st.binary(max_size=40))
def test_any_datagram_is_survived(station, datagram):
    for reply in station.receive(datagram):
        assert parse(reply) is not None


def what_waits(world):
    """All that is called at some time, or when something happens."""
    listeners = [list(drone.uplink.listeners) for drone in world.drones]
    return world.agenda.periods, list(world.agenda.when_sought), listeners


def start_everything(station):
    """Connect, and let a log block run."""
    station.receive(b"\xfd\x00")
    station.receive(b"\x5d\x06\x01\x07\x00\x00")
    assert station.receive(b"\x5d\x08\x01\x0a\x00") == [b"\x5d\x08\x01\x00"]


def test_a_station_that_is_closed_leaves_nothing_behind():
    world = World([DroneConfig("cf1", positioning="lighthouse")], visuals=False)
    sampler_of(world)  # stays as long as the world
    before = what_waits(world)
    station = Station(world, world["cf1"])
    start_everything(station)
    station.context.carry_out()
    world.step(30)
    assert what_waits(world) != before
    assert [datagram for datagram, _ in station.context.take_out() if datagram[0] == 0x5E]
    station.close()
    world.step(10)  # a log block that has ended is taken off when it was due
    assert what_waits(world) == before
    world.step(100)
    assert station.context.take_out() == []


def test_a_world_that_is_served_twice_is_served_by_the_second_server_alone():
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], visuals=False)
    sampler_of(world)
    before = what_waits(world)
    for _ in range(2):
        with world.serve(port=0) as server:
            for radio in server._radios:
                start_everything(radio.station)
            world.step(20)
        world.step(10)
        assert what_waits(world) == before
