"""A radio link without a radio: the real client's classes on one end, a simulated drone on the other."""

from cflib.crazyflie.commander import Commander
from cflib.crazyflie.extpos import Extpos
from cflib.crazyflie.localization import Localization
from cflib.crazyflie.supervisor import Supervisor
from cflib.crtp.crtpstack import CRTPPacket
from cflib.utils.callbacks import Caller


class _Platform:
    def __init__(self, protocol: int) -> None:
        self._protocol = protocol

    def get_protocol_version(self) -> int:
        return self._protocol


class FakeCrazyflie:
    """What cflib's clients expect of a Crazyflie; packets go straight to the drone, answers straight back."""

    def __init__(self, drone, protocol: int = 12) -> None:
        self.drone = drone
        self.sent = []
        self._listeners = []
        self.platform = _Platform(protocol)
        self.link = object()
        self.connected, self.fully_connected, self.disconnected = Caller(), Caller(), Caller()
        self.supervisor = Supervisor(self)
        self.commander = Commander(self)
        self.loc = Localization(self)
        self.extpos = Extpos(self)

    def add_port_callback(self, port, callback) -> None:
        self._listeners.append((port, callback))

    def send_packet(self, packet, expected_reply=(), resend=False, timeout=0.2) -> None:
        data = bytes(packet.data)
        self.sent.append((packet.port, packet.channel, data))
        answer = self.drone.receive_packet(packet.port, packet.channel, data)
        if answer is None:
            return
        reply = CRTPPacket()
        reply.set_header(packet.port, packet.channel)
        reply.data = answer
        for port, callback in self._listeners:
            if port == packet.port:
                callback(reply)
