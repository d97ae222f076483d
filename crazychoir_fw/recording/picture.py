"""One picture of a world."""

import itertools
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.overlays import add_ghosts, add_names, drone_colors
from crazychoir_fw.recording.renderer import Renderer
from crazychoir_fw.recording.shots import find_drone, find_shot, follow, shadowed


def picture(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    positions: NDArray[np.float64],
    *,
    camera: str = "follow",
    width: int = 960,
    height: int = 540,
    names: Sequence[str] | None = None,
    targets: NDArray[np.float64] | None = None,
) -> NDArray[np.uint8]:
    """Draw one instant of a world.

    Args:
        model: The world.
        data: Its state; kinematics must be up to date, as after a step.
        positions: Where the drones are (m, world frame), shape (N, 3): what `follow` looks at.
        camera: As of `film.film_flight`.
        width: Width of the picture (pixels).
        height: Height of the picture (pixels).
        names: Names of the drones to show, in the order of `positions`.
        targets: Their target positions (m, world frame), shown as ghosts, shape (N, 3).

    Returns:
        The picture, shape (height, width, 3).

    Raises:
        RenderingError: If there is no OpenGL on this machine.
        ValueError: If there is no such camera.
    """
    swarm_path = follow(positions[None], np.zeros(1), fovy_deg=model.vis.global_.fovy, aspect=width / height)
    view = find_shot(model, camera, swarm_path)(data, 0)
    with Renderer(model, width, height) as renderer:
        renderer.update(data, view)
        _move_shadows(renderer, *shadowed(view, swarm_path, 0))
        if names is not None:
            add_names(renderer.scene, positions, names)
            if targets is not None:
                bodies = [find_drone(model, name) for name in names]
                add_ghosts(renderer.scene, targets, drone_colors(model, bodies))
        return renderer.draw().copy()


def _move_shadows(renderer: Renderer, center: NDArray[np.float64], radius: float) -> None:
    """Bring the shadow map of directional lights to the swarm: it covers a square around the axis of the light."""
    renderer.drawer.shadowClip = max(1.5, 1.5 * radius + center[2])
    for light in itertools.islice(renderer.scene.lights, renderer.scene.nlight):
        if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL and light.castshadow and light.dir[2] < 0.0:
            above = max(light.pos[2], center[2] + radius)
            light.pos[:] = center - light.dir * ((above - center[2]) / -light.dir[2])
