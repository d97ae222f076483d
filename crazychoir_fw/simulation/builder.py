"""One MJCF model from a scene and a list of drones."""

from __future__ import annotations

import colorsys
import ctypes
import sys
from collections.abc import Hashable, Sequence
from numbers import Real
from pathlib import Path

import mujoco
import numpy as np

from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.mujoco_models import SCENES, VEHICLES, model_path
from crazychoir_fw.mujoco_models.stamp import VehicleStamp
from crazychoir_fw.onboard.core import PLUGIN
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.loading import add_payload, check_payload, set_inertia
from crazychoir_fw.simulation.mirrored import MirroredConfig, add_mirrored
from crazychoir_fw.simulation.model_drones import is_crazyflie
from crazychoir_fw.simulation.model_templates import (
    ModelTemplate,
    ModelTemplates,
    padding,
    plugin_config,
    start_pose,
    structure_of,
)
from crazychoir_fw.simulation.provider_words import BUILTIN, load_providers
from crazychoir_fw.simulation.scene_file import SUFFIXES, is_inline, scene_name, scene_spec
from crazychoir_fw.simulation.scene_limits import check_scene

MAX_FOR_NEWTON = 100
"""Drones up to which Newton's method solves the contacts of a world, see `_choose_solver`."""

_GOLDEN_RATIO = 0.618034

_ATTRIBUTES_OF_CODE = ("provider", "controller", "estimator", "motor_ctrl", "motor_ctrl_properties")
"""What of a drone in a scene may name code of the user's."""


_templates = ModelTemplates()


def build_model(
    drones: Sequence[DroneConfig],
    scene: str | Path,
    seed: int,
    visuals: bool = True,
    mirrored: Sequence[MirroredConfig] = (),
) -> mujoco.MjModel:
    """Compile a world, or copy one that differs in values only: the bits are the same.

    Args:
        drones: The drones, with unique names.
        scene: A name of `SCENES` or the path of an MJCF file, or of a YAML file (`scene_file.py`).
        seed: Seed of all noise.
        visuals: Whether drones can be seen. What cannot be seen is faster; the flight is the same to the last bit.
        mirrored: Bodies that are moved from outside.

    Attributes of a copy are checked when it gets its `MjData`, which raises ``mujoco.FatalError``.

    Raises:
        RangeError: If a drone's configuration is impossible; the message names the drone and what is allowed.
        UnknownNameError: If there is no such scene or platform.
    """
    _check(drones, seed, [body.id for body in mirrored])
    structure = None if mirrored else structure_of(drones, scene, visuals)
    if structure is not None and _templates.wants(structure):
        model = _copied(structure, drones, scene, seed, visuals)
        if model is not None:
            return model
    return _built(drones, scene, seed, visuals, mirrored)[0]


def compile_model(
    drones: Sequence[DroneConfig],
    scene: str | Path,
    seed: int,
    visuals: bool = True,
    mirrored: Sequence[MirroredConfig] = (),
) -> mujoco.MjModel:
    """Compile a world in any case; arguments and errors are those of `build_model`."""
    _check(drones, seed, [body.id for body in mirrored])
    return _built(drones, scene, seed, visuals, mirrored)[0]


def _copied(
    structure: Hashable, drones: Sequence[DroneConfig], scene: str | Path, seed: int, visuals: bool
) -> mujoco.MjModel | None:
    """Return a world as a copy of its template, which is made if there is none; None where only the compiler can."""
    try:
        template = _templates.get(structure)
        if template is None:
            model, stamps = _built(drones, scene, seed, visuals, (), is_padded=True)
            template = ModelTemplate(model, {platform: stamp.airframe() for platform, stamp in stamps.items()})
            _templates.keep(structure, template)
        return template.with_values(drones, seed)
    except (CrazychoirError, ValueError, mujoco.FatalError):
        return None  # the compiler says what is wrong with the values


def _built(
    drones: Sequence[DroneConfig],
    scene: str | Path,
    seed: int,
    visuals: bool,
    mirrored: Sequence[MirroredConfig],
    is_padded: bool = False,
) -> tuple[mujoco.MjModel, dict[str, VehicleStamp]]:
    """Compile a world; a padded one has room for longer attributes."""
    spec = _scene(scene)
    in_scene = _prepare_drones_of(spec, scene, seed)
    if not drones and not in_scene:
        raise RangeError(
            f"drones: the list is empty and scene '{scene_name(scene)}' has none, a world has at least 1 drone"
        )
    spec.activate_plugin(PLUGIN)
    stamps: dict[str, VehicleStamp] = {}
    try:
        for index, drone in enumerate(drones):
            if drone.platform not in stamps:
                stamps[drone.platform] = _stamp(spec, drone, visuals)
            # drones of the scene count first, as the engine plugin does
            _add_drone(spec, stamps[drone.platform], drone, in_scene + index, seed, is_padded)
        for body in mirrored:
            add_mirrored(spec, body, stamps, visuals)
    except CrazychoirError:
        raise
    except ValueError as error:
        raise RangeError(f"scene {scene_name(scene)} with its drones: {_one_line(error)}") from error
    model = _compiled(spec, f"scene {scene_name(scene)} with its drones")
    # one body gone wild must not send the whole world back to its start; the plugin parks that drone alone
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    _skip_what_is_absent(model)
    _choose_solver(model, in_scene + len(drones))
    return model, stamps


def build_stage(drones: Sequence[DroneConfig], scene: str | Path) -> mujoco.MjModel:
    """Compile what a world looks like: its drones have no onboard software, and no code of the user's is touched.

    Args:
        drones: Drones with unique names; those that the scene brings along need not be among them.
        scene: A name of `SCENES` or the path of an MJCF file.

    Raises:
        RangeError: If scene or drones are impossible.
        UnknownNameError: If there is no such scene or platform.
    """
    spec = _scene(scene)
    for entry in spec.plugins:
        entry.config = {name: text for name, text in entry.config.items() if name not in _ATTRIBUTES_OF_CODE}
    _check(drones, 0, ())
    known = {body.name for body in spec.bodies}
    stamps: dict[str, VehicleStamp] = {}
    try:
        for index, drone in enumerate(drones):
            if drone.id not in known:
                if drone.platform not in stamps:
                    stamps[drone.platform] = _stamp(spec, drone, True)
                _add_body(spec, stamps[drone.platform], drone, index)
    except ValueError as error:
        raise RangeError(f"scene {scene_name(scene)} with its drones: {_one_line(error)}") from error
    return _compiled(spec, f"scene {scene_name(scene)} with its drones")


def _compiled(spec: mujoco.MjSpec, what: str) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise RangeError(f"{what}: {_one_line(error)}") from error


def _skip_what_is_absent(model: mujoco.MjModel) -> None:
    """Switch off stages of the physics that this model has no use for: a seventh of its cost, and no effect.

    MuJoCo walks through the joints of all drones looking for sensors, actuators, limits, friction and damping that a
    Crazyflie does not have; a scene that has some keeps the stage. Springs stay on: without springs and damping MuJoCo
    leaves out all passive forces, and ours are among them.
    """
    bit = mujoco.mjtDisableBit
    is_absent = {
        bit.mjDSBL_SENSOR: model.nsensor == 0,
        bit.mjDSBL_ACTUATION: model.nu == 0,
        bit.mjDSBL_EQUALITY: model.neq == 0,
        bit.mjDSBL_LIMIT: not (model.jnt_limited.any() or model.tendon_limited.any()),
        bit.mjDSBL_FRICTIONLOSS: not (model.dof_frictionloss.any() or model.tendon_frictionloss.any()),
        bit.mjDSBL_DAMPER: not (model.dof_damping.any() or model.tendon_damping.any()),
    }
    for flag, absent in is_absent.items():
        if absent:
            model.opt.disableflags |= flag


def _choose_solver(model: mujoco.MjModel, drones: int) -> None:
    """Let contacts of a drone be solved alike whatever the others do, and those of large swarms at a bearable cost.

    By itself MuJoCo starts the solver for all bodies at once, with the last solution or without, and goes from dense to
    sparse matrices at a number of joints: the last bits of a drone on the floor would depend on drones far away.

    Newton's method costs the cube of a heap of crashed drones, conjugate gradients do not. Where each drone stands
    alone, both end at the same, to 1e-9 m. Scenes in which other things move keep what they chose.
    """
    only_drones_move = model.nv == 6 * drones and model.neq == 0
    if not only_drones_move:
        return
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART
    if model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO:
        model.opt.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    if drones > MAX_FOR_NEWTON and model.opt.solver == mujoco.mjtSolver.mjSOL_NEWTON:
        model.opt.solver = mujoco.mjtSolver.mjSOL_CG


def _prepare_drones_of(spec: mujoco.MjSpec, scene: str | Path, seed: int) -> int:
    """Load the providers of the drones that a scene brings along, and give those the seed that have none.

    Returns:
        The number of these drones.
    """
    plugins = list(spec.plugins)
    load_providers((entry.config.get("provider", BUILTIN), entry.config.get("platform", "cf2")) for entry in plugins)
    if not plugins:
        return 0
    # a specification does not say what a plugin declared within a body is, but the compiled model does; read again,
    # because MuJoCo 4.0 copies no specification with such a plugin
    reading = _scene(scene)
    reading.activate_plugin(PLUGIN)
    trial = _compiled(reading, f"scene {scene_name(scene)}")
    drones = [entry for i, entry in enumerate(plugins) if is_crazyflie(trial, i)]
    for entry in drones:
        entry.config = {"seed": str(seed), **entry.config}
    return len(drones)


def _check(drones: Sequence[DroneConfig], seed: int, taken: Sequence[str]) -> None:
    if not (isinstance(seed, int) and 0 <= seed < 2**32):
        raise RangeError(f"seed is {seed!r}, allowed: a whole number from 0 to 4294967295")
    seen: set[str] = set(taken)
    for drone in drones:
        if not isinstance(drone.id, str):
            raise RangeError(f"drones: id is {drone.id!r}, allowed: text")
        if not drone.id or drone.id in seen:
            raise RangeError(f"drones: id '{drone.id}' is used twice or empty, every drone has a name of its own")
        seen.add(drone.id)
        if not _is_place(drone.position) or not _is_finite(drone.yaw_deg):
            raise RangeError(f"{drone.id}: position is {drone.position}, allowed: finite (x, y) or (x, y, z) in m")
        if drone.mass is not None and not 0.005 <= drone.mass <= 0.5:
            raise RangeError(f"{drone.id}: mass is {drone.mass}, allowed: 0.005 to 0.5 kg")
        check_payload(drone)


def _is_place(position: object) -> bool:
    """Return whether this is (x, y) or (x, y, z); z may be None, for a drone on the floor."""
    if isinstance(position, str) or not isinstance(position, Sequence | np.ndarray) or len(position) not in (2, 3):
        return False
    x, y, *z = position
    return all(map(_is_finite, (x, y, *(value for value in z if value is not None))))


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and bool(np.isfinite(float(value)))


def _scene(scene: str | Path) -> mujoco.MjSpec:
    if not isinstance(scene, str | Path):
        raise RangeError(f"scene is {scene!r}, allowed: the path of an MJCF or YAML file or one of {', '.join(SCENES)}")
    if is_inline(scene):
        return scene_spec(scene)
    path = model_path(str(scene)) if str(scene) in SCENES else Path(scene)
    if not path.is_file():
        raise UnknownNameError(f"scene '{scene}' is neither a file nor one of: {', '.join(SCENES)}")
    if path.suffix in SUFFIXES:
        return scene_spec(path)
    if str(scene) not in SCENES:
        check_scene(path)
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise RangeError(f"scene {path}: {_one_line(error)}") from error


def _one_line(error: ValueError) -> str:
    """Return what MuJoCo says in one sentence."""
    words = " ".join(str(error).split())
    return words.removeprefix("Error: ").removeprefix("XML Error: ").removeprefix("engine error: ")


def _stamp(spec: mujoco.MjSpec, drone: DroneConfig, visuals: bool) -> VehicleStamp:
    if drone.platform not in VEHICLES:
        raise UnknownNameError(f"{drone.id}: platform is '{drone.platform}', allowed: {', '.join(VEHICLES)}")
    return VehicleStamp(spec, drone.platform, visuals)


def _add_body(spec: mujoco.MjSpec, stamp: VehicleStamp, drone: DroneConfig, index: int) -> mujoco.MjsBody:
    pose = start_pose(drone, stamp.rest_height)
    body = stamp.place(
        drone.id,
        pose[:3],
        quat_wxyz=pose[3:],
        rgba=(*(drone.color or _color(index)), 1.0),
    )
    set_inertia(body, drone)
    add_payload(spec, body, drone)
    return body


def _add_drone(
    spec: mujoco.MjSpec, stamp: VehicleStamp, drone: DroneConfig, index: int, seed: int, is_padded: bool
) -> None:
    body = _add_body(spec, stamp, drone, index)
    plugin = spec.add_plugin(name=f"{drone.id}/crazyflie", plugin_name=PLUGIN, active=True)
    plugin.config = plugin_config(drone, index, seed) | (padding(drone) if is_padded else {})
    body.plugin = plugin
    if plugin.config.get("isolated") == "on":
        # the engine plugin leaves out its contacts with others; by these bits MuJoCo need not ask for every pair.
        # scenery has bit 0, drones meet each other by bit 1
        for geom in body.geoms:
            geom.contype, geom.conaffinity = geom.contype & 1, 0


def _color(index: int) -> tuple[float, float, float]:
    """Return a color for a drone, so that drones can be told apart: hues a golden angle from each other."""
    return colorsys.hsv_to_rgb((0.58 + index * _GOLDEN_RATIO) % 1.0, 0.75, 0.95)


WORTH_IT = 30
"""Drones from which on a world leaves enough behind, 60 KiB each."""


def give_back_memory() -> None:
    """Ask the C library to return what it keeps of freed memory, which takes some milliseconds.

    MuJoCo's description of a model is larger than the model, and made of small pieces: freed, they stay with the
    process, which would count more than half of a large world's memory twice. Does nothing where the C library has no
    such request.
    """
    if not sys.platform.startswith("linux"):
        return
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(ctypes.c_size_t(0))
