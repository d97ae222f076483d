"""A page on this machine that shows a flight while it is flown: drones, trails, ghosts, names, and the room.

MuJoCo Studio has a web viewer as well. It runs the whole model in the browser, where an engine plugin that it does not
know ends it, and it listens on all interfaces of the machine; so viser draws the page here.
"""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.cli.pace import FramePacer
from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.recording.likeness import Likeness
from crazychoir_fw.recording.overlays import drone_colors
from crazychoir_fw.simulation.targets import Targets

if TYPE_CHECKING:
    import viser

    from crazychoir_fw.flight.engine import Observer, Progress
    from crazychoir_fw.simulation import World

HOST = "127.0.0.1"
PORT = 8080  # or the next free one
PATIENCE_S = 60.0
"""How long a flight waits for somebody who opens the page (s)."""
_FRAME_S = 1.0 / 30.0
_TRAIL_S, _CORNER_S = 4.0, 0.1
_MAX_LINES = 4000  # of all drones together
_MAX_NAMES = 200
_NAME_PLACE = np.array([0.0, 0.0, 0.07])  # [m], over the drone
_GHOST_RADIUS_M = 0.025


@contextmanager
def open_page(say: Callable[[str], None], patience_s: float = PATIENCE_S) -> Iterator[Observer]:
    """Yield an observer that shows the flight on a page; who closes the page misses it, and the flight goes on.

    Args:
        say: Called with one line that has the address.
        patience_s: How long the first sample waits until somebody has opened the page (s).

    Raises:
        MissingLibraryError: If viser is not installed.
    """
    try:
        import viser
    except ImportError:
        raise MissingLibraryError(
            "--view: the page needs viser: run pip install 'crazychoir-fw[viz]' (or open a display for MuJoCo's window)"
        ) from None

    _silence()
    server = viser.ViserServer(host=HOST, port=PORT, label="crazychoir", verbose=False)
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    page: Page | None = None
    pace = FramePacer(_FRAME_S)

    def show(world: World, progress: Progress) -> None:
        nonlocal page
        if page is None:
            page = Page(server, world)
            page.draw(progress.sim_seconds)
            say(
                f"Watch at http://{HOST}:{server.get_port()}/ (this machine only); "
                f"the flight begins when the page is open, or in {patience_s:.0f} s"
            )
            _wait_for_somebody(server, patience_s)
        if pace.is_frame(progress.sim_seconds):
            page.draw(progress.sim_seconds)
        pace.wait(progress.sim_seconds)

    try:
        yield show
    finally:
        if page is not None:
            page.say("The flight is over.")
            time.sleep(0.1)  # until the page has heard of it
        server.stop()


def _silence() -> None:
    """Keep viser from printing, also at the end of the process: one line says where the page is."""
    import rich

    # the console of rich.print, which viser uses and this package does not
    rich.get_console().quiet = True
    # a browser that goes away while it connects is no error
    logging.getLogger("websockets").setLevel(logging.CRITICAL)


def _wait_for_somebody(server: viser.ViserServer, patience_s: float) -> None:
    start = time.perf_counter()
    while not server.get_clients() and time.perf_counter() - start < patience_s:
        time.sleep(0.05)
    if server.get_clients():
        time.sleep(0.5)  # until the page has drawn what it got


class Page:
    """What the page shows of one world.

    Args:
        server: Server of the page.
        world: The world.
    """

    def __init__(self, server: viser.ViserServer, world: World) -> None:
        self._server = server
        self._world = world
        self._likeness = Likeness(world.model)
        self._targets = Targets(world.drones)
        self._names = [drone.id for drone in world.drones]
        bodies = [int(world.model.body(name).id) for name in self._names]
        self._addresses = np.array([drone.qpos_address for drone in world.drones])
        # lines and ghosts take amounts of light, not those of a screen
        self._light = (255 * drone_colors(world.model, bodies) ** 2.2).astype(np.uint8)
        self._trails: deque[NDArray[np.float64]] = deque(maxlen=_corners(len(bodies)))
        self._next_corner = self._next_names = self._next_text = -1.0
        self._build_controls()
        self._batches = self._build_drones(bodies)
        self._moving = self._build_room(set(bodies))
        self._build_overlays()
        self._place_camera()

    # ---------------------------------------------------------------- what is made once

    def _build_controls(self) -> None:
        gui = self._server.gui
        self._text = gui.add_markdown("getting ready")
        self._show_trails = gui.add_checkbox("Trails", True)
        self._show_ghosts = gui.add_checkbox("Ghosts: where drones are told to be", True)
        self._show_names = gui.add_checkbox("Names", True)

    def _build_drones(self, bodies: list[int]) -> list[tuple[NDArray[np.intp], Any]]:
        from crazychoir_fw.cli.web_scene import drone_batches

        handles = []
        for number, batch in enumerate(drone_batches(self._world.model, bodies)):
            name, places = f"/drones/{number}", np.zeros((len(batch.drones), 3))
            attitudes = np.tile([1.0, 0.0, 0.0, 0.0], (len(batch.drones), 1))
            if batch.colors is None:
                handle = self._server.scene.add_batched_meshes_trimesh(name, batch.mesh, attitudes, places)
            else:
                handle = self._server.scene.add_batched_meshes_simple(
                    name, batch.mesh.vertices, batch.mesh.faces, attitudes, places, batched_colors=batch.colors
                )
            handles.append((batch.drones, handle))
        return handles

    def _build_room(self, drones: set[int]) -> list[tuple[int, Any]]:
        """Draw everything but the drones. Returns the bodies that may move, with their handles."""
        from crazychoir_fw.cli.web_scene import body_mesh

        model, data = self._world.model, self._likeness.update(self._world.data)
        self._server.scene.set_up_direction("+z")
        # shadows take most of the time of a browser without a graphics card
        self._server.scene.configure_default_lights(cast_shadow=False)
        # squares of 1 m, a hair over the floor
        self._server.scene.add_grid("/grid", 40.0, 40.0, cell_size=1.0, section_size=5.0, position=(0.0, 0.0, 2e-3))
        moving = []
        for body in set(range(model.nbody)) - drones:
            mesh = body_mesh(model, body)
            if mesh is None:
                continue
            handle = self._server.scene.add_mesh_trimesh(
                f"/room/{body}", mesh, position=data.xpos[body], wxyz=data.xquat[body]
            )
            if model.body_weldid[body] != 0 or model.body_mocapid[body] >= 0:
                moving.append((body, handle))
        return moving

    def _build_overlays(self) -> None:
        from trimesh.creation import icosphere

        scene, count = self._server.scene, len(self._names)
        ball = icosphere(2, _GHOST_RADIUS_M)
        self._ghosts = scene.add_batched_meshes_simple(
            "/ghosts",
            ball.vertices,
            ball.faces,
            np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            np.zeros((count, 3)),
            batched_scales=np.full(count, 1e-6),
            batched_colors=self._light,
            opacity=0.4,
            cast_shadow=False,
        )
        self._lines = scene.add_line_segments(
            "/trails", np.zeros((1, 2, 3)), np.zeros((1, 2, 3), np.uint8), thickness=2.0, thickness_units="screen"
        )
        self._labels = [
            scene.add_label(f"/names/{name}", name, anchor="bottom-center") for name in self._names[:_MAX_NAMES]
        ]

    def _place_camera(self) -> None:
        positions = self._world.positions()
        middle = (positions.min(axis=0) + positions.max(axis=0)) / 2.0
        away = 1.4 + 1.2 * float(abs(positions - middle).max())
        camera = self._server.initial_camera
        camera.look_at = (middle[0], middle[1], 0.5)
        camera.position = (middle[0] + 0.5 * away, middle[1] - 0.85 * away, 0.5 + 0.45 * away)

    # ---------------------------------------------------------------- what changes

    def say(self, text: str) -> None:
        """Show a sentence beside the picture."""
        self._text.content = text

    def draw(self, seconds: float) -> None:
        """Show the present instant."""
        pose = self._world.data.qpos[self._addresses[:, None] + np.arange(7)]
        # a drone that was parked by the engine has finite numbers as well; one that has not is not sent
        pose = np.where(np.isfinite(pose).all(axis=1, keepdims=True), pose, [0.0, 0.0, -1e3, 1.0, 0.0, 0.0, 0.0])
        with self._server.atomic():
            for drones, handle in self._batches:
                handle.batched_positions, handle.batched_wxyzs = pose[drones, :3], pose[drones, 3:]
            data = self._likeness.update(self._world.data) if self._moving else None
            for body, handle in self._moving:
                handle.position, handle.wxyz = data.xpos[body], data.xquat[body]
            self._draw_ghosts()
            self._draw_trails(pose[:, :3], seconds)
            self._draw_names(pose[:, :3], seconds)
            if seconds >= self._next_text:
                self._next_text = seconds + 0.5
                self.say(f"{len(pose)} drones, {seconds:.1f} s")

    def _draw_ghosts(self) -> None:
        self._ghosts.visible = self._show_ghosts.value
        targets = self._targets.positions()
        known = np.isfinite(targets).all(axis=1)
        self._ghosts.batched_scales = np.where(known, 1.0, 1e-6)
        self._ghosts.batched_positions = np.where(known[:, None], targets, 0.0)

    def _draw_trails(self, positions: NDArray[np.float64], seconds: float) -> None:
        self._lines.visible = self._show_trails.value
        if seconds < self._next_corner:
            return
        self._next_corner = seconds + _TRAIL_S / (self._trails.maxlen or 1)
        self._trails.append(positions)
        if len(self._trails) < 2:
            return
        corners = np.array(self._trails)
        lines = np.stack([corners[:-1], corners[1:]], axis=2)  # (L, N, 2, 3)
        self._lines.points = lines.reshape(-1, 2, 3).astype(np.float32)
        self._lines.colors = np.broadcast_to(self._light[None, :, None], lines.shape).reshape(-1, 2, 3)

    def _draw_names(self, positions: NDArray[np.float64], seconds: float) -> None:
        if seconds < self._next_names:
            return
        # each name is a message of its own, so that many of them move less often
        self._next_names = seconds + (0.0 if len(self._labels) <= 20 else 0.2)
        for label, position in zip(self._labels, positions, strict=False):
            label.visible = self._show_names.value
            label.position = position + _NAME_PLACE


def _corners(drones: int) -> int:
    """Return how many corners a trail has, so that all of them together stay few."""
    return max(2, min(round(_TRAIL_S / _CORNER_S), _MAX_LINES // drones))
