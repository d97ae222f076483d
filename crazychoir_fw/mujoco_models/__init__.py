"""MJCF of the vehicles and scenes: `model_path("cf2")`, `model_path("arena")`."""

from pathlib import Path

from crazychoir_fw.common.shared_folders import shared_folder

__all__ = ["SCENES", "VEHICLES", "model_path"]

_FOLDER = shared_folder("mujoco_models")

VEHICLES = {"cf2": "crazyflie_2.xml", "cf21bl": "crazyflie_21bl.xml"}
"""Platform to MJCF file: Crazyflie 2.1+ and Crazyflie 2.1 Brushless."""

SCENES = {
    "arena": "scene_arena.xml",
    "flight_lab": "scene_flight_lab.xml",
    "gates": "scene_gates.xml",
    "pillars": "scene_pillars.xml",
    "room": "scene_room.xml",
}
"""Name to MJCF file of the worlds to fly in; they hold no drones."""


def model_path(name: str) -> Path:
    """Return the MJCF file of a platform or scene.

    Args:
        name: A key of `VEHICLES` or `SCENES`.

    Raises:
        ValueError: If there is no such model.
    """
    files = {**VEHICLES, **SCENES}
    if name not in files:
        raise ValueError(f"no model {name!r}; there are {', '.join(files)}")
    return _FOLDER / files[name]
