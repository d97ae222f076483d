"""Drones behind a link that is made up: cflib's own classes talk to them, byte for byte, without sockets or waiting."""

import errno
import queue
import struct
import threading

import cflib.crtp
from cflib.crazyflie.log import LogTocElement
from cflib.crazyflie.param import ParamTocElement
from cflib.crtp.crtpdriver import CRTPDriver
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.exceptions import WrongUriType

U8, F32, READ_ONLY = 0x08, 0x06, 0x40

PARAMETERS = {
    "flightmode.stabModeRoll": (U8, 1),
    "flightmode.stabModePitch": (U8, 1),
    "flightmode.stabModeYaw": (U8, 0),
    "stabilizer.estimator": (U8, 1),
    "stabilizer.controller": (U8, 1),
    "locSrv.extQuatStdDev": (F32, 4.5e-3),
    "kalman.resetEstimation": (U8, 0),
    "deck.bcLighthouse4": (U8 | READ_ONLY, 1),
}
LOGS = dict.fromkeys(("stabilizer.roll", "stabilizer.pitch", "stabilizer.yaw"), "float")
LOGS |= dict.fromkeys(("kalman.stateX", "kalman.stateY", "kalman.stateZ", "pm.vbat"), "float")
LOGS |= dict.fromkeys((f"stateEstimateZ.{name}" for name in ("x", "y", "z", "vx", "vy", "vz")), "int16_t")
LOGS |= {"stateEstimateZ.quat": "uint32_t"}
LOGS |= dict.fromkeys((f"stateEstimateZ.rate{name}" for name in ("Roll", "Pitch", "Yaw")), "int16_t")

READY = 0b1110  # armed, auto-armed, can fly
FLYING = 0b1_0001_0000  # what the planner on board says
UNARMED = 0b0001
LOCKED = 0b1000000

FLIGHT_PORTS = (3, 6, 7, 8, 9)
STOP, START_TRAJECTORY, TAKEOFF, GO_TO = 3, 5, 7, 12  # of the planner on board


class FakeDrone:
    """One drone, and what becomes of its link."""

    def __init__(self, uri):
        self.uri = uri
        self.protocol = 12
        self.bits = READY
        self.parameters = dict(PARAMETERS)
        self.logs = dict(LOGS)
        self.links = []
        """Every link that was opened."""
        self.packets = []
        """Everything that came: port, channel, payload."""
        self.writes = []
        """Parameters that were written: name, value."""
        self.blocks = {}
        self.is_reachable = True
        self.is_silent = False
        self.mute_ports = set()
        self.refuses_blocks = 0
        self.commands_to_drop = 0
        """How many take-offs and goals are not followed."""

    @property
    def flown(self):
        """What concerns flying, without questions."""
        return [
            (port, channel, data.hex(" "))
            for port, channel, data in self.packets
            if port in FLIGHT_PORTS and (port, channel) != (9, 0)
        ]

    @property
    def ports(self):
        """Where packets came to: cflib's pings come at any time."""
        return [port for port, *_ in self.packets]

    def take(self):
        """What concerns flying since the last call."""
        flown = self.flown
        self.packets.clear()
        return flown

    @property
    def link(self):
        return self.links[-1]

    def break_link(self, reason="Too many packets lost"):
        # as the thread of a driver does
        self.link.error_callback(reason)

    def log(self, stamp_ms, **values):
        """Send every running block, with these values (dots as two underscores)."""
        for number, (names, _) in sorted(self.blocks.items()):
            data = struct.pack("<BBH", number, stamp_ms & 0xFF, stamp_ms >> 8 & 0xFFFF)
            for name in names:
                pack = LogTocElement.types[LogTocElement.get_id_from_cstring(self.logs[name])][1]
                data += struct.pack(pack, values.get(name.replace(".", "__"), 0))
            self.link.deliver(5, 2, data)

    def answer(self, port, channel, data):
        """The replies to a packet: channel, payload."""
        self.packets.append((port, channel, data))
        if self.is_silent or port in self.mute_ports:
            return []
        if port == 8:
            self._plan(data[0])
        reply = {15: self._link, 13: self._platform, 5: self._log, 4: self._memory, 2: self._param, 9: self._supervisor}
        return reply[port](channel, data) if port in reply else []

    def _link(self, channel, data):
        return [(0, data)] if channel == 0 else [(1, b"Bitcraze Crazyflie".ljust(30, b"\0"))]

    def _platform(self, channel, data):
        return [(1, struct.pack("<Bi", 0, self.protocol))] if channel == 1 and data[0] == 0 else []

    def _memory(self, channel, data):
        return [(0, b"\x01\x00")] if channel == 0 and data[0] == 1 else []

    def _plan(self, command):
        if command == STOP:
            self.bits &= ~FLYING
        elif command in (START_TRAJECTORY, TAKEOFF, GO_TO) and self.commands_to_drop:
            self.commands_to_drop -= 1
        elif command in (START_TRAJECTORY, TAKEOFF, GO_TO):
            self.bits |= FLYING

    def _supervisor(self, channel, data):
        if channel == 0 and data[0] == 0x0C:
            return [(0, struct.pack("<BH", 0x8C, self.bits))]
        if channel == 1 and data[0] == 1:
            self.bits = READY & ~0b100 if data[1] else UNARMED
            return [(1, bytes((0x81, 1, data[1])))]
        return []

    def _toc(self, names, types, data, reply):
        if data[0] == 3:
            return [(0, b"\x03" + struct.pack("<HI", len(names), abs(hash(tuple(names))) & 0xFFFFFFFF) + reply)]
        number = struct.unpack("<H", data[1:3])[0]
        group, item = names[number].split(".")
        return [(0, data[:3] + bytes((types[number],)) + f"{group}\0{item}\0".encode())]

    def _log(self, channel, data):
        if channel == 0:
            types = [LogTocElement.get_id_from_cstring(kind) for kind in self.logs.values()]
            return self._toc(list(self.logs), types, data, b"\x10\x80")
        command, number = data[0], data[1] if len(data) > 1 else 0
        status = 0
        if command == 5:
            self.blocks.clear()
        elif command in (6, 7):
            status = self.refuses_blocks or (errno.EEXIST if command == 6 and number in self.blocks else 0)
            ids = [struct.unpack("<H", data[i + 1 : i + 3])[0] for i in range(2, len(data) - 2, 3)]
            if not status:
                names = self.blocks.get(number, ([], 0))[0] + [list(self.logs)[i] for i in ids]
                self.blocks[number] = (names, 0)
        elif command == 3 and number not in self.blocks:
            status = errno.ENOENT
        elif command == 3:
            self.blocks[number] = (self.blocks[number][0], data[2] * 10)
        return [(1, bytes((command, number, status)))]

    def _param(self, channel, data):
        names = list(self.parameters)
        if channel == 0:
            return self._toc(names, [kind for kind, _ in self.parameters.values()], data, b"")
        name = names[struct.unpack("<H", data[:2])[0]]
        kind, value = self.parameters[name]
        pack = ParamTocElement.types[kind & 0x0F][1]
        if channel == 1:
            return [(1, data[:2] + b"\0" + struct.pack(pack, value))]
        self.parameters[name] = (kind, struct.unpack(pack, data[2:])[0])
        self.writes.append((name, self.parameters[name][1]))
        return [(2, data)]


class FakeAir:
    """All drones that can be reached by fake:// URIs."""

    def __init__(self):
        self.drones = {}

    def __getitem__(self, uri):
        return self.drones.setdefault(uri, FakeDrone(uri))

    def uris(self, count):
        uris = [f"fake://{i}" for i in range(count)]
        for uri in uris:
            self[uri]
        return uris

    def driver(self):
        """A class of drivers for cflib, that leads here."""
        air = self

        class FakeDriver(CRTPDriver):
            def __init__(self):
                self.needs_resending = False
                self.drone = None
                self.is_closed = False
                self.inbox = queue.Queue()

            def connect(self, uri, radio_link_statistics_callback, link_error_callback):
                if not uri.startswith("fake://"):
                    raise WrongUriType("not made up")
                drone = air[uri]
                if not drone.is_reachable:
                    raise OSError("no such drone in the air")
                self.drone, self.error_callback = drone, link_error_callback
                drone.links.append(self)

            def send_packet(self, packet):
                for channel, data in self.drone.answer(packet.port, packet.channel, bytes(packet.data)):
                    self.deliver(packet.port, channel, data)

            def deliver(self, port, channel, data):
                packet = CRTPPacket()
                packet.set_header(port, channel)
                packet.data = data
                self.inbox.put(packet)

            def receive_packet(self, wait=0):
                if self.is_closed:
                    threading.Event().wait(0.01)
                    return None
                try:
                    return self.inbox.get(True, wait)
                except queue.Empty:
                    return None

            def close(self):
                self.is_closed = True
                self.inbox.put(None)

            def get_name(self):
                return "fake"

            def scan_interface(self, address=None):
                return []

        return FakeDriver


class FakeClock:
    """A clock that advances only when the test sets it."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def install(air):
    """Let cflib find the drones; returns what takes it back."""
    driver = air.driver()
    cflib.crtp.CLASSES.insert(0, driver)
    return lambda: cflib.crtp.CLASSES.remove(driver)
