"""Clients that wait for their turn to connect, over real sockets."""

import threading
import time

import pytest
from server_clients import GREETING, SOURCE

from crazychoir_fw.crtp import turns
from crazychoir_fw.crtp.packet import HEADERS
from crazychoir_fw.crtp.toc import log_toc

INFO = b"\x5c\3"
INFORMED = HEADERS[5][0] + log_toc().info


@pytest.fixture
def run(world):
    """Return what lets a server run in a thread of its own, and a way to end that."""
    running = []

    def start(server):
        running.append((server, threading.Thread(target=server.run)))
        running[-1][1].start()
        while server._radio.link_rate == 0.0:
            time.sleep(0.001)

    yield start
    for server, thread in running:
        server.stop()
        thread.join()


@pytest.fixture
def nobodys_turn(monkeypatch):
    """Let nobody begin unless it is said how many."""
    monkeypatch.setattr(turns, "SILENCE_S", 1e9)

    def of(server):
        server._radio._turns._at_once = 0

    return of


def test_who_waits_has_not_gone(open_server, connect, run, nobodys_turn):
    server = open_server(silence=0.05)
    run(server)
    nobodys_turn(server)
    client = connect(server)
    assert client.ask(SOURCE) == GREETING
    client.send(INFO)
    assert client.ping() == []
    time.sleep(0.3)
    assert server.statistics().drones["cf1"].sessions == server.clients == 1
    server._radio._turns._at_once = 1
    assert client.read() == INFORMED


def test_nobody_waits_who_steps_the_world(open_server, connect, run, nobodys_turn, world):
    server = open_server()
    run(server)
    nobodys_turn(server)
    client, other = connect(server), connect(server, "cf2")
    client.ask(SOURCE)
    client.send(INFO)
    assert client.ping() == []
    server._radio.link_rate = 0.0  # as when `run` ends
    assert client.read() == INFORMED
    assert other.ask(SOURCE) == GREETING
    assert other.ask(INFO) == INFORMED


@pytest.mark.parametrize("reason", ["as asked", "far away"])
def test_some_never_wait(open_server, connect, run, nobodys_turn, monkeypatch, reason):
    if reason == "far away":
        monkeypatch.setattr(
            "crazychoir_fw.crtp.radio_thread.takes_turns", lambda client: turns.takes_turns(("10.0.0.1", client[1]))
        )
    server = open_server(reads_ahead=reason != "as asked")
    run(server)
    nobodys_turn(server)
    client = connect(server)
    client.ask(SOURCE)
    assert client.ask(INFO) == INFORMED
