"""Scenes as YAML: boxes, walls, pillars and gates by name, on an empty floor; in a file, or in a mission.

A scene that stands in a mission is handed on as one text, JSON with a brace at its begin, so that whatever names scenes
holds it: worlds, recipes of journals, metadata of logs.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import mujoco
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.plain_yaml import read_yaml
from crazychoir_fw.mujoco_models import model_path

SUFFIXES = (".yaml", ".yml")
MAX_OBJECTS = 5000
"""Of a kind."""
_BAR_M = 0.06  # edge of the bars of a gate
_COLORS = {"box": (0.75, 0.55, 0.35), "wall": (0.8, 0.8, 0.78), "pillar": (0.6, 0.62, 0.68), "gate": (0.95, 0.48, 0.1)}

Meters = Annotated[float, Field(ge=-1000.0, le=1000.0)]
Length = Annotated[float, Field(gt=0.0, le=1000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, strict=False)


class _Thing(_Section):
    color: tuple[Share, Share, Share] | None = None
    """Red, green, blue."""


class Box(_Thing):
    """A box that stands on the floor, or at a height."""

    position: tuple[Meters, Meters] | tuple[Meters, Meters, Meters]
    """Middle of its lower side [x, y] or [x, y, z] (m)."""
    size: tuple[Length, Length, Length]
    """Edges along x, y, z (m)."""
    yaw_deg: float = 0.0


class Wall(_Thing):
    """A wall on the floor from one point to another."""

    begin: tuple[Meters, Meters] = Field(alias="from")
    end: tuple[Meters, Meters] = Field(alias="to")
    height: Length = 2.0
    thickness: Length = 0.05


class Pillar(_Thing):
    """A round pillar on the floor."""

    position: tuple[Meters, Meters]
    radius: Length = 0.1
    height: Length = 2.0


class Gate(_Thing):
    """A square gate on a post, flown along the heading `yaw_deg`."""

    position: tuple[Meters, Meters, Meters]
    """Middle of its opening (m)."""
    yaw_deg: float = 0.0
    size: Length = 0.7
    """Width and height of the opening (m)."""


class SceneFile(_Section):
    """What a scene file holds; objects by their names."""

    light: Annotated[float, Field(ge=0.0, le=2.0)] = 1.0
    """Brightness, 1 as in the scene `arena`."""
    boxes: dict[str, Box] = Field(default_factory=dict, max_length=MAX_OBJECTS)
    walls: dict[str, Wall] = Field(default_factory=dict, max_length=MAX_OBJECTS)
    pillars: dict[str, Pillar] = Field(default_factory=dict, max_length=MAX_OBJECTS)
    gates: dict[str, Gate] = Field(default_factory=dict, max_length=MAX_OBJECTS)


def read_scene(path: Path) -> SceneFile:
    """Read a scene file.

    Raises:
        RangeError: If it cannot be read, or something in it does not fit; the text is one sentence.
    """
    return _checked(f"scene {path.name}: ", read_yaml(path, RangeError) or {})


def inline_scene(content: Mapping[str, Any] | str) -> str:
    """Return a scene that is no file, with the keys of a scene file, as the text that stands for it.

    Args:
        content: The scene, or already its text.

    Raises:
        RangeError: If something in it does not fit; the text is one sentence.
    """
    if isinstance(content, str):
        _read_inline(content)
        return content
    _checked("scene.", content)
    return json.dumps(content)


def _read_inline(text: str) -> SceneFile:
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RangeError(f"the scene of the mission cannot be read: {error}") from None
    return _checked("scene.", content)


def is_inline(scene: str | Path) -> bool:
    """Return whether a scene is the text of `inline_scene`."""
    return str(scene).startswith("{")


def scene_name(scene: str | Path) -> str:
    """Return what messages call a scene."""
    return "of the mission" if is_inline(scene) else str(scene)


def _checked(where: str, content: Any) -> SceneFile:
    try:
        return SceneFile.model_validate(content)
    except ValidationError as error:
        raise RangeError(f"{where}{_sentence(error)}") from None


def scene_spec(scene_file: str | Path) -> mujoco.MjSpec:
    """Return the model of a scene file, or of the text of `inline_scene`, without drones.

    Raises:
        RangeError: As `read_scene`.
    """
    scene = _read_inline(str(scene_file)) if is_inline(scene_file) else read_scene(Path(scene_file))
    spec = mujoco.MjSpec.from_file(str(model_path("arena")))
    for light in spec.lights:
        light.diffuse, light.specular = light.diffuse * scene.light, light.specular * scene.light
    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse = headlight.ambient * scene.light, headlight.diffuse * scene.light
    for name, box in scene.boxes.items():
        x, y, *z = box.position
        half = [edge / 2.0 for edge in box.size]
        _box(_body(spec, name, (x, y, (z[0] if z else 0.0) + half[2]), box.yaw_deg), name, half, _rgba(box, "box"))
    for name, wall in scene.walls.items():
        _add_wall(spec, name, wall)
    for name, pillar in scene.pillars.items():
        body = _body(spec, name, (*pillar.position, pillar.height / 2.0), 0.0)
        shape = mujoco.mjtGeom.mjGEOM_CYLINDER
        body.add_geom(
            name=name, type=shape, size=[pillar.radius, pillar.height / 2.0, 0.0], rgba=_rgba(pillar, "pillar")
        )
    for name, gate in scene.gates.items():
        _add_gate(spec, name, gate)
    return spec


def _add_wall(spec: mujoco.MjSpec, name: str, wall: Wall) -> None:
    (x, y), (to_x, to_y) = wall.begin, wall.end
    yaw = math.degrees(math.atan2(to_y - y, to_x - x))
    body = _body(spec, name, ((x + to_x) / 2.0, (y + to_y) / 2.0, wall.height / 2.0), yaw)
    length = max(math.hypot(to_x - x, to_y - y), wall.thickness)
    _box(body, name, [length / 2.0, wall.thickness / 2.0, wall.height / 2.0], _rgba(wall, "wall"))


def _add_gate(spec: mujoco.MjSpec, name: str, gate: Gate) -> None:
    body, rgba = _body(spec, name, gate.position, gate.yaw_deg), _rgba(gate, "gate")
    half, bar = gate.size / 2.0, _BAR_M / 2.0
    for side, sign in (("left", 1.0), ("right", -1.0)):
        _box(body, f"{name}_{side}", [bar, bar, half], rgba, (0.0, sign * (half + bar), 0.0))
    for side, sign in (("top", 1.0), ("bottom", -1.0)):
        _box(body, f"{name}_{side}", [bar, half + _BAR_M, bar], rgba, (0.0, 0.0, sign * (half + bar)))
    post = gate.position[2] - half - _BAR_M
    if post > 0.0:
        _box(body, f"{name}_post", [bar / 2.0, bar / 2.0, post / 2.0], rgba, (0.0, 0.0, -half - _BAR_M - post / 2.0))


def _body(spec: mujoco.MjSpec, name: str, position: tuple[float, float, float], yaw_deg: float) -> Any:
    half = math.radians(yaw_deg) / 2.0
    return spec.worldbody.add_body(name=name, pos=position, quat=[math.cos(half), 0.0, 0.0, math.sin(half)])


def _box(
    body: Any, name: str, half: list[float], rgba: list[float], at: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> None:
    body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, size=half, rgba=rgba, pos=at)


def _rgba(thing: _Thing, kind: str) -> list[float]:
    return [*(thing.color or _COLORS[kind]), 1.0]


def _sentence(error: ValidationError) -> str:
    """Return the first thing that is wrong."""
    first = error.errors(include_url=False)[0]
    path = ""
    for step in first["loc"]:
        if isinstance(step, int):
            path += f"[{step}]"
        elif not str(step).startswith("tuple"):
            path += f".{step}" if path else str(step)
    if first["type"] == "extra_forbidden":
        return f"there is no key {path}"
    if first["type"] == "missing":
        return f"{path} is missing"
    return f"{path or 'the file'} is {str(first['input'])[:60]}, but {first['msg'].replace('Input should', 'must')}"
