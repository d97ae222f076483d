"""What is printed on board reaches the client line by line (docs/reference/crtp-cflib.md#11)."""

import pytest
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.crtp.packet import parse
from crazychoir_fw.crtp.services.console import packets_of
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World

CONNECT, SCAN = b"\xfd\0", b"\xff"


@pytest.fixture
def world():
    return World([DroneConfig("cf1")], visuals=False)


@pytest.fixture
def station(world):
    station = Station(world, world["cf1"])
    station.receive(CONNECT)
    station.context.carry_out()
    return station


def print_on(world, text):
    lib.cf_console_print(ffi.addressof(world["cf1"].struct.onboard, "console"), text)


def told(station, ticks=20):
    station.context.world.step(ticks)
    found = []
    for datagram, is_droppable in station.context.take_out():
        packet = parse(datagram)
        assert (packet.port, packet.channel, is_droppable) == (0, 0, True)
        found.append(packet.payload)
    return found


def test_a_simulation_that_is_quicker_than_the_radio_thread(world):
    """It may begin to listen, and look many times, before the radio thread goes on."""
    station = Station(world, world["cf1"])
    later = station.context.later

    def at_once(change):
        later(change)
        station.context.carry_out()
        world.step(40)
        return True

    station.context.later = at_once
    station.receive(CONNECT)
    print_on(world, b"hello\n")
    assert told(station) == [b"hello\n"]


def test_a_line_is_told_when_it_is_complete(world, station):
    print_on(world, b"SYS: half a")
    assert told(station) == []
    print_on(world, b" line\nnext")
    assert told(station) == [b"SYS: half a line\n"]
    print_on(world, b"\n\n")
    assert told(station) == [b"next\n", b"\n"]


def test_a_long_line_fills_packets(world, station):
    print_on(world, b"x" * 70)
    assert told(station) == [b"x" * 30, b"x" * 30]
    print_on(world, b"yz\n")
    assert told(station) == [b"x" * 10 + b"yz\n"]


def test_what_is_no_ascii_is_replaced(world, station):
    print_on(world, "Größe\n".encode())
    assert told(station) == [b"Gr????e\n"]


def test_nothing_is_told_while_nothing_is_printed(world, station):
    assert told(station, 1000) == []


def test_what_was_printed_before_the_client_came_is_lost(world):
    station = Station(world, world["cf1"])
    appointments = len(world.agenda.periods)
    print_on(world, b"early\n")
    station.receive(SCAN)
    station.context.carry_out()
    assert told(station, 100) == []
    assert len(world.agenda.periods) == appointments, "who scans is no client"
    station.receive(CONNECT)
    station.context.carry_out()
    print_on(world, b"late\n")
    assert told(station) == [b"late\n"]


def test_nobody_is_told_after_the_session(world, station):
    appointments = len(world.agenda.periods)
    station.end_session()
    print_on(world, b"unheard\n")
    assert told(station, 100) == []
    assert len(world.agenda.periods) == appointments - 1
    station.receive(CONNECT)
    station.context.carry_out()
    print_on(world, b"heard\n")
    assert told(station) == [b"heard\n"]


def test_a_session_that_follows_at_once(world, station):
    station.end_session()
    station.receive(CONNECT)
    station.context.carry_out()
    print_on(world, b"once\n")
    assert told(station) == [b"once\n"]


def test_a_reboot_is_told_from_its_beginning(world, station):
    print_on(world, b"before\n")
    assert told(station) == [b"before\n"]
    world["cf1"].reboot()
    printed = world["cf1"].console
    print_on(world, b"after\n")
    assert b"".join(told(station)).decode() == printed + "after\n"


def test_what_the_ring_has_lost_is_lost(world, station):
    for number in range(100):
        print_on(world, b"line %05d\n" % number)
    text = b"".join(told(station))
    assert text.endswith(b"line 00099\n")
    assert len(text) == lib.CF_CONSOLE_BYTES


def test_going_back_in_time_repeats_nothing(world, station):
    snapshot = world.snapshot()
    world.step(100)
    print_on(world, b"future\n")
    assert told(station) == [b"future\n"]
    world.restore(snapshot)
    assert told(station, 100) == []
    print_on(world, b"present\n")
    assert told(station) == [b"present\n"]


@given(st.binary(max_size=200))
def test_packets_are_the_text(text):
    packets = list(packets_of(text))
    assert b"".join(packets) == text
    assert all(1 <= len(packet) <= 30 for packet in packets)
    assert all(b"\n" not in packet[:-1] for packet in packets)


def test_the_real_client_hears_the_text(world):
    client = Client(Station(world, world["cf1"]))
    heard = []
    client.cf.console.receivedChar.add_callback(heard.append)
    client.station.receive(CONNECT)
    client.pump()
    world["cf1"].emergency_stop()
    print_on(world, b"a line that does not fit one packet, but two\n")
    world.step(20)
    client.pump()
    assert "".join(heard).endswith("a line that does not fit one packet, but two\n")
    assert station_swallows(client.station)


def station_swallows(station):
    return station.receive(b"\x0chello") == []
