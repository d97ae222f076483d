"""Compiled models of worlds that differ in values only: a copy with other values instead of another compilation.

A compilation reads files, makes textures and takes 10 ms, a copy 1 ms. The copy has the bits of a compilation; only
the space behind the attributes of its plugins is larger.
"""

from __future__ import annotations

import copy
from collections import OrderedDict
from collections.abc import Hashable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from crazychoir_fw.mujoco_models import SCENES, VEHICLES
from crazychoir_fw.mujoco_models.stamp import Airframe
from crazychoir_fw.onboard.core import attribute_names
from crazychoir_fw.simulation.drone_config import BODY_PARAMETERS, DroneConfig

MAX_DRONES = 16
"""Drones up to which models are kept: those of a large swarm take memory, and its compilation is a small share."""

_KEPT = 2  # templates; a campaign flies one mission, a comparison two
_SEEN = 32  # structures that are remembered
_PADDING = 600  # [bytes] of attributes that may be longer than those of the template

PADDED = "motor_ctrl_properties"
"""The attribute that makes room in a template: the engine plugin does not look at it."""


class ModelTemplate:
    """A compiled model, of which copies with other values are made."""

    def __init__(self, model: mujoco.MjModel, airframes: Mapping[str, Airframe]) -> None:
        self._model = model
        self._airframes = airframes
        self._scratch = mujoco.MjData(model)

    def with_values(self, drones: Sequence[DroneConfig], seed: int) -> mujoco.MjModel | None:
        """Return the model of other drones of the same structure, or None if it has no room for their attributes."""
        texts = [attribute_text(drone, index, seed) for index, drone in enumerate(drones)]
        bounds = [*self._model.plugin_attradr.tolist(), len(self._model.plugin_attr)]
        rooms = [end - begin for begin, end in pairwise(bounds)]
        if any(text is None or len(text) > room for text, room in zip(texts, rooms, strict=True)):
            return None
        model = copy.copy(self._model)
        for text, begin, room in zip(texts, bounds, rooms, strict=False):
            padded = (text or b"").ljust(room, b"\0")
            model.plugin_attr[begin : begin + room] = np.frombuffer(padded, model.plugin_attr.dtype)
        for drone in drones:
            self._place(model, drone)
        mujoco.mj_setConst(model, self._scratch)
        _set_means(model, self._scratch)
        return model

    def _place(self, model: mujoco.MjModel, drone: DroneConfig) -> None:
        airframe, body = self._airframes[drone.platform], model.body(drone.id).id
        mass = mass_of(drone)
        if mass is not None:
            model.body_mass[body] = mass
            model.body_inertia[body] = airframe.inertia * (mass / airframe.mass)
        else:
            model.body_mass[body], model.body_inertia[body] = airframe.mass, airframe.inertia
        pose = start_pose(drone, airframe.rest_height)
        model.body_pos[body], model.body_quat[body] = pose[:3], pose[3:]
        start = int(model.jnt_qposadr[model.body_jntadr[body]])
        model.qpos0[start : start + 7] = model.qpos_spring[start : start + 7] = pose


def start_pose(drone: DroneConfig, rest_height: float) -> tuple[float, float, float, float, float, float, float]:
    """Return where a drone starts: x, y, z (m, world), and its attitude wxyz."""
    x, y, *rest = drone.position
    height = rest[0] if rest and rest[0] is not None else rest_height
    half_yaw = np.radians(drone.yaw_deg) / 2
    return x, y, height, float(np.cos(half_yaw)), 0.0, 0.0, float(np.sin(half_yaw))


def mass_of(drone: DroneConfig) -> float | None:
    """Return the mass that a drone was configured with (kg), or None."""
    mass: Any = drone.mass if drone.mass is not None else drone.overrides().get("mass")
    return mass


def plugin_config(drone: DroneConfig, index: int, seed: int) -> dict[str, str]:
    """Return the attributes of the engine plugin of a drone."""
    return {"seed": str(seed), "id": str(index), **drone.plugin_attributes()}


def attribute_text(drone: DroneConfig, index: int, seed: int) -> bytes | None:
    """Return the attributes of a drone as a model has them, or None if one of them does not exist."""
    config = plugin_config(drone, index, seed)
    if not set(config) <= set(attribute_names()):
        return None
    return b"".join(config.get(name, "").encode() + b"\0" for name in attribute_names())


def _set_means(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute what the compiler does behind `mj_setConst`; the solver scales its tolerance with it.

    Numbers are added one by one, as the compiler does.
    """
    inertia = mass = 0.0
    for address in (model.M_rowadr + model.M_rownnz - 1).tolist():  # of the diagonal
        inertia += float(data.M[address])
    for one in model.body_mass[1:].tolist():
        mass += one
    model.stat.meaninertia = inertia / model.nv
    model.stat.meanmass = mass / (model.nbody - 1)


def structure_of(drones: Sequence[DroneConfig], scene: str | Path, visuals: bool) -> Hashable | None:
    """Return what two worlds must have in common to be copies of one template; None for those that have none."""
    if not 1 <= len(drones) <= MAX_DRONES or str(scene) not in SCENES:
        return None
    found = []
    for drone in drones:
        is_plain = drone.payload is None and isinstance(drone.attributes, Mapping) and drone.platform in VEHICLES
        if not is_plain or any(name != "mass" and name in drone.overrides() for name in BODY_PARAMETERS):
            return None
        color = None if drone.color is None else tuple(drone.color)
        found.append((drone.id, drone.platform, drone.provider, color, str(drone.attributes.get("isolated"))))
    return str(scene), visuals, tuple(found)


class ModelTemplates:
    """The templates of this process. A structure gets one when it comes for the second time."""

    def __init__(self) -> None:
        self._kept: OrderedDict[Hashable, ModelTemplate | None] = OrderedDict()

    def wants(self, structure: Hashable | None) -> bool:
        """Tell whether a world of a structure has come before, and note it."""
        if structure is None:
            return False
        is_known = structure in self._kept
        self._kept.setdefault(structure, None)
        self._kept.move_to_end(structure)
        if len(self._kept) > _SEEN:
            self._kept.popitem(last=False)
        return is_known

    def get(self, structure: Hashable) -> ModelTemplate | None:
        """Return the template of a structure, if there is one."""
        return self._kept.get(structure)

    def keep(self, structure: Hashable, template: ModelTemplate) -> None:
        """Keep a template, and the latest ones beside it."""
        self._kept[structure] = template
        others = [key for key, kept in self._kept.items() if kept is not None and key != structure]
        for key in others[: len(others) - (_KEPT - 1)]:
            self._kept[key] = None


def padding(drone: DroneConfig) -> dict[str, str]:
    """Return the attribute that makes room in a template."""
    own = drone.plugin_attributes()
    return {PADDED: own.get(PADDED, "") + "x" * (_PADDING + 2 * sum(map(len, own.values())))}


def without_padding(texts: Sequence[bytes]) -> Sequence[bytes]:
    """Return the attributes of a plugin, each ended by a zero, without the empty space behind them."""
    count = len(attribute_names()) + 1
    return texts[:count] if len(texts) > count and not any(texts[count:]) else texts
