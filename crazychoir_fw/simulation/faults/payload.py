"""A payload that is dropped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import mujoco

from crazychoir_fw.errors import StateError
from crazychoir_fw.simulation.faults.fault import Fault

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
        if constraint_of(world.model, drone.id) < 0:
            raise StateError(f"{drone.id}: carries no detachable payload")

    def begin(self, world: World, drone: Drone, seed: int) -> None:
        """Let go."""
        drone.uplink.deliver("drop_payload")


def constraint_of(model: mujoco.MjModel, name: str) -> int:
    """Return the number of the constraint that holds the payload of a drone, or -1."""
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, f"{name}/payload"))


def drop(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> None:
    """Let go of the payload of a drone; one that is gone, or never was, is no error."""
    number = constraint_of(model, name)
    if number >= 0:
        data.eq_active[number] = 0
