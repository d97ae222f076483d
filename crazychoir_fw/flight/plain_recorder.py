"""The log of drones that have no onboard software to be asked: poses, and what the layers said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.recording.record_output import RecordOutput
from crazychoir_fw.recording.samples import Samples
from crazychoir_fw.recording.signals import EXTRA, POSE_FIELDS, signals_of

Array = NDArray[np.float64]

TOLD, TRUE = "stateEstimate", "sim"


class PlainRecorder:
    """Collects samples under the names of the onboard log.

    ``stateEstimate.*`` is the pose that the layers received, ``sim.*`` the truth where there is one.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """Prepare.

        Args:
            names: The drones.
        """
        self._names = list(names)
        self._samples: Samples | None = None  # its fields are known at the first sample
        self._groups: list[str] = []
        self._extra: list[str] = []
        self._output: RecordOutput | None = None

    def sample(self, time: float, told: Pose, true: Pose | None, extra: Mapping[str, Array]) -> None:
        """Take one sample; the arrays of the poses are (N, ...). Truth and names of further signals come always."""
        poses = {TOLD: told} if true is None else {TOLD: told, TRUE: true}
        values = {f"{group}/{name}": getattr(pose, name) for group, pose in poses.items() for name in POSE_FIELDS}
        if self._samples is None:
            self._groups, self._extra = list(poses), list(extra)
            shapes = {name: (np.shape(value), np.asarray(value).dtype) for name, value in values.items()}
            more = {EXTRA + name: (np.shape(value), np.float32) for name, value in extra.items()}
            self._samples = Samples({"time": ((), float), **shapes, **more})
        row = self._samples.add()
        row["time"][...] = time
        for name, value in values.items():
            row[name][:] = value
        for name in self._extra:
            row[EXTRA + name][:] = extra[name]

    @property
    def times(self) -> Array:
        """Time of each sample (s), shape (T,)."""
        return np.empty(0) if self._samples is None else self._samples.column("time")

    def write_to(self, stream: LogStream, metadata: Mapping[str, Any]) -> None:
        """Have `flush` move samples to a stream, see `FlightRecorder.write_to`."""
        self._output = RecordOutput(stream, metadata)

    def flush(self) -> None:
        """Move what was recorded since the last call to the stream, if there is one."""
        if self._output is not None and self._samples is not None:
            self._output.begin(self._layout(), self._samples, self._names)
            self._output.write(self._samples)

    def _layout(self) -> dict[str, Any]:
        return {"poses": self._groups, "extra": self._extra}

    def finish(self, metadata: dict[str, Any]) -> FlightLog:
        """Return everything recorded so far."""
        signals = {} if self._samples is None else signals_of(self._layout(), self._samples.column)
        return FlightLog(self.times, self._names, signals, metadata)
