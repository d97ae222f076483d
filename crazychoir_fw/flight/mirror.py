"""Poses of real drones, as they come, onto their mirrored bodies in a simulated world."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.smooth_path import SmoothPath

if TYPE_CHECKING:
    from crazychoir_fw.simulation import World
    from crazychoir_fw.simulation.mirrored import MirroredBody

STRIDE = 5
"""Ticks (ms) between two settings of a mirrored body."""

_TELL_S = 0.05  # between two broadcasts of where they are, to drones that avoid collisions


class Mirror:
    """Moves the mirrored bodies of a world. A body without fresh poses stays where it is, and is marked stale."""

    def __init__(self, world: World, bodies: list[MirroredBody]) -> None:
        """Take a world and those of its bodies that are to be moved, in the order of the poses to come."""
        self._world = world
        self._followed = [_Followed(body) for body in bodies]
        self._next_tell = -math.inf

    def see(self, poses: Pose) -> None:
        """Take where they are, arrays of shape (N, ...); NaN is unknown."""
        for i, followed in enumerate(self._followed):
            followed.see(self._world, i, poses)

    def advance(self, ticks: int) -> None:
        """Let the world go on for so many milliseconds, and the bodies in it."""
        world = self._world
        while ticks:
            for followed in self._followed:
                followed.put(world.time)
            if world.time >= self._next_tell:
                self._next_tell = world.time + _TELL_S
                for followed in self._followed:
                    if not followed.is_stale:
                        followed.body.tell(world.drones)
            stride = min(STRIDE, ticks)
            world.step(stride)
            ticks -= stride

    @property
    def stale(self) -> frozenset[str]:
        """Names of those whose poses are stale."""
        return frozenset(followed.body.id for followed in self._followed if followed.is_stale)

    def report(self) -> list[dict[str, Any]]:
        """Return the reception statistics of each mirrored body, for summary.json."""
        return [followed.report() for followed in self._followed]


class _Followed:
    """One mirrored body and what is known of the real one."""

    def __init__(self, body: MirroredBody) -> None:
        self.body = body
        self.is_stale = True
        self._path = SmoothPath()
        self._last: NDArray[np.float64] | None = None  # position and velocity of the last pose
        self._looks = self._heard = 0
        self._gaps = 0
        self._longest_stale = 0.0
        self._heard_at = 0.0

    def see(self, world: World, i: int, poses: Pose) -> None:
        position, now = poses.position[i], world.time  # type: ignore[index]
        self._looks += 1
        if not np.isfinite(position).all():
            if not self.is_stale:
                self.is_stale = True
                self._gaps += 1
                world.note("stale", self.body.id, reason="it is not heard of, and stays where it was seen last")
            return
        if self._path.has_begun and self.is_stale:
            self._longest_stale = max(self._longest_stale, now - self._heard_at)
            world.note("heard_again", self.body.id, silence_s=round(now - self._heard_at, 3))
        self.is_stale, self._heard_at = False, now
        self._heard += 1
        sample = np.concatenate([position, poses.velocity[i]])  # type: ignore[index]
        if self._last is not None and np.array_equal(sample, self._last):
            return  # nothing new
        self._last = sample
        angular = poses.angular[i]  # type: ignore[index]
        self._path.see(Pose(position, poses.orientation[i], poses.velocity[i], angular), now)  # type: ignore[index]

    def put(self, now: float) -> None:
        if self._path.has_begun:
            pose = self._path.at(now)
            self.body.put(pose.position, pose.orientation, pose.velocity, pose.angular)  # type: ignore[arg-type]

    def report(self) -> dict[str, Any]:
        return {
            "id": self.body.id,
            "heard": round(self._heard / max(1, self._looks), 4),
            "gaps": self._gaps,
            "longest_stale_s": round(self._longest_stale, 3),
            "stale": self.is_stale,
        }
