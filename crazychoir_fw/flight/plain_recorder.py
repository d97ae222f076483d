"""The log of drones that have no onboard software to be asked: poses, and what the layers said."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.attitude import rotation_of_quaternion, rpy_of_rotation
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.recording.flight_log import FlightLog

Array = NDArray[np.float64]


class PlainRecorder:
    """Collects samples under the names of the onboard log.

    ``stateEstimate.*`` is what the layers were told, ``sim.*`` the truth where there is one.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """Prepare.

        Args:
            names: The drones.
        """
        self._names = list(names)
        self._times: list[float] = []
        self._told: list[Pose] = []
        self._true: list[Pose | None] = []
        self._extra: list[dict[str, Array]] = []

    def sample(self, time: float, told: Pose, true: Pose | None, extra: dict[str, Array]) -> None:
        """Take one sample; the arrays of the poses are (N, ...)."""
        self._times.append(time)
        self._told.append(told)
        self._true.append(true)
        self._extra.append(extra)

    @property
    def times(self) -> Array:
        """Time of each sample (s), shape (T,)."""
        return np.array(self._times)

    def finish(self, metadata: dict[str, Any]) -> FlightLog:
        """Return everything recorded so far."""
        signals = motion_signals("stateEstimate", self._told)
        if self._true and self._true[0] is not None:
            signals |= motion_signals("sim", [pose for pose in self._true if pose is not None])
        for name in self._extra[0] if self._extra else ():
            signals[name] = np.array([sample[name] for sample in self._extra], np.float32)
        return FlightLog(self.times, self._names, signals, metadata)


def motion_signals(group: str, poses: Sequence[Pose]) -> dict[str, Array]:
    """Return positions (m), velocities (m/s) and angles (deg) as signals, (T, N) each; the poses are (N, ...)."""
    signals = {}
    for prefix, part in (("", "position"), ("v", "velocity")):
        values = np.array([getattr(pose, part) for pose in poses])
        for k, axis in enumerate("xyz"):
            signals[f"{group}.{prefix}{axis}"] = values[..., k].astype(np.float32)
    angles = np.degrees(rpy_of_rotation(rotation_of_quaternion(np.array([pose.orientation for pose in poses]))))
    # the pitch of the onboard log is positive for a nose that rises
    for k, (name, sign) in enumerate((("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))):
        signals[f"{group}.{name}"] = (sign * angles[..., k]).astype(np.float32)
    return signals
