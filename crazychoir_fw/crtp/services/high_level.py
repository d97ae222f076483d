"""Port 8: the high-level commander (docs/reference/crtp-cflib.md#13, docs/reference/planner-commander.md#7)."""

from __future__ import annotations

from collections.abc import Iterable

from crazychoir_fw.crtp.packet import Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.command_queue import CommandQueue
from crazychoir_fw.crtp.services.service import Reply

COMMANDS = 0
"""The channel that clients use; the firmware looks at none."""


class HighLevelService:
    """Hands commands to the drone; its answer tells whether they were accepted."""

    ports = (Port.COMMANDER_HIGH_LEVEL,)

    def __init__(self, context: ServiceContext) -> None:
        self.packets = CommandQueue(context)

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Let a command take effect in the next step; the answer follows then."""
        self.packets.take(port, COMMANDS, payload)
        return ()

    def end_session(self) -> None:
        """The drone goes on with what it was told."""
