"""Contacts of drones that have begun, from the core to the events of a world.

Event ``touchdown``: a drone came down upright on a floor, a table or the like, slower than 2 m/s. Event ``collision``:
everything else. Details of both:

* ``what``: ``drone``, ``floor`` (a surface that carries, within 45 deg of level) or ``obstacle``;
* ``other``: name of the other drone, geom or body (``geom 12`` for one without a name whose body has none either);
* ``speed``: speed (m/s) at which the two approached each other along the normal of the contact;
* ``position``: place of the contact (m, world).

Two drones that collide are one event, of the one that comes first in the world. A contact that breaks for less than
0.2 s goes on. Drones that stand on a floor at the start do not touch down. While the world is not stepped through
`World.step`, 512 events wait; event ``collisions_lost`` says how many more there were.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco

from crazychoir_fw._core import ffi, lib

_BATCH = 64


class Collisions:
    """Takes what happened out of the core."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model = model
        self._data = data  # kept, as its address is used
        self._found = ffi.new("cf_collision_t[]", _BATCH)
        self._lost = ffi.new("uint32_t *")
        addresses = model._address, data._address
        self._take: Callable[[], int] = partial(
            lib.cf_plugin_take_collisions, *addresses, self._found, _BATCH, self._lost
        )

    def note_new(self, note: Callable[..., None]) -> None:
        """Hand what happened since the last time to `World.note`."""
        lost = 0
        while count := self._take():
            lost += int(self._lost[0])
            for found in self._found[0:count]:
                note(
                    "touchdown" if found.kind == lib.CF_COLLISION_TOUCHDOWN else "collision",
                    self._model.body(found.drone).name,
                    at=found.time,
                    what=_what(found.kind),
                    other=self._name(found),
                    speed=round(found.speed, 4),
                    position=[round(value, 4) for value in found.position],
                )
        if lost:
            note("collisions_lost", count=lost)

    def forget(self) -> None:
        """Drop what happened on a way that the world did not go."""
        while self._take():
            pass

    def _name(self, found: Any) -> str:
        if found.other >= 0:
            return self._model.body(found.other).name
        body = self._model.body(int(self._model.geom_bodyid[found.geom]))
        return self._model.geom(found.geom).name or (body.name if body.id > 0 else "") or f"geom {found.geom}"


def _what(kind: int) -> str:
    if kind == lib.CF_COLLISION_DRONE:
        return "drone"
    return "obstacle" if kind == lib.CF_COLLISION_OBSTACLE else "floor"
