"""What explains a flight beside its poses: title, phases, faults and events, marks, links and colors.

A storyboard is made of the metadata and events of a log, so that a film or a plot needs nothing but the log.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.marks import Mark

SHOWN_S = 3.0
"""How long a film shows what happens in an instant (s)."""

_FAULT = "fault"
_TROUBLE = ("failure", "lost", "rejoined", "stale", "heard_again", "crashed", "stop")
"""Kinds of events that are shown as they are."""

_WORDS = {"go_to": "go to", "takeoff": "take off"}


@dataclass(frozen=True)
class Window:
    """A phase of a flight."""

    name: str
    begin: float
    """(s)"""
    end: float
    """(s)"""


@dataclass(frozen=True)
class Note:
    """Something that went wrong, or happened, and for how long it is worth a look."""

    text: str
    begin: float
    """(s)"""
    end: float
    """(s)"""
    drone: str | None = None


@dataclass(frozen=True)
class Storyboard:
    """What explains a flight."""

    title: str = ""
    windows: Sequence[Window] = ()
    notes: Sequence[Note] = ()
    marks: Sequence[Mark] = ()
    links: Sequence[tuple[int, int]] = ()
    """Drones that talk to each other, by number."""
    leaders: frozenset[int] | None = None
    """Numbers of drones that are shown red, all others being blue; None leaves colors alone."""

    @classmethod
    def of(cls, log: FlightLog) -> Storyboard:
        """Return the storyboard of a log.

        Raises:
            ValueError: If its metadata is none.
        """
        about, known = log.metadata, log.metadata.get("pictures", {})
        try:
            leaders, count = known.get("leaders"), len(log.drone_ids)
            links = [(int(first), int(second)) for first, second in known.get("links", ())]
            marks = [Mark.from_dict(entry) for entry in known.get("marks", ())]
            _check_numbers([*(k for pair in links for k in pair), *(mark.drone for mark in marks)], count)
            return cls(
                str(about.get("description") or about.get("mission") or ""),
                [Window(str(name), float(begin), float(end)) for name, begin, end in about.get("windows", ())],
                notes_of(log.events, float(log.time[-1]) if len(log.time) else 0.0),
                marks,
                links,
                None if leaders is None else frozenset(int(number) for number in leaders),
            )
        except (TypeError, AttributeError, KeyError) as error:
            raise ValueError(f"the metadata of the log does not explain the flight: {error}") from error


def _check_numbers(numbers: Iterable[int | None], count: int) -> None:
    """Refuse numbers of drones that are not there; None is no drone's."""
    if any(number is not None and not 0 <= number < count for number in numbers):
        raise ValueError(f"a drone has a number outside 0 to {count - 1}")


def words_of(phase: str) -> str:
    """Return the name of a phase for people."""
    return _WORDS.get(phase, phase.replace("_", " "))


def notes_of(events: Iterable[Mapping[str, Any]], end: float) -> list[Note]:
    """Return what is worth a note among the events of a log, in order.

    Args:
        events: As in `FlightLog.events`.
        end: When the flight was over (s): what goes on until then.
    """
    notes: list[Note] = []
    running: dict[tuple[Any, ...], int] = {}
    for event in events:
        kind, drone, time = event["kind"], event.get("drone"), float(event["time"])
        details = event.get("details") or {}
        if kind == _FAULT:
            key = (drone, details.get("fault"))
            if details.get("state") == "ends" and key in running:
                place = running.pop(key)
                notes[place] = Note(notes[place].text, notes[place].begin, time, drone)
            elif details.get("state") in ("begins", "happens"):
                goes_on = details["state"] == "begins"
                if goes_on:
                    running[key] = len(notes)
                notes.append(Note(_fault_text(details), time, end if goes_on else time + SHOWN_S, drone))
        elif kind == "collision" and details.get("what") != "floor":
            notes.append(Note(f"hits {details.get('other')}", time, time + SHOWN_S, drone))
        elif kind == "collision":
            notes.append(Note("hits the floor", time, time + SHOWN_S, drone))
        elif kind in _TROUBLE:
            notes.append(Note(words_of(str(kind)), time, time + SHOWN_S, drone))
    return _without_repetition(notes)


def _without_repetition(notes: Iterable[Note]) -> list[Note]:
    """Return the notes without those that say the same of the same drone while an earlier one is shown."""
    shown: dict[tuple[str | None, str], float] = {}
    kept = []
    for note in notes:
        key = (note.drone, note.text)
        if note.begin >= shown.get(key, -math.inf):
            kept.append(note)
            shown[key] = note.end
    return kept


def _fault_text(details: Mapping[str, Any]) -> str:
    """Return a fault in a few words, such as `motor 2` or `gust, velocity 0 3 0`."""
    words = [str(details.get("fault", "fault"))]
    if words[0] == "motor" and details.get("efficiency") is None:
        return f"motor {_figure(details.get('motor'))} stops"
    for key, value in details.items():
        if key in ("fault", "state", "duration") or value is None or value is False:
            continue
        if value is True:
            words.append(key)
        elif key == words[0]:
            words[0] = f"{key} {_figure(value)}"
        else:
            words.append(f"{key} {_figure(value)}")
    return ", ".join(words)


def _figure(value: Any) -> str:
    if isinstance(value, list | tuple):
        return " ".join(_figure(item) for item in value)
    return f"{value:g}" if isinstance(value, int | float) else str(value)
