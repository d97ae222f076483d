"""The drones that a compiled model has already: what their attributes say, as configurations."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import mujoco
import numpy as np

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.user_code import anchored
from crazychoir_fw.onboard.core import attribute_names
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.motor_ctrl_words import parse_properties, require_class

_FIELDS = ("platform", "provider", "controller", "estimator", "positioning")


def drones_in(model: mujoco.MjModel, known: Collection[str], folder: Path) -> list[DroneConfig]:
    """Return the drones of a model, in the order of the model, without those of these names.

    Args:
        model: A compiled model.
        known: Names of drones that are known already.
        folder: Where the paths in its attributes start.

    Raises:
        RangeError: If the body of a drone has no name, or its properties are not of the form key=value.
    """
    found = []
    for body in range(model.nbody):
        name = model.body(body).name
        texts = None if name and name in known else _texts(model, int(model.body_plugin[body]))
        if texts is None:
            continue
        if not name:
            raise RangeError(f"body {body} carries a Crazyflie and has no name, which its drone is called by")
        found.append(_config(model, body, name, texts, folder))
    return found


def is_crazyflie(model: mujoco.MjModel, instance: int) -> bool:
    """Return whether a plugin instance of a model is a Crazyflie."""
    return lib.cf_plugin_attribute(model._address, instance, b"platform") != ffi.NULL


def _texts(model: mujoco.MjModel, instance: int) -> dict[str, str] | None:
    """Return the attributes of a Crazyflie that are set, or None if this plugin is no Crazyflie."""
    if not is_crazyflie(model, instance):
        return None
    texts = {
        name: ffi.string(lib.cf_plugin_attribute(model._address, instance, name.encode())).decode()
        for name in attribute_names()
    }
    return {name: text for name, text in texts.items() if text}


def _config(model: mujoco.MjModel, body: int, name: str, texts: dict[str, str], folder: Path) -> DroneConfig:
    start = int(model.jnt_qposadr[model.body_jntadr[body]])
    x, y, z, qw, qx, qy, qz = model.qpos0[start : start + 7].tolist()
    control = texts.pop("motor_ctrl", None)
    properties = parse_properties(texts.pop("motor_ctrl_properties", ""), name)
    require_class(name, control, properties)
    return DroneConfig(
        name,
        (x, y, z),
        yaw_deg=float(np.degrees(np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))),
        mass=float(model.body_mass[body]),
        motor_ctrl=None if control is None else anchored(control, folder),
        motor_ctrl_properties=properties,
        **{field: texts.pop(field) for field in _FIELDS if field in texts},
        battery=float(texts.pop("battery")) if "battery" in texts else None,
        noise=float(texts.pop("noise")) if "noise" in texts else None,
        attributes=texts,
    )
