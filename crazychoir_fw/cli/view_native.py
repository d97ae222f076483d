"""MuJoCo's window, with trails, ghosts and names over the drones."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.cli.pace import FramePacer
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.recording.likeness import Likeness
from crazychoir_fw.recording.overlays import drone_colors, place_ghost, place_name
from crazychoir_fw.simulation.targets import Targets

if TYPE_CHECKING:
    from collections.abc import Callable

    from crazychoir_fw.flight.engine import Observer, Progress
    from crazychoir_fw.simulation import World

_FRAME_S = 1.0 / 60.0
_TRAIL_S = 4.0
_MAX_LINES = 1500  # of all drones together: what a frame has time for
_MAX_PER_DRONE = 40
_LINE, _LINE_PX = mujoco.mjtGeom.mjGEOM_LINE, 2.5
KEYS = "T trails, G ghosts, N names"


@contextmanager
def open_window(say: Callable[[str], None]) -> Iterator[Observer]:
    """Yield an observer that shows the flight in a window; it opens with the first sample.

    Args:
        say: Called with one line about what was opened.

    Raises:
        CrazychoirError: If the window cannot be opened.
        StateError: From the observer, when the window is closed during the flight.
    """
    try:
        import mujoco.viewer
    except ImportError as error:
        raise CrazychoirError(f"--view native: MuJoCo's viewer cannot be imported ({error})") from None

    viewer = overlay = likeness = None
    threads: list[threading.Thread] = []
    pace = FramePacer(_FRAME_S)

    def show(world: World, progress: Progress) -> None:
        nonlocal viewer, overlay, likeness
        if viewer is None:
            switches, likeness = Switches(), Likeness(world.model)
            before = set(threading.enumerate())
            # on a copy: it computes forces with what it is given, and a mouse can pull at drones
            viewer = mujoco.viewer.launch_passive(
                world.model,
                likeness.update(world.data),
                show_left_ui=False,
                show_right_ui=False,
                key_callback=switches.press,
            )
            threads.extend(set(threading.enumerate()) - before)
            _look_at_drones(viewer.cam, world)
            overlay = Overlay(world, viewer.user_scn, switches)
            say(f"MuJoCo's window is open (keys: {KEYS}); closing it ends the flight")
        if not viewer.is_running():
            raise StateError("the window was closed before the end of the flight")
        if pace.is_frame(progress.sim_seconds):
            with viewer.lock():
                likeness.update(world.data)
                overlay.draw()
            viewer.sync()
        pace.wait(progress.sim_seconds)

    try:
        yield show
    finally:
        if viewer is not None:
            viewer.close()
            # they still let go of OpenGL, and a process that ends meanwhile crashes
            for thread in threads:
                thread.join(timeout=10.0)


class Switches:
    """What the keys of the window switch on and off."""

    def __init__(self) -> None:
        self.trails = self.ghosts = self.names = True

    def press(self, key: int) -> None:
        """React to a key, by its number in GLFW."""
        for letter, name in (("T", "trails"), ("G", "ghosts"), ("N", "names")):
            if key == ord(letter):
                setattr(self, name, not getattr(self, name))


class Overlay:
    """Trails, ghosts and names in a scene that stays from frame to frame, so that little changes in each.

    Each drone has a ring of lines: the newest is drawn from its last corner to where it is, and when a corner is
    passed, the oldest becomes the newest.

    Args:
        world: The world.
        scene: What the window draws over it.
        switches: What is to be seen.
    """

    def __init__(self, world: World, scene: mujoco.MjvScene, switches: Switches) -> None:
        self._world = world
        self._scene = scene
        self._switches = switches
        self._targets = Targets(world.drones)
        self._names = [drone.id for drone in world.drones]
        count = len(self._names)
        self._colors = drone_colors(world.model, [world.model.body(name).id for name in self._names])
        self._lines = max(1, min(_MAX_PER_DRONE, _MAX_LINES // count, (scene.maxgeom - 2 * count) // count))
        self._corner_s = _TRAIL_S / self._lines
        self._next_corner = -np.inf
        self._corners = world.positions()
        self._newest = 0
        everything = list(itertools.islice(scene.geoms, (2 + self._lines) * count))
        self._ghosts, self._labels = everything[:count], everything[count : 2 * count]
        self._trails = [everything[2 * count + k * count : 2 * count + (k + 1) * count] for k in range(self._lines)]
        self._rgba = [[geom.rgba for geom in geoms] for geoms in self._trails]
        for geoms in self._trails:
            for geom, place, color in zip(geoms, self._corners, self._colors, strict=True):
                rgba = np.array([*color, 1.0], dtype=np.float32)
                mujoco.mjv_initGeom(geom, _LINE, np.zeros(3), np.zeros(3), np.zeros(9), rgba)
                mujoco.mjv_connector(geom, _LINE, _LINE_PX, place, place)

    def draw(self) -> None:
        """Bring the overlay up to the present instant."""
        positions = self._world.positions()
        self._draw_trails(positions)
        targets = self._targets.positions()
        if not self._switches.ghosts:
            targets[:] = np.nan
        for geom, target, color in zip(self._ghosts, targets, self._colors, strict=True):
            place_ghost(geom, target, color)
        for geom, position, name in zip(self._labels, positions, self._names, strict=True):
            place_name(geom, position, name if self._switches.names else "")
        count = len(positions)
        self._scene.ngeom = count * (2 + (self._lines if self._switches.trails else 0))

    def _draw_trails(self, positions: NDArray[np.float64]) -> None:
        """Draw the newest line of each drone; from time to time, take the oldest as a new one."""
        self._draw_newest(positions)
        if self._world.time >= self._next_corner:
            self._next_corner = self._world.time + self._corner_s
            self._newest = (self._newest + 1) % self._lines
            self._corners = positions
            for age in range(self._lines):
                alpha = 0.9 * (1.0 - age / self._lines)
                for rgba in self._rgba[self._newest - age]:
                    rgba[3] = alpha
            self._draw_newest(positions)

    def _draw_newest(self, positions: NDArray[np.float64]) -> None:
        for geom, corner, place in zip(self._trails[self._newest], self._corners, positions, strict=True):
            mujoco.mjv_connector(geom, _LINE, _LINE_PX, corner, place)


def _look_at_drones(camera: mujoco.MjvCamera, world: World) -> None:
    """Put the camera where it sees the whole swarm and a meter of air above it."""
    positions = world.positions()
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2
    camera.lookat[:] = middle[0], middle[1], 0.5
    camera.distance = 1.8 + 1.5 * float(abs(positions - middle).max())
    camera.azimuth, camera.elevation = 120.0, -20.0
