"""Port 9: the supervisor (docs/reference/crtp-cflib.md#7, docs/reference/planner-commander.md#14.10)."""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.command_queue import CommandQueue
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.onboard.core import receive_packet

INFO, COMMAND = range(2)

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
        if channel == INFO:
            answer = self._tell(payload)
            return () if answer is None else ((INFO, answer),)
        self._emergencies.get(payload, self.packets).take(port, channel, payload)
        return ()

    def _tell(self, payload: bytes) -> bytes | None:
        # past the uplink: questions only read, also while the drone ticks, and belong in no journal
        try:
            return receive_packet(self._context.drone.struct, Port.SUPERVISOR, INFO, payload, self._context.drone.id)
        except CrazychoirError:
            return None

    def end_session(self) -> None:
        """An emergency watchdog that was started goes on, as on the drone."""
