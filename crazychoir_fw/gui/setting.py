"""What does not change in a flight: drones, room, graph, safety area, and where the drones have been so far."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from crazychoir_fw.gui.mission_run import cannot_run, starts_something, steps_of
from crazychoir_fw.onboard.descriptions import describe_variable

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session

_TRAIL_S = 20.0


def setting_of(session: Session) -> dict[str, Any]:
    """Return it as plain data."""
    mission, frame = session.mission, session.frame
    now = 0.0 if frame is None else frame.time
    area = mission.hardware.safety_area
    return {
        "mission": mission.name,
        "description": mission.description,
        "is_watched": False,
        "backend": f"{mission.backend} {session.access.where}".strip(),
        "names": session.names,
        "graph": session.graph,
        "obstacles": session.room.things,
        "safety_area": None if area is None else {"low": list(area.low), "high": list(area.high)},
        "log_names": session.access.log_names(),
        "log_about": {name: describe_variable(name, "logs") for name in session.access.log_names()},
        "trail": session.branches.path(session.branches.present.number, now - _TRAIL_S),
        "missing": {**session.access.missing(), **_missing_buttons(session)},
        "phases": [step.name for step in steps_of(mission)],
        "is_real_time": session.experiment.backend.is_real_time,
        "has_software": session.access.has_software,
        "height": mission.layers.guidance.height,
    }


def _missing_buttons(session: Session) -> dict[str, str]:
    """Return why the page lacks the buttons ``mission`` and ``start``, a sentence each."""
    found = {"mission": cannot_run(session.mission, session.access)}
    if not starts_something(session.mission):
        found["start"] = "the guidance of these drones begins nothing of its own"
    return {name: reason for name, reason in found.items() if reason}
