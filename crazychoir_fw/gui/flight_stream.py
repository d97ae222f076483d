"""The log of the page while the drones fly: the samples of a session, appended to a stream."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.flight.streamed import Flushes
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.recording.record_output import RecordOutput
from crazychoir_fw.recording.samples import Fields, Samples
from crazychoir_fw.recording.signals import EXTRA, POSE_FIELDS

if TYPE_CHECKING:
    from crazychoir_fw.gui.branches import Sample
    from crazychoir_fw.gui.session import Session


class SessionStream:
    """Writes what a session samples; variables that were plotted are in the log of an orderly end only."""

    def __init__(self, path: Path) -> None:
        """Begin the file.

        Args:
            path: Of the stream.

        Raises:
            OSError: If it cannot be written.
            StateError: If another page is writing it.
        """
        self.stream = LogStream(path)
        self._samples: Samples | None = None

    def sample(self, session: Session, time: float, sample: Sample) -> None:
        """Take a sample of a session, and write when it is time."""
        if self._samples is None:
            self._begin(session)
        self._add(time, sample)
        self._flushes.look()

    def begin_again(self, samples: Iterable[tuple[float, Sample]]) -> None:
        """Go on after a rewind: readers drop what was written before the past of the new branch."""
        if self._samples is not None:
            for time, sample in samples:
                self._add(time, sample)

    def close(self, remove: bool = False) -> None:
        """Write the rest, and no more; a file without a sample is removed."""
        if self._samples is not None and not remove:
            self._flushes.write()
        self.stream.close(remove or not self.stream.has_rows)

    def _begin(self, session: Session) -> None:
        access, experiment = session.access, session.experiment
        assert access is not None and experiment is not None  # it samples what flies
        group = "sim" if access.knows_truth else "stateEstimate"
        count = len(session.names)
        extra = [f"ctrltarget.{axis}" for axis in "xyz"]
        if group == "stateEstimate":
            extra += [f"stateEstimate.q{axis}" for axis in "xyzw"]
        shapes: Fields = {
            "time": ((), float),
            **{f"{group}/{name}": ((count, 4 if name == "orientation" else 3), float) for name in POSE_FIELDS},
            **{EXTRA + name: ((count,), np.float32) for name in extra},
        }
        self._group, samples = group, Samples(shapes)
        mission = session.mission
        about = {
            "mission": mission.name,
            "description": mission.description,
            "backend": mission.backend,
            "seed": mission.seed,
        }
        output = RecordOutput(self.stream, about)
        layout: dict[str, Any] = {"poses": [group], "extra": extra}

        def flush() -> None:
            output.begin(layout, samples, session.names)
            output.write(samples)

        self._samples = samples
        self._flushes = Flushes(self.stream, flush, lambda: experiment.events)

    def _add(self, time: float, sample: Sample) -> None:
        assert self._samples is not None
        row = self._samples.add()
        row["time"][...] = time
        for name in POSE_FIELDS:
            row[f"{self._group}/{name}"][:] = getattr(sample, name)
        for k, axis in enumerate("xyz"):
            row[f"{EXTRA}ctrltarget.{axis}"][:] = sample.reference[:, k]
        if self._group == "stateEstimate":
            for k, axis in enumerate("xyzw"):
                row[f"{EXTRA}stateEstimate.q{axis}"][:] = sample.orientation[:, k]
