"""Services of an experiment: what belongs to no drone, such as a table of tasks, and takes its turn in every round."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.messages import Pose

if TYPE_CHECKING:
    from crazychoir_fw.flight.agent import Agent
    from crazychoir_fw.guidance.schemes.tasks import DispatchTable

Note = Callable[..., None]
"""`note(kind, drone, details="")` records an event.

drone is a number, or None for the whole flight; details are a sentence, or plain values by name."""


def _no_note(kind: str, drone: int | None, details: str | Mapping[str, Any] = "") -> None:
    del kind, drone, details


class Service(Stateful):
    """Takes its turn in each round before guidance does. Subclasses override what they need."""

    note: Note = staticmethod(_no_note)
    """Writes a happening; the experiment that runs the service puts its own here."""

    def start(self, now: float) -> None:
        """Called when START is pressed, for whichever drones; may be called again."""

    def step(self, now: float, poses: Pose, flying: NDArray[np.bool_]) -> None:
        """Take a turn.

        Args:
            now: Time (s).
            poses: Where all drones are (m, world), shape (N, 3); those that are not seen, where they were.
            flying: Whose motors turn, shape (N,).
        """


class TableService(Service):
    """A table of work, as a service."""

    def __init__(self, table: DispatchTable) -> None:
        """Run a table."""
        self.table = table
        table.note = lambda kind, agent, details: self.note(kind, agent, details)

    def start(self, now: float) -> None:
        """Begin, the first time."""
        self.table.start(now)

    def step(self, now: float, poses: Pose, flying: NDArray[np.bool_]) -> None:
        """Look at the time; see `Service`."""
        del poses, flying
        self.table.step(now)


def make_table(mission: Any) -> DispatchTable | None:
    """Return the table of a mission, if it has one.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    count, layers = len(mission.fleet), mission.layers
    if layers.tasks is not None:
        from crazychoir_fw.guidance.schemes import PositionTaskTable

        return PositionTaskTable(count, **dict(layers.tasks))
    if layers.delivery is not None:
        from crazychoir_fw.guidance.schemes import DeliveryTable
        from crazychoir_fw.guidance.schemes.delivery import DeliveryRequest

        layer = layers.delivery
        requests = [DeliveryRequest(k, **dict(entry)) for k, entry in enumerate(layer.requests)]
        return DeliveryTable(count, requests, deadline=layer.deadline, patience=layer.patience)
    return None


def make_services(mission: Any, agents: Sequence[Agent]) -> list[Service]:
    """Return the services of a mission, known to the guidance that uses them.

    Args:
        mission: A mission with layers.
        agents: The layers of its drones, in its order.

    Raises:
        CrazychoirError: If one cannot be made as the mission says.
    """
    table = make_table(mission)
    if table is None:
        return []
    for agent in agents:
        if hasattr(agent.guidance, "connect"):
            agent.guidance.connect(table)
    return [TableService(table)]
