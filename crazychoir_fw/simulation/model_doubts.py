"""What of a model compiles and is hardly meant: air that counts twice, drones with nothing below them."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

_LISTED = 3


def model_doubts(model: mujoco.MjModel, data: mujoco.MjData, drones: Sequence[str]) -> list[str]:
    """Return sentences about a model and the bodies of its drones."""
    found = []
    for name in ("density", "viscosity"):
        value = float(getattr(model.opt, name))
        if value > 0.0:
            found.append(
                f'<option {name}="{value:g}">: MuJoCo adds a drag of its own to that of the Crazyflies, which know '
                f"their air; leave {name} at 0"
            )
    below = [name for name in drones if not _is_above_something(model, data, name)]
    if below:
        more = f" and {len(below) - _LISTED} more" if len(below) > _LISTED else ""
        found.append(
            f"nothing is below {', '.join(below[:_LISTED])}{more}: they fall without end; a floor is "
            '<geom type="plane" size="0 0 .1"/>'
        )
    return found


def _is_above_something(model: mujoco.MjModel, data: mujoco.MjData, drone: str) -> bool:
    body, hit = model.body(drone).id, np.zeros(1, np.int32)
    start = np.array(data.xpos[body])
    return bool(mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, body, hit) >= 0.0)
