"""One drone at its radio: what comes in goes to the service of its port."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from crazychoir_fw.crtp.line import Line
from crazychoir_fw.crtp.packet import Packet, parse
from crazychoir_fw.crtp.services import Service
from crazychoir_fw.crtp.services.link import LinkService
from crazychoir_fw.crtp.services.memory import MemoryService

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World

SERVICES: Sequence[Callable[[Line], Service]] = (
    LinkService,
    MemoryService,
)
"""All that a drone offers."""


class Station:
    """The services of one drone behind one way in and one way out. It knows nothing of sockets."""

    def __init__(self, world: World, drone: Drone) -> None:
        self.line = Line(world, drone)
        self.services = [make(self.line) for make in SERVICES]
        self._by_port = {port: service for service in self.services for port in service.ports}

    def receive(self, datagram: bytes) -> list[bytes]:
        """Take what came by radio, whatever it is, and return the datagrams that answer it at once."""
        packet = parse(datagram)
        service = self._by_port.get(packet.port) if packet is not None else None
        if packet is None or service is None:
            return []
        replies = service.receive(packet.port, packet.channel, packet.payload)
        return [Packet(packet.port, channel, payload).to_bytes() for channel, payload in replies]

    def end_session(self) -> None:
        """Forget what belongs to a client that has gone."""
        for service in self.services:
            service.end_session()
