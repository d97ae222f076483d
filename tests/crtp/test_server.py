"""The server over real sockets, in lockstep: the tests step the world themselves, and wait for nothing but packets."""

import socket
import threading

import numpy as np
import pytest
from ports import free_ports
from server_clients import GREETING, SOURCE, Client, Talker, events, needs_icmp

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.crtp import station as station_module
from crazychoir_fw.crtp.link_model import PerfectLink
from crazychoir_fw.crtp.server import Server
from crazychoir_fw.simulation import DroneConfig, World


def test_every_drone_greets_at_its_own_port(open_server, connect):
    server = open_server()
    assert list(server.uris) == ["cf1", "cf2"]
    for drone in server.uris:
        assert connect(server, drone).ask(SOURCE) == GREETING
    assert server.clients == 2


def test_ports_are_consecutive(world):
    port = free_ports(2)
    with world.serve(port=port) as server:
        assert server.uris == {"cf1": f"udp://127.0.0.1:{port}", "cf2": f"udp://127.0.0.1:{port + 1}"}


def test_a_taken_port_is_named_and_others_are_given_back(world):
    taken = free_ports(2) + 1
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", taken))
        with pytest.raises(StateError, match=f"port {taken} of 127.0.0.1 is taken"):
            world.serve(port=taken - 1).start()
    with world.serve(port=taken - 1) as server:
        assert len(server.uris) == 2


@pytest.mark.parametrize("port", [65535, -1, 70000, "19850", True])
def test_ports_that_there_are_not(world, port):
    with pytest.raises(RangeError, match="for 2 drones, allowed: 0 .* to 65534"):
        world.serve(port=port).start()


def test_a_host_of_somebody_else(world):
    with pytest.raises(RangeError, match=r"host '192\.0\.2\.1' cannot be served from"):
        world.serve("192.0.2.1").start()


def test_what_was_sent_before_a_step_acts_in_its_first_tick(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    for _ in range(20):
        before = world.tick
        client.tell(b"l")
        world.step(3)
        assert client.ping() == [b"\xecl", b"\xee" + (before + 1).to_bytes(4, "little")]


def test_without_a_step_changes_can_be_carried_out(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.tell(b"l")
    assert client.ping() == [b"\xecl"]
    server.carry_out()
    assert client.read() == b"\xee" + bytes(4)
    assert world.tick == 0


class PassesAll(PerfectLink):
    """A link that the server does not know to be perfect."""


@pytest.mark.parametrize(
    ("options", "came"),
    [({}, 128), ({"reads_ahead": False}, 1), ({"link": PassesAll()}, 1)],
    ids=["ahead", "off", "link"],
)
def test_tables_are_sent_ahead_unless_there_is_a_link(open_server, connect, options, came):
    client = connect(open_server(**options))
    for number in range(3):
        client.ask(b"\x5c\2" + bytes((number, 0)))
    client.send(b"\x5c\2\3\0")
    replies = client.ping()
    assert [reply[2] for reply in replies] == list(range(3, 3 + came))


def fly_by_packets():
    """Fly with set-points that arrive between steps; returns every byte of the drones at the end."""
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], seed=4, visuals=False)
    world.wait_until_ready()
    server = Server(world, port=0, services=(*station_module.SERVICES, Talker))
    with server:
        clients = [Client(uri) for uri in server.uris.values()]
        for k in range(40):
            for number, client in enumerate(clients):
                client.send(b"\x7c\x0a" + np.array([0.1, 0.0, 10.0 * number, 0.5], "<f4").tobytes())
            world.step(20 + k % 3)
        for client in clients:
            client.socket.close()
    return [drone.memory.tobytes() for drone in world.drones], world.positions()


def test_the_same_packets_at_the_same_ticks_give_the_same_bits():
    (first, positions), (second, _) = fly_by_packets(), fly_by_packets()
    assert first == second
    assert positions[:, 2].min() > 0.2


def test_a_jump_in_time_ends_nothing(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    snapshot = world.snapshot()
    world.step(500)
    client.ping()
    world.restore(snapshot)
    world.step(500)
    assert client.ping() == []
    world.step(600)
    assert server.clients == 1
    world.step(500)
    assert server.clients == 0


@needs_icmp
def test_it_closes_cleanly(world):
    server = world.serve(port=0)
    with server:
        client = Client(server.uris["cf1"])
        client.ask(SOURCE)
    with pytest.raises(ConnectionRefusedError):
        client.ask(SOURCE)
    client.socket.close()
    assert events(world) == [("cf1", "begin", None), ("cf1", "end", "closed")]
    assert all(thread.name != "crazychoir radio" for thread in threading.enumerate())
    world.step(10)
    server.close()
    # and again
    with server:
        assert Client(server.uris["cf1"]).ask(SOURCE) == GREETING


def test_a_replayed_world_is_not_served():
    world = World([DroneConfig("cf1")], visuals=False, is_replay=True)
    with pytest.raises(StateError, match="from a journal cannot be served"):
        world.serve()


@pytest.mark.parametrize("silence", [0.0, -1.0, float("nan"), 1e6])
def test_patience_has_a_range(world, silence):
    with pytest.raises(RangeError, match="silence is .* allowed: 0.01 to 3600 s"):
        world.serve(silence=silence)


def test_it_is_started_once(open_server):
    server = open_server()
    with pytest.raises(StateError, match="started already"):
        server.start()
