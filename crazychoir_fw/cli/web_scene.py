"""Triangles and colors of a MuJoCo model, for pages that draw with WebGL."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

_SEEN_GROUPS = 3  # MuJoCo's viewers show the groups 0 to 2
_ENDLESS_M = 20.0  # half the side of a floor without end
_GEOM = mujoco.mjtGeom
_MESH, _PLANE = int(_GEOM.mjGEOM_MESH), int(_GEOM.mjGEOM_PLANE)


@dataclass
class Batch:
    """Parts of several drones with one shape."""

    mesh: trimesh.Trimesh
    """The shape in the frame of the drone's body, with the colors of its first drone."""
    drones: NDArray[np.intp]
    """Which drones have it, shape (n,)."""
    colors: NDArray[np.uint8] | None
    """Its color on each of them, shape (n, 3); None if the colors of the mesh are those of all."""


def drone_batches(model: mujoco.MjModel, bodies: Sequence[int]) -> list[Batch]:
    """Return what drones look like, each shape once.

    Args:
        model: The world.
        bodies: The bodies of the drones.
    """
    found: dict[tuple, list[tuple[int, int]]] = {}
    for drone, body in enumerate(bodies):
        for geom in _geoms_of(model, body):
            shape = (int(model.geom_type[geom]), int(model.geom_dataid[geom]))
            key = (*shape, *model.geom_size[geom], *model.geom_pos[geom], *model.geom_quat[geom])
            found.setdefault(key, []).append((drone, geom))
    batches = []
    for members in found.values():
        geoms = [geom for _, geom in members]
        mesh = _mesh(model, geoms[0])
        mesh.apply_transform(_transform(model.geom_pos[geoms[0]], model.geom_quat[geoms[0]]))
        plain = _texture_of(model, geoms[0]) is None
        colors = np.array([_color(model, geom)[:3] for geom in geoms]) if plain else None
        batches.append(Batch(mesh, np.array([drone for drone, _ in members]), colors))
    return batches


def body_mesh(model: mujoco.MjModel, body: int) -> trimesh.Trimesh | None:
    """Return what is seen of a body, in its frame, as one mesh with colors; None if nothing is."""
    parts = []
    for geom in _geoms_of(model, body):
        mesh = _mesh(model, geom)
        mesh.apply_transform(_transform(model.geom_pos[geom], model.geom_quat[geom]))
        parts.append(mesh)
    return trimesh.util.concatenate(parts) if parts else None


def _geoms_of(model: mujoco.MjModel, body: int) -> Iterator[int]:
    first = int(model.body_geomadr[body])
    for geom in range(first, first + int(model.body_geomnum[body])):
        is_drawn = int(model.geom_type[geom]) in (*_SHAPES, _MESH, _PLANE)
        if is_drawn and model.geom_group[geom] < _SEEN_GROUPS and _color(model, geom)[3] > 0:
            yield geom


_SHAPES = {
    int(_GEOM.mjGEOM_BOX): lambda size: trimesh.creation.box(2.0 * size),
    int(_GEOM.mjGEOM_SPHERE): lambda size: trimesh.creation.icosphere(2, size[0]),
    int(_GEOM.mjGEOM_ELLIPSOID): lambda size: trimesh.creation.icosphere(2).apply_scale(size),
    int(_GEOM.mjGEOM_CYLINDER): lambda size: trimesh.creation.cylinder(size[0], 2.0 * size[1], sections=24),
    int(_GEOM.mjGEOM_CAPSULE): lambda size: trimesh.creation.capsule(2.0 * size[1], size[0], count=[12, 16]),
}


def _mesh(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    """Return a geom in its own frame, with colors."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == _MESH:
        return _from_asset(model, geom)
    if kind == _PLANE:
        # as thin as a sheet of paper: one side of a page's triangle is invisible
        sides = [2.0 * (half if half > 0.0 else _ENDLESS_M) for half in size[:2]]
        mesh = trimesh.creation.box([*sides, 2e-4])
    else:
        mesh = _SHAPES[kind](size)
    _paint(mesh, np.tile(_color(model, geom), (len(mesh.vertices), 1)))
    return mesh


def _from_asset(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    number = int(model.geom_dataid[geom])
    first, count = model.mesh_faceadr[number], model.mesh_facenum[number]
    corner = slice(first, first + count)
    start, length = model.mesh_vertadr[number], model.mesh_vertnum[number]
    vertices = model.mesh_vert[start : start + length][model.mesh_face[corner].ravel()]
    # three vertices of its own for each triangle, so that each has one color
    mesh = trimesh.Trimesh(vertices, np.arange(3 * count).reshape(-1, 3), process=False)
    texture = _texture_of(model, geom)
    if texture is None or model.mesh_texcoordadr[number] < 0:
        _paint(mesh, np.tile(_color(model, geom), (3 * count, 1)))
        return mesh
    # the middle of a triangle is surely inside of its patch of the palette
    where = model.mesh_texcoord[model.mesh_texcoordadr[number] + model.mesh_facetexcoord[corner]].mean(axis=1)
    picture = _texture(model, texture)
    rows = np.clip((where[:, 1] * len(picture)).astype(int), 0, len(picture) - 1)
    columns = np.clip((where[:, 0] * picture.shape[1]).astype(int), 0, picture.shape[1] - 1)
    colors = np.column_stack([picture[rows, columns], np.full(count, 255)]).astype(np.uint8)
    _paint(mesh, np.repeat(colors, 3, axis=0))
    return mesh


def _paint(mesh: trimesh.Trimesh, rgba: NDArray[np.uint8]) -> None:
    """Give each vertex a color; the format that meshes travel in wants amounts of light, not those of a screen."""
    colors = rgba.copy()
    colors[:, :3] = np.round(255.0 * (rgba[:, :3] / 255.0) ** 2.2)
    mesh.visual.vertex_colors = colors


def _texture_of(model: mujoco.MjModel, geom: int) -> int | None:
    material = model.geom_matid[geom]
    texture = model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB] if material >= 0 else -1
    return int(texture) if texture >= 0 else None


def _texture(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    """Return a texture, shape (height, width, 3)."""
    height, width, channels = (int(a[texture]) for a in (model.tex_height, model.tex_width, model.tex_nchannel))
    start = int(model.tex_adr[texture])
    return model.tex_data[start : start + height * width * channels].reshape(height, width, channels)[..., :3]


def _color(model: mujoco.MjModel, geom: int) -> NDArray[np.uint8]:
    """Return the color of a geom, that of its texture on the average, shape (4,)."""
    material, rgba = model.geom_matid[geom], model.geom_rgba[geom]
    if material >= 0 and np.array_equal(rgba, np.float32([0.5, 0.5, 0.5, 1.0])):
        # the color of a geom wins over that of its material once it has been changed
        rgba = model.mat_rgba[material]
    texture = _texture_of(model, geom)
    if texture is not None:
        rgba = np.append(rgba[:3] * _texture(model, texture).mean(axis=(0, 1)) / 255.0, rgba[3])
    return np.round(255.0 * np.clip(rgba, 0.0, 1.0)).astype(np.uint8)


def _transform(position: NDArray[np.float64], quat_wxyz: NDArray[np.float64]) -> NDArray[np.float64]:
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, quat_wxyz)
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = rotation.reshape(3, 3), position
    return transform
