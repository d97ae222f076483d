"""Two clients that read tables of contents from one server at the same time."""

import threading

import pytest
from server_clients import SOURCE, events

from crazychoir_fw.crtp import read_scheduler
from crazychoir_fw.crtp.link_model import PerfectLink


@pytest.fixture
def running(open_server):
    """Return a server that runs by the clock on the wall, with options."""
    threads = []

    def start(**options):
        server = open_server(speed=None, **options)
        threads.append((server, threading.Thread(target=server.run)))
        threads[-1][1].start()
        return server

    yield start
    for server, thread in threads:
        server.stop()
        thread.join()


def item(number):
    return b"\x5c\2" + bytes((number, 0))


def test_the_second_waits_until_the_first_has_done(running, connect, world):
    server = running(silence=0.5)
    first, second = connect(server, "cf1"), connect(server, "cf2")
    for client in (first, second):
        client.ask(SOURCE)
    assert first.ask(item(0))[2] == 0
    second.send(item(0))
    assert second.ping() == []  # other questions are answered at once
    for number in (1, 2):
        assert first.ask(item(number))[2] == number
    # the first asks for a value, and so has all tables; then nothing more
    assert first.ask(b"\x2d\0\0")[:3] == b"\x2d\0\0"
    assert second.read()[2] == 0
    assert second.ask(item(1))[2] == 1
    assert not [event for event in events(world) if event[2] == "silence"]


class PassesAll(PerfectLink):
    """A link that the server does not know to be perfect."""


@pytest.mark.parametrize("options", [{"reads_ahead": False}, {"link": PassesAll()}], ids=["as asked", "link"])
def test_a_server_that_behaves_as_vehicles_do_knows_no_turns(running, connect, options):
    server = running(**options)
    first, second = connect(server, "cf1"), connect(server, "cf2")
    for number in range(40):
        for client in (first, second):
            assert client.ask(item(number))[2] == number


def test_in_lockstep_nobody_waits(open_server, connect):
    server = open_server()
    first, second = connect(server, "cf1"), connect(server, "cf2")
    for number in range(3):
        for client in (first, second):
            assert client.ask(item(number))[2] == number


def test_who_waits_when_the_server_stops_running_is_answered(open_server, connect, monkeypatch):
    for name in ("IDLE_S", "LONGEST_S", "PATIENCE_S"):
        monkeypatch.setattr(read_scheduler, name, 60.0)
    server = open_server(speed=None)
    thread = threading.Thread(target=server.run)
    thread.start()
    first, second = connect(server, "cf1"), connect(server, "cf2")
    try:
        for client in (first, second):
            client.ask(SOURCE)
        first.ask(item(0))
        second.send(item(0))
        assert second.ping() == []
    finally:
        server.stop()
        thread.join()
    assert second.read()[2] == 0
