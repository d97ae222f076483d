"""Where defenders should be: what a flight with aggregative surveillance is judged and drawn by.

Taken from the mission and not from the objects that fly, which may live in other processes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.mission.roles import guidance_class, guidance_of, names_of, team_of
from crazychoir_fw.recording.marks import Mark

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surveillance:
    """Who guards what against whom."""

    defenders: tuple[int, ...]
    """Numbers of the defenders."""
    intruders: tuple[Any, ...]
    """Of each defender: a number of a drone, or a place (m), shape (2,)."""
    target: Array | None
    """What is guarded (m), shape (2,)."""
    height: float
    """Of the defenders (m)."""
    gammas: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Weights of intruder, target and shape."""

    def intruders_at(self, at: Array) -> Array:
        """Return where the intruders of the defenders are (m), shape (..., D, 2), given all drones, (..., N, 3)."""
        columns = [
            at[..., one, :2] if isinstance(one, int) else np.broadcast_to(one, (*at.shape[:-2], 2))
            for one in self.intruders
        ]
        return np.stack(columns, axis=-2)

    def places(self, at: Array) -> Array:
        """Return the optimum (m), shape (..., D, 2), given all drones, shape (..., N, 3).

        The gradients of the sum of all costs are zero there; with all weights 1 it is half-way between intruder and
        target.
        """
        intruder, target, shape = self.gammas
        where = self.intruders_at(at)
        center = where.mean(axis=-2, keepdims=True)
        pull = np.zeros_like(center)
        if self.target is not None:
            center = (intruder * center + target * self.target) / (intruder + target)
            pull = target * (center - self.target)
        return (intruder * where + shape * center - pull) / (intruder + shape)

    def errors(self, at: Array) -> Array:
        """Return how far each defender is from its place (m), shape (..., D), given all drones, shape (..., N, 3)."""
        return np.linalg.norm(at[..., list(self.defenders), :2] - self.places(at), axis=-1)

    def marks(self, end: Array | None) -> list[Mark]:
        """Return what is drawn of it: target and intruders, that move where they are at the end."""
        found = []
        if self.target is not None:
            found.append(Mark(np.array([*self.target, self.height]), kind="target"))
        for one in self.intruders:
            if not isinstance(one, int):
                found.append(Mark(np.array([*one, self.height]), kind="intruder"))
            elif end is not None:
                found.append(Mark(end[one], kind="intruder", moves=True))
        return found


def surveillance_of(mission: LayeredMission) -> Surveillance | None:
    """Return the surveillance of a mission, if there is one with an intruder for each defender."""
    defenders: list[int] = []
    intruders: list[Any] = []
    options: Mapping[str, Any] = {}
    height = 1.0
    for i, name in enumerate(names_of(mission)):
        # by what it has, so that nobody loads a scheme who flies none
        moves = getattr(guidance_class(mission, i), "intruder_moves", None)
        if moves is None:
            continue
        layer = guidance_of(mission, i)
        options, height = {**layer.options, **layer.options_by_drone.get(name, {})}, layer.height
        number = options.get("intruder_id", i + len(team_of(mission, i)) if moves else None)
        place = options.get("intruder")
        if number is None and place is None:
            return None
        defenders.append(i)
        intruders.append(int(number) if number is not None else np.array(place[:2], float))
    if not defenders:
        return None
    target = options.get("target")
    gammas = tuple(float(options.get(f"gamma_{what}", 1.0)) for what in ("intruder", "target", "shape"))
    place = None if target is None else np.array(target[:2], float)
    return Surveillance(tuple(defenders), tuple(intruders), place, height, gammas)  # type: ignore[arg-type]
