"""Tasks and deliveries of a flight, from what happened in it, as pictures and films show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crazychoir_fw.recording.marks import Mark, TaskInterval, TaskTimeline


@dataclass
class _Work:
    """One task, or one half of a delivery, with all that became of it."""

    label: str
    position: np.ndarray
    begin: float
    end: float | None = None
    owner: int | None = None
    since: float = field(init=False)
    link: np.ndarray | None = None
    worked_on_since: float = -np.inf  # a delivery begins when the load is on board
    marks: list[Mark] = field(default_factory=list)
    intervals: list[TaskInterval] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.since = self.begin

    def hand_to(self, drone: int | None, now: float) -> None:
        """Change the owner from now on; None: no drone owns it."""
        if self.end is None and drone != self.owner:
            self._mark_until(now, False)
            self.owner, self.since = drone, now

    def close(self, now: float, is_finished: bool, by: int | None = None) -> None:
        """Done, or taken back."""
        if self.end is None:
            if is_finished and by is not None:
                self.hand_to(by, now)
            self._mark_until(now, is_finished)
            self.end = now

    def _mark_until(self, now: float, is_finished: bool) -> None:
        """Add a mark of the time since the last change, with the owner of that time."""
        if now > self.since:
            self.marks.append(Mark(self.position, self.label, self.since, now, self.owner, self.link))
            busy = max(self.since, self.worked_on_since)
            if self.owner is not None and now > busy:
                self.intervals.append(TaskInterval(self.owner, busy, now, self.label, is_finished))


def timeline_of(events: Sequence[Mapping[str, Any]], drones: Sequence[str], end: float) -> TaskTimeline | None:
    """Return marks and intervals of tasks or deliveries; None if there were none.

    Args:
        events: Of the flight log.
        drones: Names of the drones.
        end: When the flight was over (s).
    """
    works: dict[Any, _Work] = {}
    is_delivery = any(event["kind"] == "requests" for event in events)
    for event in events:
        drone = drones.index(event["drone"]) if event["drone"] in drones else None
        _tell(works, event["kind"], float(event["time"]), drone, event["details"], is_delivery)
    if not works:
        return None
    for work in works.values():
        work.close(end, False)
    marks = [mark for work in works.values() for mark in work.marks]
    intervals = [interval for work in works.values() for interval in work.intervals]
    return TaskTimeline(marks, intervals, "deliveries" if is_delivery else "tasks")


def _tell(works: dict[Any, _Work], kind: str, now: float, drone: int | None, details: Any, is_delivery: bool) -> None:
    """Take an event."""
    if kind == "tasks":
        for _, sequence, x, y, _ in details["tasks"]:
            works[sequence] = _Work(str(sequence), np.array([x, y, 0.0]), now)
    elif kind == "requests":
        for number, x, y, to_x, to_y, _ in details["requests"]:
            source, sink = np.array([x, y, 0.0]), np.array([to_x, to_y, 0.0])
            works[number, False] = _Work(f"{number}", source, now, link=sink)
            works[number, True] = _Work(f"→{number}", sink, now, worked_on_since=np.inf)
    elif kind == "assigned":
        _assign(works, drone, details["takes"], now)
    elif kind == "picked":
        works[details["number"], False].close(now, True, drone)
        works[details["number"], True].worked_on_since = now
    elif kind == "completed":
        works[(details["number"], True) if is_delivery else details["number"]].close(now, True, drone)
    elif kind in ("returned", "lost_loads"):
        for number in details["numbers"]:
            for key in ((number, False), (number, True)) if is_delivery else (number,):
                works[key].close(now, False)


def _assign(works: Mapping[Any, _Work], drone: int | None, takes: Sequence[int], now: float) -> None:
    for key, work in works.items():
        number = key[0] if isinstance(key, tuple) else key
        if number in takes:
            work.hand_to(drone, now)
        elif work.owner == drone and drone is not None:
            work.hand_to(None, now)
