"""The stage of a recorded flight: a model to look at, and where everything in it was.

Everything comes from the log: scene and drones from the recipe of its journal or its metadata, poses from its signals.
Nothing on a stage flies, and no code of the user's is built, loaded or run.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import quaternion_xyzw
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.mujoco_models import VEHICLES
from crazychoir_fw.onboard.core import register_plugin
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.simulation.builder import build_stage
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.mirrored import GREEN
from crazychoir_fw.simulation.recipe import scene_differs

_LOOKS = ("id", "position", "yaw_deg", "color", "payload", "platform")
"""What of the configuration of a drone can be seen."""


@dataclass(frozen=True)
class Stage:
    """A model and its states over a flight."""

    model: mujoco.MjModel
    times: NDArray[np.float64]
    """Of the states (s), increasing, shape (F,)."""
    qpos: NDArray[np.float64]
    """Positions of the whole model, shape (F, nq)."""
    drones: list[str]
    """Names of the bodies that are drones, in the order of the log."""
    targets: NDArray[np.float64] | None
    """Their target positions (m), NaN where there is none, shape (F, N, 3)."""
    painted: frozenset[str]
    """Those of them whose color the user chose."""
    warnings: tuple[str, ...] = ()
    """What is not as it was in the flight, one sentence each."""


def stage_of(log: FlightLog) -> Stage:
    """Return the stage of a flight.

    Raises:
        CrazychoirError: If the log has no positions, or its scene cannot be built here.
    """
    try:
        return _stage_of(log)
    except (TypeError, AttributeError, KeyError, ValueError) as error:
        raise CrazychoirError(f"the log does not describe its scene and drones: {error}") from error


def _stage_of(log: FlightLog) -> Stage:
    is_new = np.diff(log.time, prepend=-np.inf) > 0.0
    positions, quaternions = _poses(log)
    positions, quaternions = positions[is_new], quaternions[is_new]
    recipe = log.journal.recipe if log.journal is not None else log.metadata.get("stage", {})
    known = {str(entry.get("id")): entry for entry in recipe.get("drones", ())}
    platforms, has_world = log.metadata.get("drones", {}), log.journal is not None
    configs = [
        _config(name, known.get(name, {}), platforms.get(name, {}), at, has_world and name not in platforms)
        for name, at in zip(log.drone_ids, positions[0], strict=True)
    ]
    register_plugin()
    changed = scene_differs(recipe)
    model = build_stage(configs, recipe.get("scene", log.metadata.get("scene", "arena")))
    qpos = np.tile(model.qpos0, (len(positions), 1))
    for k, name in enumerate(log.drone_ids):
        start = int(model.jnt_qposadr[model.body_jntadr[model.body(name).id]])
        qpos[:, start : start + 3] = positions[:, k]
        qpos[:, start + 3 : start + 7] = quaternions[:, k]
    columns = scenery_columns(model, log.drone_ids)
    warnings = [changed] if changed else []
    if log.scenery is not None and log.scenery.shape == (len(log.time), len(columns)):
        qpos[:, columns] = log.scenery[is_new]
    elif log.scenery is not None:
        warnings.append("what moved beside the drones is not in this scene, and stands still")
    painted = frozenset(config.id for config in configs if config.color is not None)
    reference = log.reference()
    targets = None if reference is None else reference[is_new]
    return Stage(model, log.time[is_new], qpos, list(log.drone_ids), targets, painted, tuple(warnings))


def _config(
    name: str, entry: Mapping[str, Any], about: Mapping[str, Any], at: Sequence[float], is_real: bool
) -> DroneConfig:
    """Return how a drone looks."""
    looks = {key: entry[key] for key in _LOOKS if key in entry}
    looks.setdefault("platform", about.get("platform", "cf2"))
    if looks["platform"] not in VEHICLES:
        looks["platform"] = "cf2"
    place = [float(value) for value in at]
    if is_real:
        looks["color"] = GREEN
    looks.setdefault("position", place if np.isfinite(place).all() else (0.0, 0.0, 0.0))
    return DroneConfig(**{**looks, "id": name})


def _poses(log: FlightLog) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions (m), shape (T, N, 3), and quaternions wxyz, (T, N, 4): the truth, or what drones believed.

    A pose that is not known is that of the sample before.
    """
    if not len(log.time):
        raise CrazychoirError("the log has no samples, and nothing to show")
    for group in ("sim", "stateEstimate"):
        positions = log.stack(*(f"{group}.{axis}" for axis in "xyz"))
        angles = log.stack(*(f"{group}.{axis}" for axis in ("roll", "pitch", "yaw")))
        if positions is not None:
            break
    else:
        raise CrazychoirError("the log has neither sim.x, y, z nor stateEstimate.x, y, z")
    if angles is None:
        angles = np.zeros_like(positions)
    known = np.isfinite(np.concatenate([positions, angles], axis=-1)).all(axis=-1)
    last = np.maximum.accumulate(np.where(known, np.arange(len(known))[:, None], 0), axis=0)
    drones = np.arange(known.shape[1])
    positions, angles = np.nan_to_num(positions[last, drones]), np.nan_to_num(angles[last, drones])
    # the pitch of the log is positive for a nose that rises
    quaternions = quaternion_xyzw(np.radians(angles * np.array([1.0, -1.0, 1.0])))
    return positions, np.roll(quaternions, 1, axis=-1)


def scenery_columns(model: mujoco.MjModel, drones: Collection[str]) -> NDArray[np.intp]:
    """Return the columns of ``qpos`` that belong to no drone of these names."""
    own = np.zeros(model.nq, dtype=bool)
    for name in drones:
        joint = int(model.body_jntadr[model.body(name).id])
        own[model.jnt_qposadr[joint] : model.jnt_qposadr[joint] + 7] = True
    return np.flatnonzero(~own)


def footprints(model: mujoco.MjModel) -> list[tuple[NDArray[np.float64], tuple[float, float, float]]]:
    """Return what stands still in a scene, as the eight corners of a box around each part and its color.

    Floors and other endless planes are left out.

    Returns:
        Corners (m, world), shape (8, 3) in the order of the bits x, y, z, and red, green, blue in [0, 1].
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    signs = np.array([[(k >> axis & 1) * 2 - 1 for axis in range(3)] for k in range(8)], float)
    found = []
    for geom in range(model.ngeom):
        body = model.geom_bodyid[geom]
        is_solid = model.geom_contype[geom] or model.geom_conaffinity[geom]
        if model.body_weldid[body] != 0 or model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE or not is_solid:
            continue
        center, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        corners = data.geom_xpos[geom] + (center + signs * half) @ data.geom_xmat[geom].reshape(3, 3).T
        material = model.geom_matid[geom]
        rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        red, green, blue = rgba[:3].tolist()
        found.append((corners, (red, green, blue)))
    return found
