"""One drone at its radio: what comes in goes to the service of its port."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from crazychoir_fw.crtp.packet import HEADERS, MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services import Service
from crazychoir_fw.crtp.services.commands import (
    NULL_CHANNEL,
    CommanderService,
    HighLevelService,
    LinkService,
    SupervisorService,
)
from crazychoir_fw.crtp.services.console import ConsoleService
from crazychoir_fw.crtp.services.localization import LocalizationService
from crazychoir_fw.crtp.services.log import LogService
from crazychoir_fw.crtp.services.memory import MemoryService
from crazychoir_fw.crtp.services.param import ParamService
from crazychoir_fw.crtp.services.platform import AppChannel, PlatformService

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


_S = TypeVar("_S")

SERVICES: Sequence[Callable[[ServiceContext], Service]] = (
    CommanderService,
    ConsoleService,
    HighLevelService,
    LinkService,
    LocalizationService,
    LogService,
    MemoryService,
    ParamService,
    PlatformService,
    SupervisorService,
)
"""All that a drone offers."""


class Station:
    """The services of one drone behind one way in and one way out. It knows nothing of sockets."""

    def __init__(
        self,
        world: World,
        drone: Drone,
        *,
        services: Sequence[Callable[[ServiceContext], Service]] | None = None,
        storage: str | Path | None = None,
    ) -> None:
        """Let a drone listen.

        Args:
            world: Its world.
            drone: The drone.
            services: What it offers; by default `SERVICES`.
            storage: Folder of what clients store on their drones; None keeps it in memory, as long as the world.

        Raises:
            RangeError: If what is stored there cannot be read.
        """
        self.context = ServiceContext(world, drone, storage)
        self.statistics = LinkStatistics(self.context)
        self.services = [make(self.context) for make in (SERVICES if services is None else services)]
        self._by_port = {port: service for service in self.services for port in service.ports}
        self._console = self._of_class(ConsoleService)
        self._has_session = False

    @property
    def app_channel(self) -> AppChannel:
        """For Python that stands in for an app on board."""
        return self._of_class(PlatformService).app_channel

    def _of_class(self, kind: type[_S]) -> _S | None:
        return next((service for service in self.services if isinstance(service, kind)), None)

    def receive(self, datagram: bytes) -> list[bytes]:
        """Take what came by radio, whatever it is, and return the datagrams that answer it at once."""
        self.context.received += 1
        if not 1 <= len(datagram) <= 1 + MAX_PAYLOAD:
            return []
        port, channel = datagram[0] >> 4, datagram[0] & 0x03
        if not self._has_session and (port, channel) != (Port.LINK, NULL_CHANNEL):
            # a client, and not only a scan
            self._has_session = True
            if self._console is not None:
                self._console.begin_session()
        service = self._by_port.get(port)
        if service is None:
            return []
        headers = HEADERS[port]
        datagrams = [headers[of] + payload for of, payload in service.receive(port, channel, datagram[1:])]
        self.context.sent += len(datagrams)
        return datagrams

    def end_session(self) -> None:
        """Forget what belongs to a client that has gone."""
        self._has_session = False
        for service in self.services:
            service.end_session()

    def close(self) -> None:
        """Leave the world as if there had been no station; only the thread that steps the world calls this."""
        self.end_session()
        self.context.closing.close()


STATISTICS_PERIOD = 500
"""Ticks."""


class LinkStatistics:
    """Counts the packets of one drone."""

    def __init__(self, context: ServiceContext) -> None:
        """Begin to count."""
        self._context = context
        self._received = context.received
        self._sent = context.sent
        self._was_heard = False
        self._told: tuple[int | bool, ...] = (0, False, 0, 0, 0)
        self.rssi = 0
        """Attenuation of the radio (dB), as a Crazyflie shows it: 40 is close; 0 while it is not simulated."""
        context.every(STATISTICS_PERIOD, self._tell)

    def _tell(self) -> None:
        received, sent = self._context.received - self._received, self._context.sent - self._sent
        self._received += received
        self._sent += sent
        # a client pings ten times a second, and a second of silence means that it is gone
        is_connected = received > 0 or self._was_heard
        self._was_heard = received > 0
        per_second = 1000 // STATISTICS_PERIOD
        numbers = (
            self.rssi if is_connected else 0,
            is_connected,
            self._received & 0xFFFF,
            min(received * per_second, 0xFFFF),
            min(sent * per_second, 0xFFFF),
        )
        if numbers != self._told:
            self._told = numbers
            self._context.drone.uplink.dispatch("link_statistics", *numbers)
