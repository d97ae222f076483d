"""Drones of a flight whose processes talk over ROS 2; what its topics do not carry is refused in a sentence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.flight.access.access import Access, DroneState, Variable

_VOLTAGE = "pm.vbat"
NO_TIME = (
    "Over ROS 2 time cannot be turned back, paused or hurried from the page: drones and layers are processes of their "
    "own. Without --ros it can."
)
NO_PARAMETERS = (
    "Over ROS 2 no topic or service carries parameters of the onboard software; ros2 param reads those of layers. "
    "Without --ros they are here."
)
NO_ARM = (
    "Nobody on this ROS domain arms, disarms or reboots drones: point masses have nothing to arm, and a simulation "
    "without a host of ours no service for it."
)
FEW_PLOTS = "Over ROS 2 plots are of odometry and battery: no topic carries log variables of the onboard software."
NO_MEMORY = "over ROS 2 only drones with layers.planning take a drawn curve; the trajectory memory on board is no topic"


class RosAccess(Access):
    """What the topics of a flight tell; the backend is that of `crazychoir_fw.ros.joined_flight`."""

    no_rewind = NO_TIME
    no_speed = NO_TIME
    has_software = True

    @property
    def where(self) -> str:
        """See `Access`."""
        return f"over ROS 2, domain {self.backend.domain}"

    def missing(self) -> dict[str, str]:
        """See `Access`."""
        words = {"parameters": NO_PARAMETERS, "plots": FEW_PLOTS}
        return words if self.backend.is_cared_for else {"arm": NO_ARM, **words}

    def state(self, index: int) -> DroneState:
        """See `Access`."""
        return self.backend.state(index)

    def batteries(self) -> NDArray[np.float64]:
        """See `Access`."""
        return np.array([self.backend.state(i).battery_v for i in range(len(self.names))])

    def cannot_follow(self, index: int) -> str | None:
        """See `Access`."""
        return f"{self.names[index]}: {NO_MEMORY}"

    def arm(self, index: int, is_armed: bool) -> None:
        """See `Access`."""
        self._check_care()
        self.backend.arm(index, is_armed)

    def reboot(self, index: int) -> str:
        """See `Access`."""
        self._check_care()
        return self.backend.reboot(index)

    def stop_now(self, indices: list[int]) -> None:
        """See `Access`; sends STOP without waiting for the response of a service."""
        self.backend.stop_now(indices)

    def _check_care(self) -> None:
        if not self.backend.is_cared_for:
            raise StateError(NO_ARM)

    def parameters(self, index: int) -> list[Variable]:
        """See `Access`."""
        raise StateError(NO_PARAMETERS)

    def set_parameter(self, index: int, name: str, value: float) -> float:
        """See `Access`."""
        raise StateError(NO_PARAMETERS)

    def log_names(self) -> list[str]:
        """See `Access`."""
        return [*super().log_names(), _VOLTAGE]

    def log_value(self, index: int, name: str) -> float:
        """See `Access`."""
        if name == _VOLTAGE:
            return self.backend.state(index).battery_v
        if name not in super().log_names():
            raise UnknownNameError(f"{self.names[index]}: {name}: {FEW_PLOTS}")
        return super().log_value(index, name)
