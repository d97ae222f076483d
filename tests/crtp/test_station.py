"""The way of a packet through a drone's station."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Packet, parse
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
