"""Drones of a simulated world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.common.motor_logs import FULL_DUTY, MOTORS
from crazychoir_fw.flight.access.access import Access, DroneState, Variable
from crazychoir_fw.flight.sim_backend import truth
from crazychoir_fw.onboard.variables import factory_values, parameter_table
from crazychoir_fw.simulation.supervisor_resets import is_resetting
from crazychoir_fw.simulation.targets import Targets

if TYPE_CHECKING:
    from crazychoir_fw.mission.plan import Upload
    from crazychoir_fw.planning import Polynomial

_UPRIGHT = 0.9  # cosine of the tilt, below which a drone lies on its side
_TRAJECTORY = 1  # id of the one that the page uploads
_FLOOR_M = 0.1  # what is higher does not stand on the floor


class SimAccess(Access):
    """All of it is known here, the truth too."""

    has_software = True
    flies_plans = True

    def __init__(self, backend: Any) -> None:
        super().__init__(backend)
        self._world = backend.world
        self._drones = backend.world.drones
        self._truth = truth(backend.world)
        self._targets = Targets(backend.world.drones)

    def true_pose(self) -> Pose:
        """See `Access`."""
        return self._truth()

    def references(self) -> NDArray[np.float64] | None:
        """See `Access`."""
        return self._targets.positions()

    def state(self, index: int) -> DroneState:
        """See `Access`."""
        drone = self._drones[index]
        error = float(np.linalg.norm(drone.estimated_position - drone.true_position))
        radio = self.backend.radio
        return DroneState(
            supervisor=drone.supervisor_state,
            battery_v=float(drone.log["pm.vbat"]),
            estimate_error_m=error,
            link="simulated: perfect" if radio is None else "simulated radio",
            failure=drone.failure or "",
            motors=tuple(drone.log[name] / FULL_DUTY for name in MOTORS),
        )

    def batteries(self) -> NDArray[np.float64]:
        """See `Access`."""
        return np.array([drone.log["pm.vbat"] for drone in self._drones], float)

    def refusal(self, index: int) -> str | None:
        """See `Access`."""
        drone = self._drones[index]
        if drone.can_fly or drone.can_arm or is_resetting(drone):
            return None
        return f"{drone.id}: the motors may not run, state '{drone.supervisor_state}'; REBOOT helps"

    def cannot_follow(self, index: int) -> str | None:
        """See `Access`: the planner on board has a memory."""
        return None

    def arm(self, index: int, is_armed: bool) -> None:
        """See `Access`."""
        self._drones[index].arm(is_armed)

    def reboot(self, index: int) -> str:
        """Start the onboard software again; a drone that lies on its side is set upright, as a hand would do."""
        drone = self._drones[index]
        w, x, y, z = drone.true_quat_wxyz
        place = drone.true_position
        if 1.0 - 2.0 * (x * x + y * y) < _UPRIGHT and place[2] < 2 * _FLOOR_M:
            drone.place((place[0], place[1], 0.02), float(np.degrees(2.0 * np.arctan2(z, w))))
        elif place[2] > 2 * _FLOOR_M:
            raise StateError(f"{drone.id}: is {place[2]:.2f} m high; a drone is rebooted on the floor")
        drone.reboot()
        return "ready in 2 s"

    def parameters(self, index: int) -> list[Variable]:
        """See `Access`."""
        drone = self._drones[index]
        number = drone.provider_number
        table = parameter_table(number)
        defaults = factory_values(drone.config.platform, table, number)
        return [
            Variable(name, str(table[name].dtype), drone.param[name], bool(table[name].is_read_only), defaults[name])
            for name in sorted(table)
        ]

    def set_parameter(self, index: int, name: str, value: float) -> float:
        """See `Access`."""
        self._drones[index].param[name] = value
        return self._drones[index].param[name]

    def log_names(self) -> list[str]:
        """See `Access`."""
        return sorted(self._drones[0].log)

    def log_value(self, index: int, name: str) -> float:
        """See `Access`."""
        return float(self._drones[index].log[name])

    def console(self, index: int) -> str:
        """See `Access`."""
        return self._drones[index].console

    def begin_upload(self, index: int, curve: Polynomial) -> None:
        """See `Access`."""
        from crazychoir_fw.planning import to_pieces

        self._drones[index].high_level_commander.upload_trajectory(_TRAJECTORY, to_pieces(curve).rows)

    def fly_uploaded(self, index: int) -> None:
        """See `Access`."""
        self._drones[index].high_level_commander.start_trajectory(_TRAJECTORY)

    def upload_plan(self, uploads: Sequence[Upload]) -> None:
        """See `Access`."""
        for drone in self._drones:
            for upload in uploads:
                drone.high_level_commander.upload_trajectory(upload.number, upload.rows, offset=upload.offset)

    def command(self, index: int, verb: str, arguments: Mapping[str, Any]) -> None:
        """See `Access`."""
        getattr(self._drones[index].high_level_commander, verb)(**arguments)
