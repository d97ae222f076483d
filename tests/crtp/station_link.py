"""The real client's classes on one end, a station on the other, and no socket between them."""

from collections import deque

from cflib.crtp.crtpstack import CRTPPacket

from crazychoir_fw.crtp.packet import Packet, parse


class StationCrazyflie:
    """What cflib's services expect of a Crazyflie. `pump` carries packets both ways until none is left."""

    def __init__(self, station) -> None:
        self.station = station
        self.link = object()
        self.sent = []
        self._listeners = []
        self._up = deque()

    def add_port_callback(self, port, callback) -> None:
        self._listeners.append((port, callback))

    def remove_port_callback(self, port, callback) -> None:
        self._listeners.remove((port, callback))

    def send_packet(self, packet, expected_reply=(), resend=False, timeout=0.2) -> None:
        # only handed over: a client that fetches tables would call itself hundreds of times
        datagram = Packet(packet.port, packet.channel, bytes(packet.data)).to_bytes()
        self.sent.append(datagram)
        self._up.append(datagram)

    def pump(self) -> None:
        """Carry what waits in either direction, and what is said to it."""
        while True:
            down = self.station.receive(self._up.popleft()) if self._up else []
            self.station.line.carry_out()
            down += [datagram for datagram, _ in self.station.line.take_out()]
            for datagram in down:
                self._hand_over(parse(datagram))
            if not (down or self._up):
                return

    def _hand_over(self, packet: Packet) -> None:
        heard = CRTPPacket()
        heard.set_header(packet.port, packet.channel)
        heard.data = packet.payload
        for port, callback in list(self._listeners):
            if port == packet.port:
                callback(heard)
