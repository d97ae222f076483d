"""`Viewing`: the page's view of drones that are flown by something else, to be looked at and not commanded."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.flight.sim_backend import truth
from crazychoir_fw.gui.feed import PHASES, Feed, Frame
from crazychoir_fw.gui.room import Room
from crazychoir_fw.simulation.targets import Targets

if TYPE_CHECKING:
    from crazychoir_fw.simulation import World

_IN_THE_AIR_M = 0.1


class Viewing(Feed):
    """Drones of a world, of which `show` makes the frames."""

    def __init__(self, world: World, title: str) -> None:
        """Look at the world."""
        super().__init__([drone.id for drone in world.drones])
        self.title = title
        self.is_over = False
        self._world = world
        self._read, self._targets = truth(world), Targets(world.drones)
        self._room = Room(world, self.names)
        self._pace: deque[tuple[float, float]] = deque(maxlen=30)

    def show(self, seconds: float, clock: float) -> None:
        """Lay out the present instant.

        Args:
            seconds: Time of the flight (s).
            clock: Time on the wall (s).
        """
        pose = self._read()
        self._pace.append((seconds, clock))
        (then, before) = self._pace[0]
        is_up = pose.position[:, 2] > _IN_THE_AIR_M
        phase = np.where(is_up, PHASES.index("flying"), PHASES.index("ground"))
        phase[[drone.failure is not None for drone in self._world.drones]] = PHASES.index("failed")
        rate = (seconds - then) / (clock - before) if clock > before else 0.0
        number = 1 if self.frame is None else self.frame.number + 1
        self.frame = Frame(
            number, seconds, rate, pose.position, pose.orientation, self._targets.positions(), phase, self._room.poses()
        )

    def setting(self) -> dict[str, Any]:
        """Return what does not change, as `setting_of` does."""
        return {
            "names": self.names,
            "backend": "only watched",
            "is_watched": True,
            "graph": [],
            "obstacles": self._room.things,
            "safety_area": None,
            "log_names": [],
            "log_about": {},
            "trail": {"times": [], "positions": []},
            "missing": {},
            "phases": [],
            "height": 1.0,
        }

    async def words(self) -> dict[str, Any]:
        """Return the slowly changing values of a flight that is only watched."""
        return {"branch": 0, "branches": [], "error": "The flight is over." if self.is_over else None, "speed": 1.0}
