"""The real cflib, without sockets: a client whose link is a drone's station."""

from queue import Empty, Queue

from cflib.crazyflie import Crazyflie
from cflib.crtp.crtpstack import CRTPPacket

from crazychoir_fw.crtp.packet import parse

PATIENCE = 30
"""Seconds after which a test hangs."""


class StationLink:
    """Hands packets of a client to a station, and keeps all of them."""

    needs_resending = False

    def __init__(self, station=None):
        self.station = station
        self.sent = []
        self.arrived = Queue()

    def send_packet(self, packet):
        self.sent.append((packet.port, packet.channel, bytes(packet.data)))
        if self.station is not None:
            for datagram in self.station.receive(bytes((packet.header, *packet.data))):
                self.arrived.put(datagram)

    def close(self):
        pass


class Client:
    """A connected client of protocol version 12; the test decides when it reads packets that have arrived."""

    def __init__(self, station=None):
        self.station = station
        self.link = StationLink(station)
        self.cf = Crazyflie()
        self.cf.link = self.link
        self.cf.platform._protocolVersion = 12

    def fetch_parameters(self):
        """Fetch the table of parameters and all values, as cflib does when it connects."""
        self.cf.param._connection_requested("station")
        is_fetched = []
        self.cf.param.refresh_toc(lambda: is_fetched.append(True), NoCache())
        self.read(until=lambda: is_fetched)
        self.cf.param.request_update_of_all_params()
        self.read(until=lambda: self.cf.param.is_updated)

    def read(self, until=None):
        """Take what arrives until something has happened, or everything that has arrived."""
        for datagram, _ in self.station.context.take_out():
            self.link.arrived.put(datagram)
        while until is None or not until():
            try:
                # threads of cflib ask for more
                datagram = self.link.arrived.get(timeout=PATIENCE if until else None, block=until is not None)
            except Empty:
                assert until is None, "nothing comes any more"
                return
            self._dispatch(parse(datagram))

    def pump(self):
        """Let simulation and client answer each other until the client has nothing more to say."""
        count = -1
        while count != len(self.link.sent):
            count = len(self.link.sent)
            self.station.context.carry_out()
            self.read()

    def _dispatch(self, packet):
        taken = CRTPPacket()
        taken.set_header(packet.port, packet.channel)
        taken.data = packet.payload
        for container in list(self.cf.incoming.cb):
            if (
                container.port == packet.port & container.port_mask
                and container.channel == packet.channel & container.channel_mask
            ):
                container.callback(taken)

    def close(self):
        """End the threads of the client."""
        self.cf.param._disconnected("station")
        self.cf.link = None


class NoCache:
    """A cache of tables that holds none."""

    def fetch(self, crc):
        return None

    def insert(self, crc, toc):
        pass
