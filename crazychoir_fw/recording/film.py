"""The film of a flight, from recorded states of a world and what explains them."""

from collections.abc import Callable, Sequence
from copy import copy
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.recording.colors import palette, rgb
from crazychoir_fw.recording.hud import RED, Hud
from crazychoir_fw.recording.lettering import Color, Labels, blend, text
from crazychoir_fw.recording.magnify import magnified
from crazychoir_fw.recording.overlays import Trails, add_ghosts, add_links, add_marks, add_shadows, drone_colors
from crazychoir_fw.recording.renderer import Renderer, in_picture
from crazychoir_fw.recording.shots import find_drone, find_shot, follow
from crazychoir_fw.recording.storyboard import Storyboard
from crazychoir_fw.recording.video import VideoWriter

MANY = 12
"""More drones than this have no names in a film, but for those with a note."""

LONGEST_S = 20.0
"""A film of a longer flight is played faster, if nothing else is asked for (s)."""

_LEADER, _FOLLOWER = (0.85, 0.1, 0.1), (0.1, 0.4, 0.85)
_GHOST_FROM_M = 0.04  # of a drone; a ghost that is nearer says nothing


def film_flight(
    model: mujoco.MjModel,
    qpos: ArrayLike,
    times: ArrayLike,
    path: Path,
    *,
    camera: str = "follow",
    width: int = 768,
    height: int = 432,
    fps: float = 25.0,
    speed: float = 1.0,
    trail_s: float = 3.0,
    drones: Sequence[str] | None = None,
    story: Storyboard | None = None,
    targets: ArrayLike | None = None,
    painted: frozenset[str] | None = None,
    magnify: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Film recorded states of a world.

    Args:
        model: The world; it is not changed.
        qpos: Recorded positions, shape (F, nq). States between them are interpolated.
        times: Instants of the states (s), shape (F,), increasing.
        path: The film, `.mp4`, `.gif` or `.webp`.
        camera: `follow` for a camera that keeps the swarm in the picture, `fpv:NAME` for the view from a drone,
            `chase:NAME` for one from behind it, else the name of a camera of the model.
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).
        fps: Pictures per second.
        speed: Seconds of flight per second of film.
        trail_s: Length of the lines behind the drones (s of flight); 0 for none. `fpv` has none.
        drones: Names of the bodies that are drones; by default those with an engine plugin, or else all free ones.
        story: What explains the flight: title, phases, faults, marks, links; None shows neither these nor names and
            clock.
        targets: Target positions of drones at each of the `times` (m, world), shape (F, N, 3), shown as ghosts;
            NaN where there is no target.
        painted: Drones that keep the color of the model, while the others get those of the plot; None is all.
        magnify: Whether small drones of a wide swarm are drawn larger than they are, up to three times.
        progress: Called after each picture with how many are drawn and how many there will be.

    Raises:
        RenderingError: If there is no OpenGL on this machine.
        ValueError: If the shapes do not fit or there is no such camera or drone.
    """
    recorded, instants = _checked_states(model, qpos, times)
    if not 0.0 < speed < np.inf:
        raise ValueError(f"speed {speed} is not positive")
    count = int((instants[-1] - instants[0]) * fps / speed) + 1
    wanted = instants[0] + np.arange(count) * speed / fps
    states = resample(model, recorded, instants, wanted)
    joints = _joints_of_drones(model, drones)
    told = _checked_targets(targets, len(joints), len(instants))
    if told is not None:
        told = told[np.clip(np.searchsorted(instants, wanted + 1e-9, side="right") - 1, 0, None)]
    length = 0 if camera.startswith("fpv:") else round(trail_s * fps / speed)
    model = _painted(model, joints, painted, None if story is None else story.leaders)
    shots = _Shots(model, joints, states, wanted, fps, camera, (width, height), magnify and camera == "follow")
    scenes = _Scenes(shots, story or Storyboard(), told, length)
    over = None if story is None else _Over(shots, story, (width, height), speed)

    with Renderer(shots.model, width, height) as renderer, VideoWriter(path, fps=fps) as film:
        # half of the time per picture without a graphics card; disks under the drones say more about where they are
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        for frame in range(count):
            scenes.compose(renderer, frame)
            picture = renderer.draw()
            if over is not None:
                over.draw(picture, renderer.scene, frame)
            film.write(picture)
            if progress is not None:
                progress(frame + 1, count)


class _Shots:
    """The states of a flight, and the camera that looks at them."""

    def __init__(
        self,
        model: mujoco.MjModel,
        joints: NDArray[np.int32],
        states: NDArray[np.float64],
        instants: NDArray[np.float64],
        fps: float,
        camera: str,
        size: tuple[int, int],
        magnify: bool,
    ) -> None:
        self.bodies = model.jnt_bodyid[joints]
        self.names = [model.body(int(body)).name for body in self.bodies]
        self.positions = states[:, model.jnt_qposadr[joints][:, None] + np.arange(3)]
        self.instants, self.is_on_board = instants, camera.startswith("fpv:")
        self._states = states
        view = {"fovy_deg": float(model.vis.global_.fovy), "aspect": size[0] / size[1]}
        path = follow(self.positions, np.arange(len(states)) / fps, **view)
        self.model, self.scale = model, 1.0
        if magnify:
            self.model, self.scale = magnified(model, self.bodies, self.positions, path.distance)
        self.data = mujoco.MjData(self.model)
        self.colors = drone_colors(model, self.bodies)
        self._shot = find_shot(self.model, camera, path)

    def pose(self, renderer: Renderer, frame: int) -> None:
        """Put everything where a state has it, as far as one can see, and look at it."""
        self.data.qpos[:] = self._states[frame]
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        renderer.update(self.data, self._shot(self.data, frame))


class _Scenes:
    """What is in a scene beside the model: shadows, trails, links, marks and ghosts."""

    def __init__(self, shots: _Shots, story: Storyboard, told: NDArray[np.float64] | None, trail: int) -> None:
        self._shots, self._story, self._told = shots, story, told
        self._trails = Trails(shots.positions, shots.colors, length=trail)

    def compose(self, renderer: Renderer, frame: int) -> None:
        """Prepare the picture of one state."""
        shots, scene = self._shots, renderer.scene
        shots.pose(renderer, frame)
        add_shadows(scene, shots.model, shots.data, shots.bodies, 0.042 * shots.scale)
        self._trails.draw(scene, frame)
        add_links(scene, shots.positions[frame], self._story.links)
        now = shots.instants[frame]
        add_marks(scene, (mark for mark in self._story.marks if mark.is_there(now)), shots.colors)
        if self._told is not None:
            told = self._told[frame].copy()
            away = np.linalg.norm(told - shots.positions[frame], axis=-1)
            told[~(away >= _GHOST_FROM_M * shots.scale)] = np.nan
            shown = np.isfinite(told).all(axis=-1)
            add_ghosts(scene, told[shown], shots.colors[shown])


class _Over:
    """What is drawn over a picture: the frame of `Hud`, and labels at drones and marks."""

    def __init__(self, shots: _Shots, story: Storyboard, size: tuple[int, int], speed: float) -> None:
        instants = shots.instants
        span = (float(instants[0]), float(instants[-1]))
        self._shots, self._story, self._size = shots, story, size
        self._hud = Hud(*size, span, speed, story.title, story.windows, story.notes)
        self._labels = Labels(*size, self._hud.boxes)
        self._colors = [_dark(color) for color in shots.colors]

    def draw(self, picture: NDArray[np.uint8], scene: mujoco.MjvScene, frame: int) -> None:
        """Draw over one picture."""
        shots, now = self._shots, float(self._shots.instants[frame])
        troubled = {note.drone for note in self._story.notes if note.begin <= now < note.end}
        words: list[tuple[str, str, Color, NDArray[np.float64]]] = []
        for k, name in enumerate(shots.names):
            if name in troubled or (len(shots.names) <= MANY and not shots.is_on_board):
                color = RED if name in troubled else self._colors[k]
                words.append((name, name, color, shots.positions[frame, k]))
        for k, mark in enumerate(self._story.marks):
            if mark.label and mark.is_there(now):
                color = (70, 74, 80) if mark.drone is None else self._colors[mark.drone]
                words.append((f"mark {k}", mark.label, color, mark.position))
        if words:
            self._label(picture, scene, words)
        self._hud.draw(picture, now)

    def _label(
        self,
        picture: NDArray[np.uint8],
        scene: mujoco.MjvScene,
        words: Sequence[tuple[str, str, Color, NDArray[np.float64]]],
    ) -> None:
        width, height = self._size
        points = in_picture(scene, np.array([place for *_, place in words]), width, height)
        patches = [text(label, self._hud.letters, color, is_bold=True) for _, label, color, _ in words]
        sizes = [(patch.shape[1], patch.shape[0]) for patch in patches]
        places = self._labels.place(points.tolist(), sizes, 1.3 * self._hud.letters, [key for key, *_ in words])
        for place, patch in zip(places, patches, strict=True):
            if place is not None:
                blend(picture, patch, *place)


def _dark(color: NDArray[np.float64]) -> Color:
    """Return a color as letters need it, not brighter than half."""
    red, green, blue = (color * min(1.0, 0.5 / max(1e-6, float(color @ [0.3, 0.6, 0.1]))) * 255).astype(int).tolist()
    return red, green, blue


def _painted(
    model: mujoco.MjModel, joints: NDArray[np.int32], painted: frozenset[str] | None, leaders: frozenset[int] | None
) -> mujoco.MjModel:
    """Return a copy whose drones have the colors of the plot, or those of leaders and followers."""
    model = copy(model)
    quality = model.vis.quality
    quality.numslices, quality.numstacks = min(quality.numslices, 20), min(quality.numstacks, 10)
    if painted is None:
        return model
    colors = [rgb(color) for color in palette(len(joints))]
    for k, body in enumerate(model.jnt_bodyid[joints]):
        name = model.body(int(body)).name
        geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{name}/accent")
        if geom >= 0 and name not in painted:
            model.geom_rgba[geom, :3] = colors[k] if leaders is None else _LEADER if k in leaders else _FOLLOWER
            model.geom_matid[geom] = -1
    return model


def _checked_states(
    model: mujoco.MjModel, qpos: ArrayLike, times: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    recorded, instants = np.asarray(qpos, dtype=float), np.asarray(times, dtype=float)
    if instants.ndim != 1 or not len(instants) or recorded.shape != (len(instants), model.nq):
        raise ValueError(f"qpos has shape {recorded.shape}, times {instants.shape}; expected (F, {model.nq}) and (F,)")
    if not np.all(np.diff(instants) > 0.0):
        raise ValueError("times must increase")
    return recorded, instants


def _checked_targets(targets: ArrayLike | None, drones: int, frames: int) -> NDArray[np.float64] | None:
    if targets is None:
        return None
    told = np.asarray(targets, dtype=float)
    if told.shape != (frames, drones, 3):
        raise ValueError(f"targets has shape {told.shape}, expected {frames, drones, 3}")
    return told


def resample(
    model: mujoco.MjModel, qpos: NDArray[np.float64], times: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the states at the *wanted* instants, shape (len(wanted), nq): linear, the quaternions normalized."""
    right = np.clip(np.searchsorted(times, wanted, side="right"), 1, max(1, len(times) - 1))
    left = right - 1
    right = np.minimum(right, len(times) - 1)
    before, after = qpos[left], qpos[right]
    share = np.clip((wanted - times[left]) / np.maximum(times[right] - times[left], 1e-12), 0.0, 1.0)[:, None]
    quats = model.jnt_qposadr[_free_joints(model)][:, None] + np.arange(3, 7)
    # q and -q are one attitude: take the one on the near side
    far = np.sum(before[:, quats] * after[:, quats], axis=-1, keepdims=True) < 0.0
    after[:, quats] = np.where(far, -after[:, quats], after[:, quats])
    states = (1.0 - share) * before + share * after
    states[:, quats] /= np.maximum(np.linalg.norm(states[:, quats], axis=-1, keepdims=True), 1e-9)
    return states


def _free_joints(model: mujoco.MjModel) -> NDArray[np.int32]:
    return np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE).astype(np.int32)


def _joints_of_drones(model: mujoco.MjModel, named: Sequence[str] | None) -> NDArray[np.int32]:
    """Return the free joints of drones: payloads and loose things are none; without engine plugins all are."""
    if named is not None:
        return np.array([model.body_jntadr[find_drone(model, name)] for name in named], np.int32)
    joints = _free_joints(model)
    flown = joints[model.body_plugin[model.jnt_bodyid[joints]] >= 0]
    return flown if len(flown) else joints
