"""Log groups crtp and radio (docs/reference/crtp-cflib.md#20.1)."""

import pytest

from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.replay import replay

PING = b"\xfc" + bytes(9)


@pytest.fixture
def station():
    world = World([DroneConfig("cf1")], visuals=False)
    return Station(world, world["cf1"])


def log(station):
    names = ["radio.rssi", "radio.isConnected", "radio.numRxUc", "radio.numRxBc", "crtp.rxRate", "crtp.txRate"]
    return [station.context.drone.log[name] for name in names]


def test_packets_are_counted_over_half_seconds(station):
    for _ in range(10):
        station.receive(PING)
    station.context.send(0, 0, b"text")
    station.context.take_out()
    assert log(station) == [0] * 6
    station.statistics.rssi = 40
    station.context.world.step(500)
    assert log(station) == [40, 1, 10, 0, 20, 22]
    station.context.world.step(500)  # within the second of silence that a client may have
    assert log(station) == [40, 1, 10, 0, 0, 0]
    station.context.world.step(500)
    assert log(station) == [0, 0, 10, 0, 0, 0]


def test_a_drone_without_client_is_left_alone(station):
    station.context.world.step(2000)
    assert len(station.context.world.journal) == 0


def test_counters_wrap_and_rates_saturate(station):
    station.context.received = 70000
    station.context.world.step(500)
    assert log(station)[2:5] == [70000 - 65536, 0, 65535]


def test_a_replay_without_client_shows_the_same_numbers(station):
    world = station.context.world
    recorder = FlightRecorder(world)
    recorder.sample()
    for _ in range(150):
        station.receive(PING)
        station.receive(b"\x2d\x09\x00\x01")  # and a parameter
        station.context.carry_out()
        world.step(10)
        recorder.sample()
    flight = recorder.finish()
    assert flight.signals["crtp.rxRate"].max() > 0
    again = replay(flight)
    assert again.deviation is None
