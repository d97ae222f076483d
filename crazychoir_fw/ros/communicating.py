"""Nodes with a guidance that communicates: topics of a communicator, and the parameters that name them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from crazychoir_fw.guidance import TimeVaryingCommunicator
from crazychoir_fw.ros.communicator import RosTransport
from crazychoir_fw.ros.node import LayerNode


class CommunicatingNode(LayerNode):
    """A node that may have a communicator."""

    transport: RosTransport | None = None
    """Topics of its communicator, if it has one."""

    def declare_start(self) -> list[float] | None:
        """Declare ``init_pos`` and return it."""
        return self.declare(
            "init_pos", None, "start position (m, world); by default the first pose", list[float], length=3
        )

    def declare_communicator(self, kind: type = TimeVaryingCommunicator, **options: Any) -> Any:
        """Declare ``N``, ``in_neigh`` and ``out_neigh``, and return a communicator over topics."""
        size = self.declare("N", 1, "number of agents", low=1)
        heard = self.declare("in_neigh", [], "neighbors that this agent hears", list[int], low=0, high=size - 1)
        hearers = self.declare("out_neigh", heard, "neighbors that hear this agent", list[int], low=0, high=size - 1)
        return self.make_communicator(size, heard or [], hearers or [], kind, **options)

    def make_communicator(
        self,
        size: int,
        heard: list[int],
        hearers: list[int],
        kind: Any = TimeVaryingCommunicator,
        disturb: Callable[[Any], Any] | None = None,
        **options: Any,
    ) -> Any:
        """Return a communicator over topics of this node; `disturb` wraps its transport."""
        self.make_transport(kind.reliable)
        transport = self.transport if disturb is None else disturb(self.transport)
        topic = self.namespace_pattern.replace("{i}", "{agent}") + "/communicator"
        options.setdefault("clock", time.monotonic)
        return kind(self.agent_id, size, heard, hearers, transport=transport, topic=topic, **options)

    def make_transport(self, reliable: bool = True) -> RosTransport:
        """Return topics of this node as a transport."""
        self.transport = RosTransport(self, reliable=reliable)
        return self.transport

    @property
    def is_connected(self) -> bool:
        """Whether every topic of its communicator has a publisher and a subscriber in another node."""
        return self.transport is None or self.transport.is_connected
