"""Ports whose packets go to the drone as they are, and the link service.

Setpoints (3 and 7, docs/reference/crtp-cflib.md#12), the high-level commander (8, #13), the supervisor (9, #7) and the
link service (15, #5); what the drone does with them stands in docs/reference/planner-commander.md#7 to #14.10.
"""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import CommandQueue, Reply
from crazychoir_fw.onboard.core import receive_packet


class CommanderService:
    """Hands setpoints to the drone; none of them is answered."""

    ports = (Port.COMMANDER, Port.COMMANDER_GENERIC)

    def __init__(self, context: ServiceContext) -> None:
        # the newest setpoint replaces others anyway
        self.packets = CommandQueue(context, newest_wins=True)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Let a setpoint take effect in the next step."""
        self.packets.take(port, channel, payload)
        return ()

    def end_session(self) -> None:
        """The drone keeps its last setpoint until that is too old, as the firmware does."""


HIGH_LEVEL_CHANNEL = 0
"""The channel that clients use; the firmware looks at none."""


class HighLevelService:
    """Hands commands to the drone; its answer tells whether they were accepted."""

    ports = (Port.COMMANDER_HIGH_LEVEL,)

    def __init__(self, context: ServiceContext) -> None:
        self.packets = CommandQueue(context)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Let a command take effect in the next step; the answer follows then."""
        self.packets.take(port, HIGH_LEVEL_CHANNEL, payload)
        return ()

    def end_session(self) -> None:
        """The drone goes on with its latest high-level command."""


QUESTION = 0

EMERGENCY_STOP = b"\x03"
EMERGENCY_WATCHDOG = b"\x04"


class SupervisorService:
    """Answers questions at once, and obeys between two steps of the simulation."""

    ports = (Port.SUPERVISOR,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self.packets = CommandQueue(context)
        # one that waits is as good as many, and nothing else can take its place
        self._emergencies = {request: CommandQueue(context, 1) for request in (EMERGENCY_STOP, EMERGENCY_WATCHDOG)}

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer a question; a command is answered when it has been obeyed."""
        if channel == QUESTION:
            answer = self._tell(payload)
            return () if answer is None else ((QUESTION, answer),)
        self._emergencies.get(payload, self.packets).take(port, channel, payload)
        return ()

    def _tell(self, payload: bytes) -> bytes | None:
        # past the uplink: questions only read, also while the drone ticks, and belong in no journal
        try:
            return receive_packet(
                self._context.drone.struct, Port.SUPERVISOR, QUESTION, payload, self._context.drone.id
            )
        except CrazychoirError:
            return None

    def end_session(self) -> None:
        """An emergency watchdog that was started goes on, as on the drone."""


ECHO, SOURCE, SINK, NULL_CHANNEL = range(4)

GREETING = b"Bitcraze Crazyflie".ljust(MAX_PAYLOAD, b"\0")
"""By this a client tells that the protocol version can be asked for."""


class LinkService:
    """Echoes a packet, answers a request for the link source, or drops the packet."""

    ports = (Port.LINK,)

    def __init__(self, context: ServiceContext) -> None:
        pass

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer an echo with itself and a question for the source with the greeting."""
        if channel == ECHO:
            return ((ECHO, payload),)
        if channel == SOURCE:
            return ((SOURCE, GREETING),)
        return ()

    def end_session(self) -> None:
        """There is nothing to forget."""
