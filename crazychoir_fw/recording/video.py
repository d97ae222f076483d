"""Films: an H.264 file from pictures, and the pictures of a recorded flight."""

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType

import imageio_ffmpeg
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.recording.marks import Mark
from crazychoir_fw.recording.opengl import RenderingError, rendering_available
from crazychoir_fw.recording.overlays import Trails, add_ghosts, add_links, add_marks, add_names, drone_colors
from crazychoir_fw.recording.renderer import Renderer
from crazychoir_fw.recording.shots import find_drone, find_shot, follow, shadowed

__all__ = ["RenderingError", "VideoWriter", "film_flight", "picture", "rendering_available"]


class VideoWriter:
    """Writes pictures to an mp4 file (H.264, yuv420p) that appears under its name when it is complete.

    Use it as a context manager; if the block raises, nothing is left behind.

    Args:
        path: The file, `.mp4`.
        fps: Pictures per second.
        crf: Quality of the encoder, 0 (lossless) to 51; 20 looks good.
    """

    def __init__(self, path: Path, *, fps: float = 25.0, crf: int = 20) -> None:
        if not 0.0 < fps <= 1000.0:
            raise ValueError(f"fps {fps} is outside (0, 1000]")
        self._path = Path(path)
        self._fps = fps
        self._crf = crf
        self._size: tuple[int, int] | None = None
        self._sink = None

    def __enter__(self) -> "VideoWriter":
        self._replacing = replacing(self._path)
        self._temporary = self._replacing.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._sink is not None:
            self._sink.close()
        elif kind is None:
            # leave through the door for failures, so that no empty file takes the place of an older film
            error = ValueError(f"no pictures were written to {self._path}")
            kind = ValueError
            self._replacing.__exit__(kind, error, None)
            raise error
        self._replacing.__exit__(kind, error, trace)

    def write(self, picture: NDArray[np.uint8]) -> None:
        """Append one picture.

        Args:
            picture: RGB, shape (height, width, 3); an odd last row or column is cut off, which the format asks for.

        Raises:
            ValueError: If the picture is not RGB of 8 bits, or its size differs from that of the first.
        """
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
            raise ValueError(f"picture has shape {picture.shape} and type {picture.dtype}, expected (H, W, 3) uint8")
        height, width = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
        if self._sink is None:
            if not height or not width:
                raise ValueError(f"picture has shape {picture.shape}, expected at least 2 x 2 pixels")
            self._size = (width, height)
            self._sink = imageio_ffmpeg.write_frames(
                str(self._temporary),
                self._size,
                fps=self._fps,
                codec="libx264",
                pix_fmt_out="yuv420p",
                quality=None,
                macro_block_size=2,
                ffmpeg_log_level="error",
                output_params=["-crf", str(self._crf), "-preset", "veryfast", "-movflags", "+faststart"],
            )
            self._sink.send(None)
        if (width, height) != self._size:
            raise ValueError(f"picture is {width} x {height} pixels, the film is {self._size[0]} x {self._size[1]}")
        self._sink.send(np.ascontiguousarray(picture[:height, :width]))


def film_flight(
    model: mujoco.MjModel,
    qpos: ArrayLike,
    times: ArrayLike,
    path: Path,
    *,
    camera: str = "follow",
    width: int = 960,
    height: int = 540,
    fps: float = 25.0,
    speed: float = 1.0,
    trail_s: float = 3.0,
    names: Sequence[str] | None = None,
    targets: ArrayLike | None = None,
    links: Sequence[tuple[int, int]] = (),
    marks: Sequence[Mark] = (),
    drones: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Film recorded states of a world.

    Args:
        model: The world; bodies with engine plugins are its drones, without plugins all that have a free joint.
        qpos: Recorded positions, shape (F, nq). States between them are interpolated.
        times: Instants of the states (s), shape (F,), increasing.
        path: The film, `.mp4`.
        camera: `follow` for a camera that keeps the swarm in the picture, `fpv:NAME` for the view from a drone,
            `chase:NAME` for one from behind it, else the name of a camera of the model.
        width: Width of the pictures (pixels).
        height: Height of the pictures (pixels).
        fps: Pictures per second.
        speed: Seconds of flight per second of film.
        trail_s: Length of the lines behind the drones (s of flight); 0 for none. `fpv` has none.
        names: Drones whose names are shown above them.
        targets: Where those drones are told to be at each of the `times` (m, world frame), shown as ghosts, shape
            (F, len(names), 3); NaN where no place is asked for.
        links: Pairs of drones, by number, between which a thin rod is shown.
        marks: Points beside the drones, each shown while it is there; targets and intruders are balls.
        drones: Names of the bodies that count as drones, in their order, where some of them have no engine plugin.
        progress: Called after each picture with how many are drawn and how many there will be.

    Raises:
        RenderingError: If there is no OpenGL on this machine.
        ValueError: If the shapes do not fit or there is no such camera or drone.
    """
    recorded, instants = _checked_states(model, qpos, times)
    if not 0.0 < speed < np.inf:
        raise ValueError(f"speed {speed} is not positive")
    told = _checked_targets(targets, names, len(instants))

    count = int((instants[-1] - instants[0]) * fps / speed) + 1
    wanted = instants[0] + np.arange(count) * speed / fps
    states = resample(model, recorded, instants, wanted)
    if told is not None:
        told = told[np.clip(np.searchsorted(instants, wanted + 1e-9, side="right") - 1, 0, None)]
    length = 0 if camera.startswith("fpv:") else round(trail_s * fps / speed)
    scenes = _Scenes(model, states, fps, camera, width / height, length, names or (), told, links, drones)
    scenes.marks, scenes.instants = marks, wanted

    with Renderer(model, width, height) as renderer, VideoWriter(path, fps=fps) as film:
        for frame in range(count):
            scenes.compose(renderer, frame)
            film.write(renderer.draw())
            if progress is not None:
                progress(frame + 1, count)


class _Scenes:
    """What is seen of each state: camera, shadows, trails, ghosts and names."""

    def __init__(
        self,
        model: mujoco.MjModel,
        states: NDArray[np.float64],
        fps: float,
        camera: str,
        aspect: float,
        trail_length: int,
        names: Sequence[str],
        targets: NDArray[np.float64] | None,
        links: Sequence[tuple[int, int]] = (),
        named: Sequence[str] | None = None,
    ) -> None:
        drones = _joints_of_drones(model, named)
        self.marks: Sequence[Mark] = ()
        self.instants = np.zeros(len(states))
        self._bodies, self._links = model.jnt_bodyid[drones], links
        positions = states[:, model.jnt_qposadr[drones][:, None] + np.arange(3)]
        self._model, self._data, self._states = model, mujoco.MjData(model), states
        self._path = follow(positions, np.arange(len(states)) / fps)
        self._shot = find_shot(model, camera, self._path, aspect)
        self._all_colors = drone_colors(model, model.jnt_bodyid[drones])
        self._trails = Trails(positions, self._all_colors, length=trail_length)
        self._names, self._targets = names, targets
        self._named = np.array([find_drone(model, name) for name in names], dtype=int)
        self._colors = drone_colors(model, self._named)

    def compose(self, renderer: Renderer, frame: int) -> None:
        """Prepare the picture of one state."""
        _pose(self._model, self._data, self._states[frame])
        view = self._shot(self._data, frame)
        renderer.update(self._data, view)
        _move_shadows(renderer, *shadowed(view, self._path, frame))
        self._trails.draw(renderer.scene, frame)
        add_links(renderer.scene, self._data.xpos[self._bodies], self._links)
        now = self.instants[frame]
        add_marks(renderer.scene, (mark for mark in self.marks if mark.is_there(now)), self._all_colors)
        if self._targets is not None:
            add_ghosts(renderer.scene, self._targets[frame], self._colors)
        add_names(renderer.scene, self._data.xpos[self._named], self._names)


def _checked_states(
    model: mujoco.MjModel, qpos: ArrayLike, times: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    recorded, instants = np.asarray(qpos, dtype=float), np.asarray(times, dtype=float)
    if instants.ndim != 1 or not len(instants) or recorded.shape != (len(instants), model.nq):
        raise ValueError(f"qpos has shape {recorded.shape}, times {instants.shape}; expected (F, {model.nq}) and (F,)")
    if not np.all(np.diff(instants) > 0.0):
        raise ValueError("times must increase")
    return recorded, instants


def _pose(model: mujoco.MjModel, data: mujoco.MjData, state: NDArray[np.float64]) -> None:
    """Put everything where a state has it, as far as one can see."""
    data.qpos[:] = state
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)


def _checked_targets(targets: ArrayLike | None, names: Sequence[str] | None, frames: int) -> NDArray[np.float64] | None:
    if targets is None:
        return None
    told = np.asarray(targets, dtype=float)
    if names is None or told.shape != (frames, len(names), 3):
        count = 0 if names is None else len(names)
        raise ValueError(f"targets has shape {told.shape}, expected {frames, count, 3}")
    return told


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
        camera: As of `film_flight`.
        width: Width of the picture (pixels).
        height: Height of the picture (pixels).
        names: Names of the drones to show, in the order of `positions`.
        targets: Where they are told to be (m, world frame), shown as ghosts, shape (N, 3).

    Returns:
        The picture, shape (height, width, 3).

    Raises:
        RenderingError: If there is no OpenGL on this machine.
        ValueError: If there is no such camera.
    """
    swarm_path = follow(positions[None], np.zeros(1))
    view = find_shot(model, camera, swarm_path, width / height)(data, 0)
    with Renderer(model, width, height) as renderer:
        renderer.update(data, view)
        _move_shadows(renderer, *shadowed(view, swarm_path, 0))
        if names is not None:
            add_names(renderer.scene, positions, names)
            if targets is not None:
                bodies = [find_drone(model, name) for name in names]
                add_ghosts(renderer.scene, targets, drone_colors(model, bodies))
        return renderer.draw().copy()


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
    return np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)


def _joints_of_drones(model: mujoco.MjModel, named: Sequence[str] | None) -> NDArray[np.int32]:
    """Return the free joints of drones: payloads and loose things are none; without engine plugins all are."""
    if named is not None:
        return np.array([model.body_jntadr[model.body(name).id] for name in named], np.int32)
    joints = _free_joints(model)
    flown = joints[model.body_plugin[model.jnt_bodyid[joints]] >= 0]
    return flown if len(flown) else joints


def _move_shadows(renderer: Renderer, center: NDArray[np.float64], radius: float) -> None:
    """Bring the shadow map of directional lights to the swarm: it covers a square around the axis of the light."""
    renderer.drawer.shadowClip = max(1.5, 1.5 * radius + center[2])
    for light in itertools.islice(renderer.scene.lights, renderer.scene.nlight):
        if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL and light.castshadow and light.dir[2] < 0.0:
            above = max(light.pos[2], center[2] + radius)
            light.pos[:] = center - light.dir * ((above - center[2]) / -light.dir[2])
