"""The server at the pace of the wall: paused, stopped, as fast as possible. No test asks how long it takes."""

import socket
import threading
import time
from contextlib import contextmanager

import pytest
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.udpdriver import UdpDriver

from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError
from crazychoir_fw.crtp import drone_radio
from crazychoir_fw.crtp import station as station_module
from crazychoir_fw.crtp.radio_thread import Radio
from crazychoir_fw.crtp.server import Server
from crazychoir_fw.simulation import DroneConfig, World


class Stepper:
    """A service that answers when a change has been carried out, with the tick of the world."""

    ports = (14,)

    def __init__(self, context):
        self.context = context

    def receive(self, port, channel, payload):
        self.context.later(lambda: self.context.send(14, 1, self.context.world.tick.to_bytes(4, "little")))
        return ()

    def end_session(self):
        pass


@pytest.fixture
def world():
    return World([DroneConfig("cf1")], visuals=False)


@pytest.fixture
def server(world):
    with Server(world, port=0, services=(*station_module.SERVICES, Stepper)) as server:
        yield server


@contextmanager
def asking(server):
    """Yield a function that returns the tick at which a change was carried out."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(10.0)
        client.connect(("127.0.0.1", int(server.uris["cf1"].rsplit(":", 1)[1])))

        def ask_tick():
            client.send(b"\xec")
            return int.from_bytes(client.recv(100)[1:], "little")

        yield ask_tick


@pytest.fixture
def ask(server):
    with asking(server) as ask_tick:
        yield ask_tick


@contextmanager
def running(server, *arguments, **options):
    """Run in another thread meanwhile."""
    thread = threading.Thread(target=server.run, args=arguments, kwargs=options)
    thread.start()
    try:
        yield thread
    finally:
        server.stop()
        thread.join(10.0)
        assert not thread.is_alive()


def until(is_true):
    """Wait for something that must come."""
    deadline = time.monotonic() + 10.0
    while not is_true():
        assert time.monotonic() < deadline
        time.sleep(0.002)


def test_time_goes_on_and_ends_when_it_was_to(server, world):
    server.run(0.0511)
    assert world.tick == 51
    server.run(0.0)
    assert world.tick == 51
    figures = server.statistics()
    assert figures.sim_seconds == pytest.approx(world.time)
    assert figures.wall_seconds > 0.0


def test_while_paused_changes_happen_and_time_does_not(server, world, ask):
    server.pause()
    with running(server):
        assert [ask() for _ in range(5)] == [0] * 5
        assert server.is_paused
        server.resume()
        until(lambda: world.tick > 20)
        server.pause()
        ask()
        assert ask() == ask() == world.tick


def test_a_pause_is_not_caught_up(server, world, ask):
    with running(server):
        server.pause()
        ask()
        time.sleep(0.3)
        server.resume()
        until(lambda: world.tick > 100)
    assert server.statistics().resyncs == 0


def test_changes_are_carried_out_while_it_runs(server, ask):
    with running(server):
        ticks = [ask() for _ in range(50)]
    assert ticks == sorted(ticks)


@pytest.mark.parametrize("speed", [0.0, None])
def test_as_fast_as_possible(world, speed):
    with world.serve(port=0, speed=speed) as server:
        assert server.speed is None
        server.run(2.0)
    assert world.tick == 2000


def test_a_slow_pace_waits_no_longer_than_a_change(world):
    services = (*station_module.SERVICES, Stepper)
    with Server(world, port=0, speed=0.001, services=services) as server, running(server), asking(server) as ask:
        for _ in range(20):
            ask()
    assert world.tick < 100


def test_stop_is_for_ever(server, world):
    with running(server):
        pass
    tick = world.tick
    server.run(1.0)
    assert world.tick == tick


def test_an_observer_sees_it_run(server, world):
    ticks = []
    server.run(0.2, lambda seen: ticks.append(seen.world.tick), every=0.01)
    assert len(ticks) > 3
    assert ticks == sorted(ticks)


def test_what_an_observer_raises_ends_the_run(server):
    def close_window(_):
        raise StateError("the window was closed")

    with pytest.raises(CrazychoirError, match="closed"):
        server.run(None, close_window)
    server.run(0.01)


def test_lockstep_comes_back_after_a_run(server, world, ask):
    server.run(0.01)
    tick = world.tick
    client = threading.Thread(target=ask)
    client.start()
    while client.is_alive():
        world.step(1)
    assert world.tick > tick


def test_a_jump_in_time_is_no_lag(server, world, ask):
    world.step(500)
    snapshot = world.snapshot()

    before = []

    def jump(_):
        if world.tick > 550:
            before.append(server.statistics().resyncs)  # a machine that has other work may have lagged until here
            world.restore(snapshot)
            server.stop()

    server.run(1.0, jump, every=0.0)
    assert world.tick == 500
    assert server.statistics().resyncs == before[0]


def test_runs_that_cannot_be(server, world):
    with pytest.raises(RangeError, match=r"run\(-1"):
        server.run(-1)
    with running(server):
        until(lambda: world.tick > 0)
        with pytest.raises(StateError, match="runs already"):
            server.run(1.0)
    with pytest.raises(StateError, match="not been started"):
        Server(world, port=0).run(1.0)


def test_a_thousand_echoes_in_a_row_arrive_in_order(world):
    """A socket of cflib holds 256 packets, and loses what comes while it is full."""
    link = UdpDriver()
    with Server(world, port=0) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            link.connect(server.uris["cf1"], None, None)
            link.send_packet(CRTPPacket(0xFC, b"first"))  # from now on the server hears this client apart from others
            assert bytes(link.receive_packet(10.0).data) == b"first"
            asked = [number.to_bytes(2, "little") for number in range(1000)]
            counts = server.statistics
            for number, data in enumerate(asked):
                link.send_packet(CRTPPacket(0xFC, data))
                if number % 100 == 99:
                    # the socket of a server that gets no processor time is full after some hundreds
                    until(lambda: counts().drones["cf1"].received > number)  # noqa: B023 - called at once
            for data in asked:
                echo = link.receive_packet(10.0)
                assert echo is not None
                assert bytes(echo.data) == data
            assert server.statistics().drones["cf1"].lost == 0
        finally:
            link.close()
            server.stop()
            thread.join()


def test_bursts_right_after_connecting_arrive_in_order(world, monkeypatch):
    """A client gets a socket of its own while it sends: what came to the other one before must not be overtaken."""
    taken = []
    monkeypatch.setattr(drone_radio, "CLIENT_BURST", 1e6)
    monkeypatch.setattr(Radio, "_send_up", lambda self, radio, datagram, now: taken.append(datagram))
    with Server(world, port=0, newest_client_wins=True) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            port = int(server.uris["cf1"].rsplit(":", 1)[1])
            for _ in range(30):
                taken.clear()
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
                    client.connect(("127.0.0.1", port))
                    sent = [b"\xfd\0", *(b"\xfc" + number.to_bytes(2, "little") for number in range(1000))]
                    for number, datagram in enumerate(sent):
                        until(lambda number=number: number - len(taken) < 300)  # a buffer of the system holds so many
                        client.send(datagram)
                    until(lambda: len(taken) == 1001)
                assert taken == sent
        finally:
            server.stop()
            thread.join()
