"""Whom a served drone listens to, over real sockets."""

import socket

import pytest
from server_clients import GREETING, NULL, PORT, SOURCE, ZEROS, events, needs_icmp, talker


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
    assert set(first.ping()) <= {NULL}  # whether it still lives
    world.step(1)
    (refusal,) = [event for event in world.events if event.kind == "radio_refused"]
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
        server._radios[0].station.context.send(PORT, 1, b"anything")
    assert second.read() == GREETING
    world.step(1)
    assert ("cf1", "end", "gone") in events(world)


@needs_icmp
def test_a_client_that_has_gone_takes_nobodys_place_in_the_line(open_server, connect, world):
    server = open_server()
    first, second, dead = connect(server), connect(server), connect(server)
    first.ask(SOURCE)
    for waiting in (second, dead):
        waiting.send(SOURCE)
        assert waiting.ask(NULL) == NULL
    dead.socket.close()
    first.socket.close()
    # at the latest when nothing has been heard of the first one for a second
    world.step(1100)
    assert second.read() == GREETING


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


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
@pytest.mark.parametrize("moment", ["bind", "connect", "close", "unregister"])
def test_nothing_is_lost_while_a_drone_changes_hands(open_server, connect, monkeypatch, host, moment):
    """Whatever the server does to a socket meanwhile: what the two clients send just before is answered."""
    to_send = []

    def send():
        while to_send:
            client, datagrams = to_send.pop()
            for datagram in datagrams:
                client.send(datagram)

    def sending_first(method):
        def send_and_go_on(*arguments):
            send()
            return method(*arguments)

        return send_and_go_on

    server = open_server(newest_client_wins=True, host=host)
    clients = connect(server), connect(server)
    if moment == "unregister":
        selector = server._radio._selector
        monkeypatch.setattr(selector, moment, sending_first(selector.unregister))
    else:
        hooked = type("Hooked", (socket.socket,), {moment: sending_first(getattr(socket.socket, moment))})
        monkeypatch.setattr(socket, "socket", hooked)
    loser, winner = clients
    assert loser.ask(SOURCE) == GREETING
    pings = [b"\xfc" + bytes((number,)) for number in range(5)]
    for _ in range(10):
        with server._radio._lock:
            to_send += [(winner, pings), (loser, [NULL] * 3)]
        assert winner.ask(SOURCE) == GREETING
        with server._radio._lock:
            send()  # where this moment never comes
        assert [winner.read() for _ in pings] == pings
        assert [loser.read() for _ in range(3)] == [NULL] * 3
        loser, winner = winner, loser


def test_a_drone_changes_hands_again_and_again(open_server, connect):
    server = open_server(newest_client_wins=True)
    clients = connect(server), connect(server)
    for k in range(150):
        # the socket of one is still being made when the other one asks
        assert clients[k % 2].ask(SOURCE) == GREETING
    assert server.statistics().drones["cf1"].sessions == 150


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
    server._radios[0].station.context.send(PORT, 1, b"for nobody")
    assert client.ping() == []


def test_patience_can_be_chosen(open_server, connect, world):
    server = open_server(silence=5.0)
    connect(server).ask(SOURCE)
    world.step(4900)
    assert server.clients == 1
    world.step(200)
    assert server.clients == 0


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


@needs_icmp
def test_a_client_that_does_not_ask_for_the_source_has_the_drone_of_one_that_died(open_server, connect):
    server = open_server()
    first, second = connect(server), connect(server)
    first.ask(SOURCE)
    first.socket.close()
    assert second.ask(b"\xfchere") == b"\xfchere"  # no time has gone by
    assert server.clients == 1
