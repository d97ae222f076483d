"""Clients of served drones, and a service that the test controls."""

import socket
import sys

import pytest

SOURCE, NULL = b"\xfd\0", b"\xff"
GREETING = b"\xfdBitcraze Crazyflie" + bytes(12)
ZEROS = b"\x3c" + bytes(14)
PORT = 14  # no other service uses it

needs_icmp = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells that a client's socket is closed")


class Talker:
    """A service with its own port that the test controls; it also hands set-points to the drone."""

    ports = (PORT, 3, 7)

    def __init__(self, context):
        self.context = context
        self.ended = 0

    def receive(self, port, channel, payload):
        if port != PORT:
            self.context.later(lambda: self.context.drone.uplink.request("packet", port, channel, payload))
            return ()
        word, number = payload[:1], payload[1] if len(payload) > 1 else 0
        if word == b"r":
            raise ValueError("told to")
        if word == b"R":
            self.context.later(lambda: {}["told to"])
        if word == b"s":
            for k in range(4 * number):
                self.context.send(PORT, 1, bytes((k % 256,)), droppable=True)
        if word == b"l":
            self.context.later(lambda: self.context.send(PORT, 2, self.context.world.tick.to_bytes(4, "little")))
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


def events(world, kind="radio_session"):
    return [
        (event.drone, event.details.get("phase"), event.details.get("reason"))
        for event in world.events
        if event.kind == kind
    ]


def talker(server, number=0):
    return server._radios[number].station.services[-1]
