"""MJCF of the vehicles and scenes: `model_path("crazyflie_2")`, `model_path("scene_arena")`."""

from pathlib import Path

__all__ = ["SCENES", "VEHICLES", "model_path"]

_FOLDER = Path(__file__).resolve().parent

VEHICLES = ("crazyflie_2", "crazyflie_21bl")
"""Airframes, one MJCF each: Crazyflie 2.1+ and Crazyflie 2.1 Brushless."""

SCENES = ("scene_arena", "scene_flight_lab")
"""Worlds to fly in, without drones."""


def model_path(name: str) -> Path:
    """Return the MJCF file of a vehicle or scene.

    Args:
        name: One of `VEHICLES` or `SCENES`; a scene may be named without `scene_`.

    Raises:
        ValueError: If there is no such model.
    """
    for known in (name, f"scene_{name}"):
        if known in VEHICLES or known in SCENES:
            return _FOLDER / f"{known}.xml"
    raise ValueError(f"no model {name!r}; there are {', '.join(VEHICLES + SCENES)}")
