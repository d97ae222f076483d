"""What is drawn over a scene for people: names, ghosts at the targets of drones, links, marks and trails."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.recording.marks import COLORS, Mark

_GHOST_RADIUS_M = 0.025
_GHOST_ALPHA = 0.35
_BALL_RADIUS_M = 0.05
_BALL_ALPHA = 0.6
_NAME_PLACE = np.array([0.0, 0.0, 0.07])  # [m], over the drone
_LINK_RADIUS_M = 0.004
_LINK_WIDTH_PX = 1.5
_LINK_COLOR = np.array([0.15, 0.2, 0.3, 0.45], dtype=np.float32)
_DISK_RADIUS_M = 0.1
_NOBODY = np.array([0.55, 0.58, 0.62])
_NO_ROTATION = np.eye(3).ravel()
_ZERO = np.zeros(3)
_MAX_LINES = 900  # of trails in one scene, of all drones together: each costs 5 us
_MAX_PER_DRONE = 60
_DOWN = np.array([0.0, 0.0, -1.0])
_NOT_DRONES = np.array([1, 1, 0, 0, 1, 1], np.uint8)  # groups of geoms: 2 is only seen, 3 are hulls of drones
_SHADOW_REACH_M = 4.0
_SHADOW_RINGS = (0.6, 0.85, 1.1)
_FEW = 8  # drones up to which shadows have soft edges
_TRAIL_WIDTH_PX = 2.5


def add_ghosts(scene: mujoco.MjvScene, targets: NDArray[np.float64], colors: NDArray[np.float64]) -> None:
    """Add a translucent ball at the target of each drone, as far as there is room.

    Args:
        scene: Scene to add to.
        targets: Where (m, world frame), shape (N, 3); NaN draws none.
        colors: Color of each drone, shape (N, 3).
    """
    for target, color in zip(targets, colors, strict=True):
        geom = _next(scene)
        if geom is None:
            return
        place_ghost(geom, target, color)


def place_ghost(geom: mujoco.MjvGeom, target: NDArray[np.float64], color: NDArray[np.float64]) -> None:
    """Make a geom the ghost of a drone; a target of NaN makes it invisible."""
    known = bool(np.isfinite(target).all())
    rgba = np.array([*color, _GHOST_ALPHA if known else 0.0], dtype=np.float32)
    size = np.full(3, _GHOST_RADIUS_M if known else 1e-6)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_SPHERE, size, target if known else _ZERO, _NO_ROTATION, rgba)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR


def add_shadows(
    scene: mujoco.MjvScene, model: mujoco.MjModel, data: mujoco.MjData, bodies: NDArray[np.int32], radius: float
) -> None:
    """Add a soft dark disk under each drone, on whatever is there: far cheaper than shadows of light.

    Args:
        scene: Scene to add to.
        model: The world.
        data: Its state.
        bodies: The drones.
        radius: Of a drone (m).
    """
    hit = np.array([-1], np.int32)
    rings = _SHADOW_RINGS if len(bodies) <= _FEW else _SHADOW_RINGS[1:2]
    for body in bodies:
        place = data.xpos[body]
        height = mujoco.mj_ray(model, data, place, _DOWN, _NOT_DRONES, 1, int(body), hit)
        if not 0.0 <= height < _SHADOW_REACH_M:
            continue
        spread = 1.0 + 0.5 * height / _SHADOW_REACH_M
        for share in rings:
            geom = _next(scene)
            if geom is None:
                return
            rgba = np.array([0.05, 0.06, 0.08, 0.36 / len(rings) * (1.0 - height / _SHADOW_REACH_M)], dtype=np.float32)
            size = np.array([share * radius * spread, 0.0005, 0.0])
            above = place - np.array([0.0, 0.0, height - 0.004 - 0.0015 * (1.0 - share)])
            mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_CYLINDER, size, above, _NO_ROTATION, rgba)
            geom.category = mujoco.mjtCatBit.mjCAT_DECOR


def add_links(scene: mujoco.MjvScene, positions: NDArray[np.float64], pairs: Sequence[tuple[int, int]]) -> None:
    """Add a thin line between drones that talk to each other, as far as there is room.

    Args:
        scene: Scene to add to.
        positions: Where the drones are (m, world frame), shape (N, 3).
        pairs: Their numbers.
    """
    color = _LINK_COLOR.copy()
    color[3] = np.clip(8.0 / max(1, len(pairs)), 0.12, 0.45)  # many are a web that shall not hide the drones
    for first, second in pairs:
        geom = _next(scene)
        if geom is None:
            return
        _connect(geom, positions[first], positions[second], color, _LINK_WIDTH_PX)


def _connect(
    geom: mujoco.MjvGeom,
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    color: NDArray[np.float32],
    width_px: float,
) -> None:
    """Make a geom a line from point to point."""
    line = mujoco.mjtGeom.mjGEOM_LINE
    mujoco.mjv_initGeom(geom, line, _ZERO, _ZERO, _NO_ROTATION, color)
    mujoco.mjv_connector(geom, line, width_px, start, end)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR


def add_marks(scene: mujoco.MjvScene, marks: Iterable[Mark], colors: NDArray[np.float64]) -> None:
    """Add a ball or a disk for each mark, and a thin rod to the point that belongs to it.

    What there is no room for is left out.

    Args:
        scene: Scene to add to.
        marks: Those that are there at present.
        colors: Color of each drone, shape (N, 3).
    """
    for mark in marks:
        add = _add_ball if mark.kind in COLORS else _add_disk
        if not add(scene, mark, colors):
            return


def _add_ball(scene: mujoco.MjvScene, mark: Mark, _: NDArray[np.float64]) -> bool:
    """Add a translucent ball in the color of its kind; tell whether there was room."""
    geom = _next(scene)
    if geom is None:
        return False
    text = COLORS[mark.kind]
    color = [int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    rgba = np.array([*color, _BALL_ALPHA], dtype=np.float32)
    size = np.full(3, _BALL_RADIUS_M)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_SPHERE, size, mark.position, _NO_ROTATION, rgba)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR
    return True


def _add_disk(scene: mujoco.MjvScene, mark: Mark, colors: NDArray[np.float64]) -> bool:
    """Add a disk in the color of its drone, with its rod; tell whether there was room."""
    disk = _next(scene)
    if disk is None:
        return False
    rgb = _NOBODY if mark.drone is None else colors[mark.drone]
    rgba = np.array([*rgb, 0.85], dtype=np.float32)
    size = np.array([_DISK_RADIUS_M, 0.004, 0.0])
    place = mark.position + np.array([0.0, 0.0, 0.006])
    mujoco.mjv_initGeom(disk, mujoco.mjtGeom.mjGEOM_CYLINDER, size, place, _NO_ROTATION, rgba)
    disk.category = mujoco.mjtCatBit.mjCAT_DECOR
    if mark.link is None:
        return True
    rod = _next(scene)
    if rod is None:
        return False
    kind = mujoco.mjtGeom.mjGEOM_CAPSULE
    mujoco.mjv_initGeom(rod, kind, np.zeros(3), np.zeros(3), _NO_ROTATION, np.array([*rgb, 0.4], np.float32))
    up = np.array([0.0, 0.0, 0.01])
    mujoco.mjv_connector(rod, kind, _LINK_RADIUS_M, mark.position + up, mark.link + up)
    rod.category = mujoco.mjtCatBit.mjCAT_DECOR
    return True


def add_names(scene: mujoco.MjvScene, positions: NDArray[np.float64], names: Sequence[str]) -> None:
    """Add a name above each drone, as far as there is room.

    Args:
        scene: Scene to add to.
        positions: Where the drones are (m, world frame), shape (N, 3).
        names: Their names.
    """
    for position, name in zip(positions, names, strict=True):
        geom = _next(scene)
        if geom is None:
            return
        place_name(geom, position, name)


def place_name(geom: mujoco.MjvGeom, position: NDArray[np.float64], name: str) -> None:
    """Make a geom the name of a drone that is at a position."""
    above = np.where(np.isfinite(position), position, 0.0) + _NAME_PLACE
    color = np.array([0.1, 0.1, 0.1, 1.0], dtype=np.float32)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_LABEL, np.full(3, 0.01), above, _NO_ROTATION, color)
    geom.category = mujoco.mjtCatBit.mjCAT_DECOR
    # a longer one would not fit into the geom
    geom.label = name[:99] if np.isfinite(position).all() else ""


def _next(scene: mujoco.MjvScene) -> mujoco.MjvGeom | None:
    if scene.ngeom >= scene.maxgeom:
        return None
    scene.ngeom += 1
    return scene.geoms[scene.ngeom - 1]


def drone_colors(model: mujoco.MjModel, bodies: Sequence[int] | NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the color of each drone, that of its geom `accent`, shape (N, 3)."""
    colors = np.tile([0.95, 0.45, 0.10], (len(bodies), 1))
    row = {int(body): k for k, body in enumerate(bodies)}
    for geom, body in enumerate(model.geom_bodyid):
        name = model.geom(geom).name if int(body) in row else ""
        if name == "accent" or name.endswith("/accent"):
            material = model.geom_matid[geom]
            # the color of a geom wins over that of its material once it has been changed
            own = material < 0 or not np.array_equal(model.geom_rgba[geom], np.array([0.5, 0.5, 0.5, 1.0], np.float32))
            colors[row[int(body)]] = (model.geom_rgba[geom] if own else model.mat_rgba[material])[:3]
    return colors


class Trails:
    """Draws where drones have been.

    Args:
        positions: Path of each drone (m, world frame), shape (F, N, 3).
        colors: Color of each drone, shape (N, 3).
        length: How many frames a trail reaches back.
    """

    def __init__(self, positions: NDArray[np.float64], colors: NDArray[np.float64], length: int) -> None:
        self._positions = positions
        self._colors = np.column_stack([colors, np.ones(len(colors))]).astype(np.float32)
        drones = max(1, positions.shape[1])
        self._lines = min(length, _MAX_PER_DRONE, _MAX_LINES // drones)
        self._length = length

    def draw(self, scene: mujoco.MjvScene, frame: int) -> None:
        """Add the trails that end at *frame* to a scene."""
        # one grid for all frames, so that the bends of a trail stay where they are while it moves on
        if self._lines < 1:
            return
        stride = -(-self._length // self._lines)
        corners = [k for k in range(frame - frame % stride, max(-1, frame - self._length - 1), -stride)]
        corners = corners if corners and corners[0] == frame else [frame, *corners]
        for age, (new, old) in enumerate(itertools.pairwise(corners)):
            alpha = 0.9 * (1.0 - age / len(corners))
            for drone, color in enumerate(self._colors):
                self._line(scene, self._positions[new, drone], self._positions[old, drone], color, alpha)

    def _line(
        self,
        scene: mujoco.MjvScene,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        color: NDArray[np.float32],
        alpha: float,
    ) -> None:
        if scene.ngeom >= scene.maxgeom or not np.isfinite(start + end).all():
            return
        color[3] = alpha
        _connect(scene.geoms[scene.ngeom], start, end, color, _TRAIL_WIDTH_PX)
        scene.ngeom += 1
