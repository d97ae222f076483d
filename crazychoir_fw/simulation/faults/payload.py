"""A payload that is dropped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.loading import hook_of

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class PayloadDrop(Fault):
    """The drone lets go of what it carries: the equality constraint ``<drone>/payload`` of the model ends."""

    kind: ClassVar[str] = "payload"
    is_instant: ClassVar[bool] = True

    def check(self, world: World, drone: Drone) -> None:
        """Refuse a drone that carries nothing which it could drop.

        Raises:
            StateError: If there is no such constraint.
        """
        if hook_of(world.model, drone.id) < 0:
            raise StateError(f"{drone.id}: carries no detachable payload")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Let go."""
        drone.uplink.dispatch("drop_payload")
