"""How to build a world again, as plain data for a file: its drones, scene and seed, and what they were."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.mujoco_models import SCENES
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.scene_file import is_inline

_ABSENT = ("motor_ctrl", "motor_ctrl_properties")
"""The fields of `DroneConfig` that a replay leaves out: what a plugin asked of its drone is in the journal."""


def write_recipe(
    drones: Sequence[DroneConfig], scene: str | Path, seed: int, fingerprint: Mapping[str, str]
) -> dict[str, Any]:
    """Return the recipe of a world; what JSON can hold.

    Args:
        drones: The drones as the user configured them, without those that the scene brings.
        scene: Word, file, or the text of a scene that stands in a mission.
        seed: Seed of all noise.
        fingerprint: What came out (`crazychoir_fw.simulation.fingerprint`).
    """
    is_file = str(scene) not in SCENES and not is_inline(scene)
    return {
        "drones": [_plain_config(drone) for drone in drones],
        "scene": str(Path(scene).absolute()) if is_file else str(scene),
        "scene_sha256": _sha256(Path(scene)) if is_file else None,
        "seed": seed,
        "fingerprint": dict(fingerprint),
    }


def read_drones(recipe: Mapping[str, Any]) -> list[DroneConfig]:
    """Return the drones of a recipe, without plugins of the user's.

    Raises:
        CrazychoirError: If this version does not know how to build them.
    """
    known = {field.name for field in dataclasses.fields(DroneConfig)}
    if "drones" not in recipe:
        raise CrazychoirError("the recipe of the world names no drones")
    drones = []
    for config in recipe["drones"]:
        unknown = sorted(set(config) - known)
        if unknown:
            raise CrazychoirError(f"{config.get('id')}: this version knows nothing of {', '.join(unknown)}")
        drones.append(DroneConfig(**{key: value for key, value in config.items() if key not in _ABSENT}))
    return drones


def programs_of(recipe: Mapping[str, Any]) -> list[str]:
    """Return the files of C that a world of the recipe compiles and runs: the apps of its drones."""
    apps = [drone.get("app", ()) for drone in recipe.get("drones", ()) if isinstance(drone, Mapping)]
    each = [str(path) for app in apps for path in ([app] if isinstance(app, str) else app)]
    return sorted(set(each))


def scene_differs(recipe: Mapping[str, Any]) -> str | None:
    """Return what is wrong with the file of the scene, as a sentence, or None."""
    if recipe.get("scene_sha256") is None:
        return None
    scene = Path(recipe["scene"])
    if not scene.is_file():
        return f"the scene {scene} is gone"
    return None if _sha256(scene) == recipe["scene_sha256"] else f"the scene {scene} has changed since the flight"


def _sha256(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _plain_config(drone: DroneConfig) -> dict[str, Any]:
    config = {field.name: _plain(getattr(drone, field.name)) for field in dataclasses.fields(drone)}
    app = [drone.app] if isinstance(drone.app, str | Path) else drone.app
    config["app"] = [str(Path(path).absolute()) for path in app]
    # a version that reads the recipe need not know fields with their default value
    return {
        field.name: config[field.name]
        for field in dataclasses.fields(drone)
        if field.name == "id" or config[field.name] != _plain(_default(field))
    }


def _default(field: dataclasses.Field[Any]) -> Any:
    return field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default


def _plain(value: Any) -> Any:
    """Return a value of a configuration as JSON can hold it."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, Path):
        return str(value.absolute())
    if inspect.isclass(value):
        return f"{value.__module__}:{value.__qualname__}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # numbers and arrays of NumPy
        return _plain(value.tolist())
    return value
