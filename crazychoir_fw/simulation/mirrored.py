"""Bodies of a world that something outside of it moves: real drones, and whatever else motion capture sees.

A mirrored body is heavy and weightless, and its pose and velocity are set from outside. Between two settings it goes on
with its velocity. So contacts with it have the right speed, and hardly move it. It is no drone: it has no onboard
software, blows on no drone, and is in no journal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.mujoco_models import VEHICLES
from crazychoir_fw.mujoco_models.stamp import VehicleStamp
from crazychoir_fw.onboard.core import check

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone

SPHERE = "sphere"
LIKENESSES = (SPHERE, *VEHICLES)
"""What a mirrored body may look like."""

GREEN = (0.1, 0.75, 0.3)
"""Color of mirrored bodies, so that people tell them from simulated drones."""

_MASS = 1.0  # [kg], thirty times that of a drone
_INERTIA = 0.01  # [kg m^2]
_TOUCHES_DRONES = 2  # the bit that hulls have and floors do not
_LAST_PEER = 255  # the id that mirrored bodies are numbered down from; drones count from 1


@dataclass(frozen=True)
class MirroredConfig:
    """One mirrored body."""

    id: str
    """Unique name."""
    position: Sequence[float] = (0.0, 0.0, 0.0)
    """Where it is until `MirroredBody.put` (m, world)."""
    likeness: str = SPHERE
    """`sphere`, or the platform whose airframe it looks like."""
    radius: float = 0.06
    """Of a sphere (m)."""
    collides: bool = False
    """Whether drones touch it; otherwise they fly through."""
    color: tuple[float, float, float] = GREEN
    """Red, green, blue, each in [0, 1]."""


def add_mirrored(spec: mujoco.MjSpec, config: MirroredConfig, stamps: dict[str, VehicleStamp], visuals: bool) -> None:
    """Add one to a specification.

    Args:
        spec: The world.
        config: The body.
        stamps: Airframes that are there already, by platform; completed.
        visuals: Whether drones can be seen.

    Raises:
        RangeError: If it can look like nothing of that kind, or is nowhere.
    """
    if config.likeness not in LIKENESSES:
        raise RangeError(f"{config.id}: likeness is {config.likeness!r}, allowed: {', '.join(LIKENESSES)}")
    if np.shape(config.position) != (3,) or not np.isfinite(config.position).all():
        raise RangeError(f"{config.id}: position is {config.position}, allowed: three finite numbers (m)")
    if not 0.005 <= config.radius <= 1.0:
        raise RangeError(f"{config.id}: radius is {config.radius}, allowed: 0.005 to 1 m")
    if config.likeness == SPHERE:
        body = spec.worldbody.add_body(name=config.id, pos=config.position)
        body.add_freejoint(name=f"{config.id}/root")
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        body.add_geom(name=f"{config.id}/accent", type=sphere, size=[config.radius, 0, 0], rgba=(*config.color, 1.0))
    else:
        if config.likeness not in stamps:
            stamps[config.likeness] = VehicleStamp(spec, config.likeness, visuals)
        body = stamps[config.likeness].place(config.id, config.position, rgba=(*config.color, 1.0))
    for geom in body.geoms:
        # the hull of an airframe, or the sphere
        touches = config.collides and (geom.contype or config.likeness == SPHERE)
        geom.contype = geom.conaffinity = _TOUCHES_DRONES if touches else 0
    body.gravcomp = 1.0
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = _MASS, [_INERTIA] * 3, [0.0, 0.0, 0.0]


class MirroredBody:
    """A mirrored body of a world that runs."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, config: MirroredConfig, number: int) -> None:
        self.config = config
        self.id = config.id
        joint = int(model.body_jntadr[model.body(config.id).id])
        start, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        self._pose, self._motion = data.qpos[start : start + 7], data.qvel[dof : dof + 6]
        self._peer = _LAST_PEER - number

    @property
    def position(self) -> NDArray[np.float64]:
        """Where it is (m, world), shape (3,)."""
        return self._pose[:3].copy()

    @property
    def velocity(self) -> NDArray[np.float64]:
        """How fast it moves (m/s, world), shape (3,)."""
        return self._motion[:3].copy()

    def put(self, position: ArrayLike, quat_xyzw: ArrayLike, velocity: ArrayLike, body_rates: ArrayLike) -> None:
        """Set where it is and how it moves.

        Args:
            position: (m, world), shape (3,).
            quat_xyzw: Attitude, shape (4,).
            velocity: (m/s, world), shape (3,).
            body_rates: (rad/s, body), shape (3,).

        Raises:
            RangeError: If a number is not finite.
        """
        x, y, z, w = np.asarray(quat_xyzw, float)
        numbers = np.concatenate([position, (w, x, y, z), velocity, body_rates])
        if not np.isfinite(numbers).all():
            raise RangeError(f"{self.id}: pose and velocity are {numbers.tolist()}, allowed: finite numbers")
        self._pose[:], self._motion[:] = numbers[:7], numbers[7:]

    def tell(self, drones: Sequence[Drone]) -> None:
        """Tell drones that avoid collisions where it is, as a radio would, by broadcast."""
        position = [float(value) for value in self._pose[:3]]
        for drone in drones:
            if drone.struct.wants_peers and not drone.failure:
                status = drone.uplink.request("cf_send_peer_position", self._peer, *position)
                check(status, f"{drone.id}: position of {self.id}")


def mirrored_bodies(model: mujoco.MjModel, data: Any, configs: Sequence[MirroredConfig]) -> dict[str, MirroredBody]:
    """Return the mirrored bodies of a world, by name."""
    return {config.id: MirroredBody(model, data, config, number) for number, config in enumerate(configs)}
