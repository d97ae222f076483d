"""Served drones under too much of everything: bursts, clients that stall, floods, services that raise."""

import logging
import sys

import numpy as np
import pytest
from server_clients import GREETING, NULL, PORT, SOURCE

from crazychoir_fw.crtp.drone_radio import LOG_BURST, NEWCOMER_BURST, REPLY_BURST, REPLY_RATE, STRANGER_BURST


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
    line = server._radios[0].station.context
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
        # when another client requests the drone, the server pings the current one
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
    assert set(client.read_until(b"\xfcping")) <= {NULL}
    assert server.statistics().drones["cf1"].received < 20000


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


def test_answers_beyond_a_burst_wait_in_their_order(open_server, connect, world):
    """The socket of a client holds 256 packets, and loses what comes while it is full."""
    server = open_server()
    server._radio.link_rate = 1.0  # as by the clock on the wall, but for a clock that stands still
    client = connect(server)
    echoes = [b"\xfc" + number.to_bytes(2, "little") for number in range(300)]
    for echo in echoes:
        client.send(echo)
    client.send(NULL)  # answered past all others
    assert client.read_until(NULL) == echoes[: int(REPLY_BURST)]
    world.step(round(1000.0 * (300 - REPLY_BURST) / REPLY_RATE) + 2)
    assert [client.read() for _ in range(300 - int(REPLY_BURST))] == echoes[int(REPLY_BURST) :]
    assert server.statistics().drones["cf1"].lost == 0
