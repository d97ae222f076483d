"""Requests to the log service of a station, and its packets."""

import struct

from crazychoir_fw.crtp.packet import Packet, parse
from crazychoir_fw.onboard.variables import log_table

CREATE, APPEND, START, STOP, DELETE, RESET, START_MS = 6, 7, 3, 4, 2, 5, 8
UINT8, UINT16, UINT32, INT8, INT16, INT32, FLOAT, FP16 = range(1, 9)
FORMATS = {UINT8: "B", UINT16: "H", UINT32: "I", INT8: "b", INT16: "h", INT32: "i", FLOAT: "f", FP16: "e"}


def entries(*values, provider=0):
    """Type and id of each (name, type)."""
    ids = {name: index for index, name in enumerate(log_table(provider))}
    return b"".join(struct.pack("<BH", kind, ids[name]) for name, kind in values)


def control(station, command, number=0, rest=b""):
    """Send a command and return the error in its reply."""
    (reply,) = station.receive(Packet(5, 1, bytes((command, number)) + rest).to_bytes())
    port, channel, payload = parse(reply)
    assert (port, channel, payload[:2], len(payload)) == (5, 1, bytes((command, number)), 3)
    return payload[2]


def start(station, number, period, *values):
    """Create a block and let it run, period in ms; the simulation takes note."""
    assert control(station, CREATE, number, entries(*values)) == 0
    assert control(station, START_MS, number, struct.pack("<H", period)) == 0
    station.context.carry_out()


def data(station, kinds=""):
    """Take what was sent: (block, time stamp, values) of each packet."""
    found = []
    for datagram, is_droppable in station.context.take_out():
        port, channel, payload = parse(datagram)
        if port == 5:
            assert (channel, is_droppable) == (2, True)
            stamp = int.from_bytes(payload[1:4], "little")
            found.append((payload[0], stamp, struct.unpack("<" + kinds, payload[4:]) if kinds else payload[4:]))
    return found


def times(station):
    """Time stamps of the packets that were sent."""
    return [stamp for _, stamp, _ in data(station)]
