"""Places that explain a flight to its viewers: targets, intruders, tasks, loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.mission.roles import metrics_of
from crazychoir_fw.recording.marks import COLORS

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session

_KINDS = ("tasks", "requests", "assigned", "picked", "completed", "returned", "lost_loads")


class Marks:
    """What is marked at present; asked for between two rounds."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._metrics = metrics_of(session.mission)
        self._fixed = [
            {
                "position": mark.position.tolist(),
                "label": mark.label or mark.kind,
                "color": COLORS.get(mark.kind, "#888888"),
            }
            for one in self._metrics
            for mark in one.marks(None)
        ]
        self._looked_at: tuple[int, float] = (0, 0.0)
        self._found: list[dict[str, Any]] = []

    def now(self) -> list[dict[str, Any]]:
        """Return place (m, world), label, color or drone, and another place that belongs to it, of each."""
        happened = self._session.experiment.events
        newest = happened[-1].time if happened else 0.0
        if (len(happened), newest) != self._looked_at:
            self._looked_at = (len(happened), newest)
            self._found = self._works(newest)
        return [*self._fixed, *self._found]

    def _works(self, newest: float) -> list[dict[str, Any]]:
        events = [event.as_dict() for event in self._session.experiment.events if event.kind in _KINDS]
        # whatever is not over by then is there now
        end = newest + 1.0
        timelines = [one.timeline(events, self._session.names, end) for one in self._metrics] if events else []
        return [
            {
                "position": np.round(mark.position, 3).tolist(),
                "label": mark.label,
                "drone": mark.drone,
                "link": None if mark.link is None else np.round(mark.link, 3).tolist(),
            }
            for timeline in timelines
            for mark in (() if timeline is None else timeline.marks)
            if mark.end >= end
        ]
