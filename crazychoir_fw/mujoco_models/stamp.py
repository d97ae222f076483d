"""Place many drones of one airframe into a world, with one copy of its meshes.

`MjSpec.attach` copies every mesh, texture and material once per drone: 1000 drones took 12 s and 1.4 GB to build.
A stamp attaches the airframe once, keeps what it reads there and prints it 1000 times: 0.6 s and 40 MB.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.mujoco_models import model_path

__all__ = ["Airframe", "VehicleStamp"]

_GEOM_FIELDS = (
    *("type", "size", "pos", "quat", "meshname", "material", "rgba", "group", "mass"),
    *("contype", "conaffinity", "condim", "priority", "friction", "solref", "solimp", "margin", "gap"),
)
_VISUAL_GROUP = 2
_INERTIA_FIELDS = ("mass", "inertia", "ipos", "iquat", "explicitinertial")


def _fields(element: object, names: Sequence[str]) -> dict[str, object]:
    """Return copies of the named attributes: arrays of a spec are views that die with their element."""
    values = {name: getattr(element, name) for name in names}
    return {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values.items()}


@dataclass(frozen=True)
class Airframe:
    """What a drone of a platform has by itself."""

    rest_height: float
    """Of a landed drone's body (m)."""
    mass: float
    """kg."""
    inertia: NDArray[np.float64]
    """Diagonal (kg m^2), shape (3,)."""


class VehicleStamp:
    """An airframe ready to be placed any number of times into one `MjSpec`.

    Args:
        spec: World that the drones go into; it receives the meshes and materials of the airframe.
        vehicle: Platform of the airframe, a key of `VEHICLES`.
        visuals: False leaves out the geoms that are only seen: each costs the physics 0.03 us per drone and step.
    """

    def __init__(self, spec: mujoco.MjSpec, vehicle: str, visuals: bool = True) -> None:
        self._spec = spec
        path = model_path(vehicle)
        child = mujoco.MjSpec.from_file(str(path))
        # absolute, so that the world can be saved with to_xml() and read again from anywhere
        for asset in (*child.meshes, *child.textures):
            asset.file = str(path.parent / "assets" / asset.file)
        self.rest_height = float(child.body("crazyflie").pos[2])
        """Height of the body origin over the floor of a landed drone (m)."""

        frame = spec.worldbody.add_frame()
        spec.attach(child, prefix=f"{vehicle}/", frame=frame)
        body = spec.body(f"{vehicle}/crazyflie")
        self._inertia = _fields(body, _INERTIA_FIELDS)
        self._geoms = {
            geom.name.removeprefix(f"{vehicle}/"): _fields(geom, _GEOM_FIELDS)
            for geom in body.geoms
            if visuals or geom.group != _VISUAL_GROUP
        }
        spec.delete(body)
        spec.delete(frame)

    def airframe(self) -> Airframe:
        """Return what every drone of this airframe has by itself."""
        return Airframe(self.rest_height, float(self._inertia["mass"]), np.array(self._inertia["inertia"]))  # type: ignore[arg-type]

    def place(
        self,
        name: str,
        position: Sequence[float],
        *,
        quat_wxyz: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        rgba: Sequence[float] | None = None,
    ) -> mujoco.MjsBody:
        """Add one drone: a body called by its name, its joint `<name>/root`, its geoms `<name>/accent`, ...

        Args:
            name: Unique name of the drone.
            position: Start of the body origin (m, world frame), shape (3,).
            quat_wxyz: Start attitude.
            rgba: Color of the accent, each in [0, 1]; that of the airframe's file if left out.

        Returns:
            The new body, to which a plugin, a camera or a payload may be added.
        """
        body = self._spec.worldbody.add_body(name=name, pos=position, quat=quat_wxyz, **self._inertia)
        body.add_freejoint(name=f"{name}/root")
        for part, fields in self._geoms.items():
            geom = body.add_geom(name=f"{name}/{part}", **fields)
            if part == "accent" and rgba is not None:
                geom.rgba = rgba
        return body
