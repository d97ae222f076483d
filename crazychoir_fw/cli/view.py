"""The window of `crazychoir fly --view`: the flight in MuJoCo's viewer, paced to real time."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from crazychoir_fw.errors import CrazychoirError, StateError

if TYPE_CHECKING:
    from mujoco import MjvCamera

    from crazychoir_fw.mission.runner import Observer, Progress
    from crazychoir_fw.simulation import World

FRAME = 1.0 / 60.0  # [s]


def _look_at_drones(camera: "MjvCamera", world: "World") -> None:
    """Put the camera where it sees the whole swarm and a meter of air above it."""
    positions = world.positions()
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    camera.lookat[:] = middle[0], middle[1], 0.5
    camera.distance = 1.8 + 1.5 * float(abs(positions - middle).max())
    camera.azimuth, camera.elevation = 120.0, -20.0


@contextmanager
def open_window() -> Iterator["Observer"]:
    """Yield an observer that shows the flight; the window opens with its first sample.

    Raises:
        CrazychoirError: If the viewer is not installed or there is no display.
        StateError: From the observer, when the window is closed during the flight.
    """
    try:
        import mujoco.viewer
    except ImportError:
        raise CrazychoirError("--view needs MuJoCo's viewer: run pip install 'crazychoir-fw[viz]'") from None

    viewer = None
    wall_start = last_frame = 0.0

    def show(world: "World", progress: "Progress") -> None:
        nonlocal viewer, wall_start, last_frame
        if viewer is None:
            viewer = mujoco.viewer.launch_passive(world.model, world.data, show_left_ui=False, show_right_ui=False)
            _look_at_drones(viewer.cam, world)
            wall_start = time.perf_counter() - progress.sim_seconds
        if not viewer.is_running():
            raise StateError("the window was closed before the end of the flight")
        if progress.sim_seconds - last_frame >= FRAME:
            last_frame = progress.sim_seconds
            viewer.sync()
        # the one place where simulated time waits for the clock on the wall
        time.sleep(max(0.0, progress.sim_seconds - (time.perf_counter() - wall_start)))

    try:
        yield show
    finally:
        if viewer is not None:
            viewer.close()
