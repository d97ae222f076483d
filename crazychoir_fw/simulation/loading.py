"""Mass and inertia of a drone's body, and what it carries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.model_templates import mass_of

_RADIUS = 0.006  # of the ball that a payload is drawn as and lands as (m)
_COLOR = (0.25, 0.25, 0.28, 1.0)
_FLOOR_BIT = 1  # what stands in the world collides with this bit; hulls of drones do not
_STIFF = (0.004, 1.0)  # time constant (s) and damping ratio of the hook


class Payload:
    """What hangs on a drone's hook in one world."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drone_id: str) -> None:
        name = payload_name(drone_id)
        joint = int(model.body_jntadr[model.body(name).id])
        self._hook = hook_of(model, drone_id)
        self._data = data
        self._pose = data.qpos[model.jnt_qposadr[joint] :][:7]
        self._twist = data.qvel[model.jnt_dofadr[joint] :][:6]
        self._offset = model.eq_data[self._hook, 3:6].copy()

    @property
    def is_attached(self) -> bool:
        """Whether it still hangs there."""
        return bool(self._data.eq_active[self._hook])

    @property
    def position(self) -> NDArray[np.float64]:
        """Where it is (m, world), shape (3,)."""
        return self._pose[:3].copy()

    def follow(self, drone_pose: NDArray[np.float64]) -> None:
        """Go along with a drone that was put somewhere else, shape (7,), at rest."""
        if self.is_attached:
            rotation = np.zeros(9)
            mujoco.mju_quat2Mat(rotation, drone_pose[3:])
            self._pose[:3] = drone_pose[:3] + rotation.reshape(3, 3) @ self._offset
            self._pose[3:] = drone_pose[3:]
            self._twist[:] = 0.0


def payload_name(drone_id: str) -> str:
    """Return the name of the body and of the hook of a drone's payload."""
    return f"{drone_id}/payload"


def hook_of(model: mujoco.MjModel, drone_id: str) -> int:
    """Return the number of the equality constraint that holds the payload of a drone, or -1."""
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, payload_name(drone_id)))


def drop_payload(model: mujoco.MjModel, data: mujoco.MjData, drone_id: str) -> None:
    """Let the payload of a drone fall; one that is gone, or never was, is no error."""
    hook = hook_of(model, drone_id)
    if hook >= 0:
        data.eq_active[hook] = 0


def check_payload(drone: DroneConfig) -> None:
    """Refuse a payload that cannot be.

    Raises:
        RangeError: With the key, its value and what is allowed.
    """
    if drone.payload is None:
        return
    where = f"{drone.id}: payload"
    if not isinstance(drone.payload, Mapping) or "mass" not in drone.payload:
        raise RangeError(f"{where} is {str(drone.payload)[:60]}, allowed: mass, and if wanted offset and detachable")
    for key in drone.payload:
        if key not in ("mass", "offset", "detachable"):
            raise RangeError(f"{where} has '{str(key)[:40]}', allowed: mass, offset, detachable")
    mass = drone.payload["mass"]
    if not _is_within(mass, 1e-5, 0.2):
        raise RangeError(f"{where}.mass is {mass!r}, allowed: 0.00001 to 0.2 kg")
    offset = drone.payload.get("offset", (0.0, 0.0, 0.0))
    is_point = isinstance(offset, Sequence | np.ndarray) and not isinstance(offset, str) and len(offset) == 3
    if not is_point or not all(_is_within(number, -0.5, 0.5) for number in offset):
        raise RangeError(f"{where}.offset is {offset!r}, allowed: x, y, z within -0.5 to 0.5 m")
    if not isinstance(drone.payload.get("detachable", False), bool):
        raise RangeError(f"{where}.detachable is {drone.payload['detachable']!r}, allowed: true or false")


def _is_within(value: Any, low: float, high: float) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and low <= value <= high


def set_inertia(body: mujoco.MjsBody, drone: DroneConfig) -> None:
    """Give a body the mass and inertia that a drone was configured with; without an inertia it scales with the mass."""
    chosen = drone.overrides()
    mass = mass_of(drone)
    if mass is not None:
        body.inertia = body.inertia * (mass / body.mass)
        body.mass = mass
    if "inertia" in chosen or "products_of_inertia" in chosen:
        diagonal = chosen.get("inertia", tuple(body.inertia))
        products = chosen.get("products_of_inertia", (0.0, 0.0, 0.0))
        _set_full_inertia(body, _matrix(diagonal, products), drone)


def _matrix(diagonal: Sequence[float], products: Sequence[float]) -> NDArray[np.float64]:
    xy, xz, yz = products
    return np.diag(diagonal) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])


def _set_full_inertia(body: mujoco.MjsBody, inertia: NDArray[np.float64], drone: DroneConfig) -> None:
    principal = np.linalg.eigvalsh(inertia)
    if principal[0] <= 0 or principal[0] + principal[1] < principal[2]:
        raise RangeError(
            f"{drone.id}: inertia has the principal values {', '.join(f'{value:.3g}' for value in principal)} kg m^2, "
            "allowed: all positive, and two together no less than the third"
        )
    i = inertia
    if not np.any(i - np.diag(np.diag(i))):
        body.inertia = np.diag(i)
        return
    body.inertia = np.zeros(3)
    body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]


def _inertia_of(body: mujoco.MjsBody) -> NDArray[np.float64]:
    full = np.asarray(body.fullinertia)
    if np.all(np.isfinite(full)) and full[0] > 0:
        return _matrix(full[:3], full[3:])
    return np.diag(body.inertia)


def add_payload(spec: mujoco.MjSpec, body: mujoco.MjsBody, drone: DroneConfig) -> None:
    """Load a drone. What can be detached is a body of its own on a hook; the rest becomes part of the drone's body.

    A hook is a weld whose switch is part of the world's state, so that a restored flight has its payload back.
    """
    if drone.payload is None:
        return
    mass = float(drone.payload["mass"])
    offset = np.array(drone.payload.get("offset", (0.0, 0.0, 0.0)), dtype=float)
    if drone.payload.get("detachable", False):
        _hang(spec, body, payload_name(drone.id), mass, offset)
        return

    total = body.mass + mass
    center = mass / total * offset
    inertia = _inertia_of(body) + body.mass * _of_point(center) + mass * _of_point(offset - center)
    body.mass = total
    body.ipos = center
    _set_full_inertia(body, inertia, drone)
    body.add_geom(
        name=payload_name(drone.id),
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[_RADIUS, 0, 0],
        pos=offset,
        rgba=_COLOR,
        contype=0,
        conaffinity=0,
        mass=0,
        group=2,
    )


def _of_point(offset: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inertia (kg m^2) of 1 kg at an offset (m)."""
    return offset @ offset * np.eye(3) - np.outer(offset, offset)


def _hang(spec: mujoco.MjSpec, body: mujoco.MjsBody, name: str, mass: float, offset: NDArray[np.float64]) -> None:
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, np.asarray(body.quat))
    load = spec.worldbody.add_body(
        name=name,
        pos=np.asarray(body.pos) + rotation.reshape(3, 3) @ offset,
        quat=body.quat,
        mass=mass,
        inertia=np.full(3, 0.4 * mass * _RADIUS**2),
        ipos=np.zeros(3),  # left out, MuJoCo takes the position of the body
        iquat=[1, 0, 0, 0],
        explicitinertial=True,
    )
    load.add_freejoint(name=f"{name}/root")
    load.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[_RADIUS, 0, 0],
        rgba=_COLOR,
        contype=_FLOOR_BIT,
        conaffinity=0,
        condim=3,
        friction=[0.6, 0.005, 0.0001],
        solref=[0.01, 1],
        mass=0,
    )
    hook = spec.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=body.name,
        name2=name,
        solref=_STIFF,
    )
    # data: anchor (3), pose of the load seen from the drone (7), torque scale
    hook.data[:11] = [0, 0, 0, *offset, 1, 0, 0, 0, 1]
