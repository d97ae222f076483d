"""Ports 3 and 7: setpoints (docs/reference/crtp-cflib.md#12, docs/reference/planner-commander.md#8.4, #9 and #10)."""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.command_queue import CommandQueue
from crazychoir_fw.crtp.services.service import Reply


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
