"""The server over real sockets, in lockstep: the tests step the world themselves, and wait for nothing but packets."""

import logging
import socket
import sys
import threading

import numpy as np
import pytest

from crazychoir_fw.crtp import station as station_module
from crazychoir_fw.crtp.drone_radio import LOG_BURST, NEWCOMER_BURST, STRANGER_BURST
from crazychoir_fw.crtp.link_model import Direction, PerfectLink
from crazychoir_fw.crtp.link_model.link import Arrival
from crazychoir_fw.crtp.server import Server
from crazychoir_fw.errors import RangeError, StateError
from crazychoir_fw.simulation import DroneConfig, World

SOURCE, NULL = b"\xfd\0", b"\xff"
GREETING = b"\xfdBitcraze Crazyflie" + bytes(12)
ZEROS = b"\x3c" + bytes(14)
PORT = 14  # nobody else's

needs_icmp = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells that a client's socket is closed")


class Talker:
    """A service of its own port that does what it is told, and hands set-points to the drone."""

    ports = (PORT, 3, 7)

    def __init__(self, line):
        self.line = line
        self.ended = 0

    def receive(self, port, channel, payload):
        if port != PORT:
            self.line.later(lambda: self.line.drone.uplink.request("packet", port, channel, payload))
            return ()
        word, number = payload[:1], payload[1] if len(payload) > 1 else 0
        if word == b"r":
            raise ValueError("told to")
        if word == b"R":
            self.line.later(lambda: {}["told to"])
        if word == b"s":
            for k in range(4 * number):
                self.line.send(PORT, 1, bytes((k % 256,)), droppable=True)
        if word == b"l":
            self.line.later(lambda: self.line.send(PORT, 2, self.line.world.tick.to_bytes(4, "little")))
        return ((0, payload),)

    def end_session(self):
        self.ended += 1


class Client:
    """A client of one drone."""

    def __init__(self, uri):
        host, port = uri.removeprefix("udp://").split(":")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(10.0)
        self.socket.connect((host, int(port)))

    def send(self, datagram):
        self.socket.send(datagram)

    def read(self):
        return self.socket.recv(100)

    def ask(self, datagram):
        self.send(datagram)
        return self.read()

    def tell(self, payload):
        """Have the talker do something."""
        self.send(bytes((PORT << 4 | 0x0C,)) + payload)

    def read_until(self, datagram):
        """Return everything that came before a datagram."""
        before = []
        while (got := self.read()) != datagram:
            before.append(got)
        return before

    def ping(self):
        """Return everything that came before the answer to a ping."""
        self.send(b"\xfcping")
        return self.read_until(b"\xfcping")


@pytest.fixture
def world():
    return World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], seed=4, visuals=False)


@pytest.fixture
def open_server(world):
    """Return a started server with talkers, and options."""
    servers = []

    def start(**options):
        services = (*station_module.SERVICES, Talker)
        servers.append(Server(world, port=0, services=services, **options))
        servers[-1].start()
        return servers[-1]

    yield start
    for server in servers:
        server.close()


@pytest.fixture
def connect():
    clients = []

    def open_one(server, drone="cf1"):
        clients.append(Client(server.uris[drone]))
        return clients[-1]

    yield open_one
    for client in clients:
        client.socket.close()


def events(world, kind="radio_session"):
    return [(event.drone, event.details.get("phase"), event.details.get("reason")) for event in world.events_of(kind)]


@pytest.fixture(autouse=True)
def _events_of(monkeypatch):
    monkeypatch.setattr(
        World, "events_of", lambda self, kind: [e for e in self.events if e.kind == kind], raising=False
    )


def talker(server, number=0):
    return server._radios[number].station.services[-1]


def test_every_drone_greets_at_its_own_port(open_server, connect):
    server = open_server()
    assert list(server.uris) == ["cf1", "cf2"]
    for drone in server.uris:
        assert connect(server, drone).ask(SOURCE) == GREETING
    assert server.clients == 2


def test_ports_are_consecutive(world):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        free = probe.getsockname()[1]
    port = min(free, 60000) + 7
    with world.serve(port=port) as server:
        assert server.uris == {"cf1": f"udp://127.0.0.1:{port}", "cf2": f"udp://127.0.0.1:{port + 1}"}


def test_a_taken_port_is_named_and_others_are_given_back(world):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = other.getsockname()[1]
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


def test_a_scan_does_not_disturb_a_client(open_server, connect, world):
    server = open_server()
    client, scanner = connect(server), connect(server)
    client.ask(SOURCE)
    assert scanner.ask(NULL) == NULL
    assert scanner.ask(b"\xf3") == NULL
    client.tell(b"s\1")
    assert len([client.read() for _ in range(5)]) == 5
    assert client.ping() == []
    world.step(1)
    assert [event.kind for event in world.events] == ["radio_session"]


def test_a_second_client_is_refused(open_server, connect, world):
    server = open_server()
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    for _ in range(3):
        second.tell(b"x")
    # its null packet is answered last, and nothing came before
    assert second.ask(NULL) == NULL
    assert first.ping() == []
    world.step(1)
    (refusal,) = world.events_of("radio_refused")
    assert refusal.details["client"] == "{}:{}".format(*second.socket.getsockname())
    assert server.statistics().drones["cf1"].refused == 3


def test_a_second_client_has_the_drone_when_the_first_has_gone(open_server, connect, world):
    server = open_server()
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    second.send(SOURCE)
    assert second.ask(NULL) == NULL
    world.step(1000)
    assert server.clients == 1
    world.step(40)
    assert second.read() == GREETING
    world.step(1)
    assert events(world) == [("cf1", "begin", None), ("cf1", "end", "silence"), ("cf1", "begin", None)]
    assert talker(server).ended == 1


def test_what_comes_while_a_private_socket_is_opened_is_not_taken_for_the_owners(
    open_server, connect, world, monkeypatch
):
    stranger = []

    class SlowlyConnected(socket.socket):
        def connect(self, address):
            if stranger and self.getsockname()[1] == stranger[0].socket.getpeername()[1]:
                stranger.pop().send(NULL)
            super().connect(address)

    server = open_server()
    first, second = connect(server), connect(server)
    stranger.append(second)
    monkeypatch.setattr(socket, "socket", SlowlyConnected)
    first.ask(SOURCE)
    assert second.read() == NULL
    assert not stranger
    assert first.ping() == []


def test_the_next_script_does_not_wait_for_one_that_has_closed_its_link(open_server, connect, world):
    server = open_server()
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    first.send(ZEROS)
    first.ping()
    second.send(SOURCE)
    world.step(200)
    assert second.read() == GREETING
    assert ("cf1", "end", "next client") in events(world)


@needs_icmp
@pytest.mark.parametrize("closes_first", [True, False])
def test_a_closed_socket_frees_its_drone_at_once(open_server, connect, world, closes_first):
    server = open_server()
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    if closes_first:
        first.socket.close()
        second.send(SOURCE)
    else:
        second.send(SOURCE)
        assert second.ask(NULL) == NULL
        first.socket.close()
        server._radios[0].station.line.send(PORT, 1, b"anything")
    assert second.read() == GREETING
    world.step(1)
    assert ("cf1", "end", "gone") in events(world)


@needs_icmp
def test_a_scanner_that_is_gone_takes_no_client_with_it(open_server, connect):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    for _ in range(20):
        scanner = connect(server)
        scanner.send(NULL)
        scanner.socket.close()
        assert client.ping() == []
    assert server.clients == 1


def test_the_newest_client_wins_if_wanted(open_server, connect):
    server = open_server(newest_client_wins=True)
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    assert second.ask(SOURCE) == GREETING
    first.send(b"\xfcping")
    assert first.ask(NULL) == NULL


def test_silence_ends_a_session(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    world.step(900)
    client.ping()
    world.step(900)
    assert server.clients == 1
    world.step(200)
    assert server.clients == 0
    assert talker(server).ended == 1
    server._radios[0].station.line.send(PORT, 1, b"for nobody")
    assert client.ping() == []


def test_patience_can_be_chosen(open_server, connect, world):
    server = open_server(silence=5.0)
    connect(server).ask(SOURCE)
    world.step(4900)
    assert server.clients == 1
    world.step(200)
    assert server.clients == 0


def test_a_burst_of_log_data_is_cut_and_replies_are_not(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    client.tell(b"s\xff")  # 1020 packets
    assert client.read() == b"\xecs\xff"
    assert {client.read()[0] for _ in range(int(LOG_BURST))} == {0xED}
    # in lockstep no time has passed, so that nothing more may be sent
    client.tell(b"s\1")
    assert client.read() == b"\xecs\1"
    assert client.ping() == []
    world.step(1)
    assert server.statistics().drones["cf1"].dropped == 1020 + 4 - LOG_BURST


def test_a_client_that_stalls_gets_replies_only(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    world.step(600)
    line = server._radios[0].station.line
    line.send(PORT, 1, b"log data", droppable=True)
    line.send(PORT, 1, b"a late reply")
    assert client.read() == b"\xeda late reply"
    line.send(PORT, 1, b"more", droppable=True)
    world.step(1)
    client.ping()
    line.send(PORT, 1, b"log data", droppable=True)
    assert client.read() == b"\xedlog data"


def test_a_flood_of_garbage_harms_nobody_else(open_server, connect):
    server = open_server()
    client, neighbor, rude = connect(server), connect(server, "cf2"), connect(server)
    client.ask(SOURCE)
    neighbor.ask(SOURCE)
    garbage = np.random.default_rng(1)
    for _ in range(30):
        for length in garbage.integers(0, 200, 100):
            rude.send(garbage.bytes(int(length)))
        assert neighbor.ping() == []
        # when somebody else wants the drone, it is asked whether it is still there
        assert set(client.ping()) <= {NULL}
    counts = server.statistics().drones["cf1"]
    assert counts.received > STRANGER_BURST
    assert counts.taken == 31
    looked_at = counts.refused + counts.malformed + counts.scans
    assert STRANGER_BURST <= looked_at < STRANGER_BURST + NEWCOMER_BURST
    assert counts.rate_limited == counts.received - looked_at - counts.taken
    assert server.statistics().drones["cf2"].received == 31


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has sockets that share a port as this takes")
def test_a_flood_at_one_drone_drowns_nothing_of_its_client(open_server, connect):
    server = open_server()
    client, rude = connect(server), connect(server)
    client.ask(SOURCE)
    # as if the radio were busy
    with server._radio._lock:
        for _ in range(20000):
            rude.send(b"\xec" + bytes(30))
        client.send(b"\xfcping")
    assert client.read() == b"\xfcping"
    assert server.statistics().drones["cf1"].received < 20000


def test_nobody_else_can_bind_the_port_of_a_drone_with_a_client(open_server, connect):
    server = open_server()
    connect(server).ask(SOURCE)
    with server._radio._lock:
        pass  # until the turn that answered is over
    port = int(server.uris["cf1"].rsplit(":", 1)[1])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with pytest.raises(OSError, match="in use"):
            other.bind(("127.0.0.1", port))


def test_a_service_that_raises_is_told_of_once(open_server, connect, world, caplog):
    server = open_server()
    client, neighbor = connect(server), connect(server, "cf2")
    client.ask(SOURCE)
    with caplog.at_level(logging.ERROR, "crazychoir_fw.crtp"):
        for _ in range(3):
            client.tell(b"r")
            client.tell(b"R")
        assert len(client.ping()) == 3
        world.step(1)
    assert [record.message.split(":")[0] for record in caplog.records] == ["cf1", "cf1"]
    assert "ValueError: told to" in caplog.records[0].message
    assert "KeyError" in caplog.records[1].message
    assert server.statistics().drones["cf1"].errors == 6
    assert neighbor.ask(SOURCE) == GREETING


def test_what_was_sent_before_a_step_acts_in_its_first_tick(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    for _ in range(20):
        before = world.tick
        client.tell(b"l")
        world.step(3)
        client.read_until(b"\xee" + (before + 1).to_bytes(4, "little"))


def test_without_a_step_changes_can_be_carried_out(open_server, connect, world):
    server = open_server()
    client = connect(server)
    client.tell(b"l")
    assert client.ping() == [b"\xecl"]
    server.carry_out()
    assert client.read() == b"\xee" + bytes(4)
    assert world.tick == 0


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


class Late:
    """A link that takes 10 ms each way, and loses every third log packet."""

    def __init__(self):
        self.under_way = []
        self.logs = 0

    def send(self, now, drone, direction, datagram, droppable=False):
        self.logs += droppable
        if not (droppable and self.logs % 3 == 0):
            self.under_way.append((now + 0.010, Arrival(drone, direction, datagram)))

    def arrivals(self, now):
        arrived = [arrival for time, arrival in self.under_way if time <= now + 1e-9]
        self.under_way = [(time, arrival) for time, arrival in self.under_way if time > now + 1e-9]
        return arrived

    def next_arrival(self):
        return min((time for time, _ in self.under_way), default=float("inf"))

    def statistics(self):
        return {"logs": self.logs}


def test_packets_go_through_the_link_by_simulated_time(open_server, connect, world):
    server = open_server(link=Late())
    client = connect(server)
    for _ in range(5):
        client.send(SOURCE)
        before = server.statistics().drones["cf1"].replied
        world.step(9)
        assert server.statistics().drones["cf1"].replied == before
        world.step(1)
        assert server.statistics().drones["cf1"].replied == before + 1
        world.step(10)
        assert client.read() == GREETING
    client.tell(b"s\3")
    world.step(20)
    client.send(b"\xfcping")
    world.step(20)
    # one reply, and two thirds of the log data
    assert len(client.read_until(b"\xfcping")) == 1 + 8
    assert server.statistics().link == {"logs": 12}


def test_what_is_under_way_does_not_reach_the_next_client(open_server, connect, world):
    server = open_server(link=Late(), newest_client_wins=True)
    first, second = connect(server), connect(server)
    first.send(SOURCE)
    world.step(25)
    assert first.read() == GREETING
    for _ in range(5):
        first.tell(b"old")
    world.step(12)  # these have arrived, and their answers are under way
    first.tell(b"older")  # and this is
    second.send(SOURCE)
    world.step(40)
    assert second.read() == GREETING
    second.send(b"\xfcping")
    world.step(40)
    assert second.read_until(b"\xfcping") == []
    assert server.statistics().drones["cf1"].dropped >= 6


def test_what_a_drone_does_not_hear_ends_its_session(open_server, connect, world):
    class Dead(PerfectLink):
        is_dead = False

        def send(self, now, drone, direction, datagram, droppable=False):
            if not (self.is_dead and direction is Direction.UP):
                super().send(now, drone, direction, datagram, droppable)

    link = Dead()
    server = open_server(link=link)
    client, second = connect(server), connect(server)
    client.ask(SOURCE)
    link.is_dead = True
    for _ in range(15):
        client.send(b"\xfcping")
        world.step(100)
    assert server.clients == 0
    second.send(SOURCE)
    link.is_dead = False
    # it is still the client of the drone, and has a session again with the first packet that comes through; that
    # somebody else wants the drone, it sees by a null packet
    assert client.ping() == [NULL]
    assert server.clients == 1
    world.step(1)
    assert [phase for _, phase, _ in events(world)] == ["begin", "end", "begin"]


def stops(world):
    """Return when the server told a drone that set-points have ended, by the journal (s)."""
    return [request.tick / 1000 for request in world.journal if request.verb == "cf_notify_setpoint_stop"]


@pytest.mark.parametrize("relaxes", [True, False])
def test_the_next_script_can_take_off_by_the_high_level_commander(open_server, connect, world, relaxes):
    world.wait_until_ready()
    server = open_server(relax_after_session=relaxes)
    client = connect(server)
    client.ask(SOURCE)
    client.send(ZEROS)
    world.step(1100)
    assert len(stops(world)) == relaxes
    world.drones[0].high_level_commander.takeoff(0.5, 1.0)
    world.step(1500)
    assert (world.positions()[0, 2] > 0.3) == relaxes


def test_a_flying_drone_is_relaxed_when_it_has_landed(open_server, connect, world):
    world.wait_until_ready()
    server = open_server()
    client = connect(server)
    client.ask(SOURCE)
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.3, 1.0)
    world.step(900)
    client.ping()
    world.step(2100)
    assert drone.is_flying
    assert server.clients == 0
    assert stops(world) == []
    drone.high_level_commander.land(0.0, 1.0)
    world.step(900)
    assert stops(world) == []
    world.step(400)
    # its supervisor waits 2 s until it is sure, and the next script may be faster
    assert drone.is_flying
    assert len(stops(world)) == 1


def test_sessions_without_end_do_not_fill_the_memory(open_server, connect, world):
    server = open_server()
    client = connect(server)
    for _ in range(300):
        assert client.ask(SOURCE) == GREETING
    world.step(1)
    assert server.statistics().drones["cf1"].sessions == 300
    assert len(world.events) <= 20


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
