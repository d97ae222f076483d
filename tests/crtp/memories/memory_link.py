"""A link without sockets: the real client's memory classes on one end, a station on the other."""

from collections import deque

from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.mem import Memory
from cflib.crtp.crtpstack import CRTPPacket
from cflib.utils.callbacks import Caller

from crazychoir_fw.crtp.packet import Packet, Port, parse
from crazychoir_fw.crtp.station import Station


class _Platform:
    def get_protocol_version(self) -> int:
        return 12


class MemoryLink:
    """What cflib's classes expect of a Crazyflie.

    Packets wait until `pump`, because the client holds a lock while it sends, which the answer wants.
    """

    def __init__(self, world, drone) -> None:
        self.world, self.drone = world, drone
        self.station = Station(world, drone)
        self.platform, self.disconnected = _Platform(), Caller()
        self.sent = 0
        self._waiting = deque()
        self._listeners = []
        self.mem = Memory(self)
        self.high_level_commander = HighLevelCommander(self)

    def add_port_callback(self, port, callback) -> None:
        self._listeners.append((port, callback))

    def send_packet(self, packet, expected_reply=(), resend=False, timeout=0.2) -> None:
        self.sent += 1
        self._waiting.append(Packet(packet.port, packet.channel, bytes(packet.data)))

    def pump(self) -> None:
        """Let the station answer until nobody has anything to say."""
        while self._waiting:
            packet = self._waiting.popleft()
            if packet.port == Port.COMMANDER_HIGH_LEVEL:
                self.drone.receive_packet(*packet)
                continue
            for answer in map(parse, self.station.receive(packet.to_bytes())):
                self._hand_over(answer)

    def _hand_over(self, answer) -> None:
        reply = CRTPPacket()
        reply.set_header(answer.port, answer.channel)
        reply.data = answer.payload
        for port, callback in self._listeners:
            if port == answer.port:
                callback(reply)

    def connect(self) -> "MemoryLink":
        """Have the client ask for all memories, as it does when it connects."""
        done = []
        self.mem.refresh(lambda: done.append(True))
        self.pump()
        assert done
        return self

    def memory(self, type):
        """Return the one memory of a type."""
        (memory,) = self.mem.get_mems(type)
        return memory

    def call(self, function, *arguments, **named):
        """Call an asynchronous method whose last argument is a callback, and return what that is called with."""
        answers = []
        function(*arguments, lambda *values: answers.append(values), **named)
        self.pump()
        (answer,) = answers
        return answer

    def carry_out(self) -> None:
        """Let the simulation do what waits."""
        self.station.line.carry_out()
