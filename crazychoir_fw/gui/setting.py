"""What does not change in a flight: drones, room, graph, safety area, and where the drones have been so far."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session

_TRAIL_S = 20.0
_SHAPES = {2: "sphere", 3: "capsule", 5: "cylinder", 6: "box"}  # of mjtGeom
_MAX_OBSTACLES = 300


def setting_of(session: Session) -> dict[str, Any]:
    """Return it as plain data."""
    mission, frame = session.mission, session.frame
    now = 0.0 if frame is None else frame.time
    area = mission.hardware.safety_area
    return {
        "mission": mission.name,
        "description": mission.description,
        "backend": f"{mission.backend} {session.access.where}".strip(),
        "names": session.names,
        "graph": session.graph,
        "obstacles": obstacles(session),
        "safety_area": None if area is None else {"low": list(area.low), "high": list(area.high)},
        "log_names": session.access.log_names(),
        "trail": session.branches.path(session.branches.present.number, now - _TRAIL_S),
        "missing": session.access.missing(),
        "is_real_time": session.experiment.backend.is_real_time,
        "has_software": session.access.has_software,
        "height": mission.layers.guidance.height,
    }


def obstacles(session: Session) -> list[dict[str, Any]]:
    """Return what stands in the room: shape, half sizes (m), place (m, world), attitude (wxyz), color."""
    world = getattr(session.experiment.backend, "world", None)
    if world is None:
        return []
    import mujoco

    model, data = world.model, world.data
    drones = {int(model.body(name).id) for name in session.names}
    found = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        shape = _SHAPES.get(int(model.geom_type[geom]))
        root = int(model.body_rootid[body])
        if shape is None or body in drones or root in drones or model.geom_rgba[geom, 3] < 0.05:
            continue
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, data.geom_xmat[geom])
        color = model.geom_rgba[geom]
        if model.geom_matid[geom] >= 0:
            color = model.mat_rgba[model.geom_matid[geom]]
        found.append(
            {
                "shape": shape,
                "size": np.round(model.geom_size[geom], 4).tolist(),
                "position": np.round(data.geom_xpos[geom], 4).tolist(),
                "quat": np.round(quat, 5).tolist(),
                "color": np.round(color, 3).tolist(),
            }
        )
        if len(found) >= _MAX_OBSTACLES:
            break
    return found
