"""Worlds that go on independently from the present instant of another one."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation.motor_ctrl.pilots import Pilots

if TYPE_CHECKING:
    from crazychoir_fw.simulation.world import World


def fork(world: World, count: int) -> list[World]:
    """Return worlds that share the model of another one and have everything else of their own.

    Raises:
        RangeError: If the count is no positive number.
    """
    if not (isinstance(count, int) and count >= 1):
        raise RangeError(f"fork({count!r}): allowed: 1 or more worlds")
    return [_fork(world) for _ in range(count)]


def _fork(world: World) -> World:
    other = type(world).__new__(type(world))
    # a copy of mjData holds more than its state: whatever was computed last is there as well
    chosen = (world.configs, world.scene, world.seed, world.visuals, world.is_replay)
    mirrored = [body.config for body in world.mirrored.values()]
    other._set_up(*chosen, world.model, copy.copy(world.data), world.fingerprint, mirrored)
    other.events = list(world.events)
    other.journal = world.journal.copy()
    other.agenda.seek(world.tick)
    other.when_forked = list(world.when_forked)
    for drone, original in zip(other.drones, world.drones, strict=True):
        drone.commander.set_client_xmode(original.commander.is_client_xmode)
    other.faults.go_on_from(world.faults)
    other._pilots = Pilots(other)
    for carry_over in world.when_forked:
        carry_over(other)
    return other
