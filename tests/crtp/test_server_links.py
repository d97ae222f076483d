"""Served drones behind a link, over real sockets."""

from server_clients import GREETING, NULL, SOURCE, events

from crazychoir_fw.crtp.link_model import Direction, PerfectLink
from crazychoir_fw.crtp.link_model.link import Arrival


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
    # "older" comes through another socket, and if it is read last, the drone is seen to be requested by two
    assert second.read_until(GREETING) in ([], [NULL])
    second.send(b"\xfcping")
    world.step(40)
    assert second.read_until(b"\xfcping") == []
    counts = server.statistics().drones["cf1"]
    assert counts.dropped + counts.refused >= 6


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
    # it is still the client of the drone, and has a session again with the first packet that comes through; a null
    # packet shows it that another client requests the drone
    assert client.ping() == [NULL]
    assert server.clients == 1
    world.step(1)
    assert [phase for _, phase, _ in events(world)] == ["begin", "end", "begin"]
