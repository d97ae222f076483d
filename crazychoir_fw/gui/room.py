"""What stands in the room of a simulated flight, as shapes that a page can draw; some of it may move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from crazychoir_fw.simulation import World

_SHAPES = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}  # of mjtGeom
_MAX_THINGS = 300
_SEEN_GROUPS = 3  # MuJoCo's viewers show the groups 0 to 2


class Room:
    """The bodies of a world but for its drones.

    Attributes:
        things: Of each geom the shape, half sizes (m), place (m), attitude (wxyz), color, and ``body``: a row of
            `poses`, in whose frame it is, or None for one that stands in the world. Floors without end are left out.
    """

    def __init__(self, world: World | None, names: Sequence[str] = ()) -> None:
        """Look at a world; None is an empty room.

        Args:
            world: The world.
            names: Bodies of the drones.
        """
        self.things: list[dict[str, Any]] = []
        self._moving: list[int] = []
        self._world = world
        if world is None:
            return
        model = world.model
        drones = {int(model.body(name).id) for name in names}
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            if not drones & {body, int(model.body_rootid[body])} and _is_seen(model, geom):
                self.things.append(self._thing(geom, body))
            if len(self.things) >= _MAX_THINGS:
                break

    def _thing(self, geom: int, body: int) -> dict[str, Any]:
        model, data = self._world.model, self._world.data  # type: ignore[union-attr]
        moves = model.body_weldid[body] != 0 or model.body_mocapid[body] >= 0
        place, quat, row = data.geom_xpos[geom], np.zeros(4), None
        if moves:
            if body not in self._moving:
                self._moving.append(body)
            place, quat, row = model.geom_pos[geom], model.geom_quat[geom], self._moving.index(body)
        else:
            mujoco.mju_mat2Quat(quat, data.geom_xmat[geom])
        thing = {
            "shape": _SHAPES[int(model.geom_type[geom])],
            "size": np.round(model.geom_size[geom], 4).tolist(),
            "position": np.round(place, 4).tolist(),
            "quat": np.round(quat, 5).tolist(),
            "color": np.round(_color(model, geom), 3).tolist(),
            "body": row,
        }
        if thing["shape"] == "mesh":
            thing["corners"] = np.round(_triangles(model, int(model.geom_dataid[geom])).ravel(), 4).tolist()
        return thing

    def poses(self) -> NDArray[np.float64]:
        """Return where the bodies that may move are (m, world) and their attitudes (xyzw), shape (M, 7)."""
        if not self._moving:
            return np.zeros((0, 7))
        data = self._world.data  # type: ignore[union-attr]
        return np.hstack([data.xpos[self._moving], np.roll(data.xquat[self._moving], -1, axis=1)])


def _is_seen(model: mujoco.MjModel, geom: int) -> bool:
    kind = _SHAPES.get(int(model.geom_type[geom]))
    is_endless = kind == "plane" and not model.geom_size[geom, :2].all()
    return bool(kind and not is_endless and model.geom_group[geom] < _SEEN_GROUPS and _color(model, geom)[3] >= 0.05)


def _color(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """Return the color of a geom, that of its texture on the average, shape (4,)."""
    material, color = int(model.geom_matid[geom]), model.geom_rgba[geom].astype(float)
    if material < 0:
        return color
    if np.array_equal(color, [0.5, 0.5, 0.5, 1.0]):  # a color that was given wins over that of the material
        color = model.mat_rgba[material].astype(float)
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture >= 0:
        height, width, channels = (int(of[texture]) for of in (model.tex_height, model.tex_width, model.tex_nchannel))
        pixels = model.tex_data[model.tex_adr[texture] :][: height * width * channels].reshape(-1, channels)
        color[:3] *= pixels[:, :3].mean(axis=0) / 255.0
    return color


def _triangles(model: mujoco.MjModel, mesh: int) -> NDArray[np.float64]:
    """Return the corners of the triangles of a mesh (m, in its frame), shape (T, 3, 3)."""
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return model.mesh_vert[model.mesh_vertadr[mesh] + faces]
