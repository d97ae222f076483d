"""What browsers receive twice a second of a flight that they may command: cards, marks, branches."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.gui.marks import Marks
from crazychoir_fw.gui.preflight import preflight

if TYPE_CHECKING:
    from crazychoir_fw.gui.drawings import Drawings
    from crazychoir_fw.gui.session import Session


class Words:
    """Says what changes slowly; asked in the loop of the server."""

    def __init__(self, session: Session, drawings: Drawings) -> None:
        self._session = session
        self._drawings = drawings
        self._marks: Marks | None = None

    async def __call__(self) -> dict[str, Any]:
        """Return what changes slowly."""
        session = self._session
        words: dict[str, Any] = {
            "speed": session.speed,
            "error": session.error,
            "ready": session.is_ready,
            "drawings": self._drawings.version,
            "branch": session.branches.present.number,
            "branches": session.branches.about(),
            "no_rewind": session.no_rewind,
            "flying": None,
            "dry_run": session.dry_share,
        }
        flying = session.flying
        if flying is not None:
            words["flying"] = {"name": flying.name, "phase": flying.phase, "started": flying.started,
                               "duration": round(flying.duration, 1)}  # fmt: skip
        if session.is_ready and session.error is None:
            try:
                if self._marks is None:
                    self._marks = Marks(session)
                marks = self._marks
                told = session.ask(lambda: (_cards(session), marks.now(), _before_flight(session)))
                words["cards"], words["marks"], words["preflight"] = await asyncio.wait_for(
                    asyncio.wrap_future(told), 2.0
                )
            except (CrazychoirError, TimeoutError, asyncio.TimeoutError):
                pass  # a flight that makes real drones ready answers later
        return words


def _before_flight(session: Session) -> list[dict[str, Any]] | None:
    """Return the list of checks, while no drone flies."""
    return None if any(agent.is_up for agent in session.experiment.agents) else preflight(session)


def _finite(*values: float) -> list[float] | None:
    """Return numbers in hundredths for browsers, or None where one is unknown."""
    return [round(float(value), 2) for value in values] if np.isfinite(values).all() else None


def _cards(session: Session) -> list[dict[str, Any]]:
    session.listen_to_consoles()
    poses = session.experiment.backend.poses()
    places, speeds = np.asarray(poses.position), np.linalg.norm(np.asarray(poses.velocity), axis=1)
    cards = []
    for agent in session.experiment.agents:
        state = session.access.state(agent.index)
        guidance = getattr(getattr(agent.guidance, "phase", None), "value", "")
        cards.append(
            {
                "phase": agent.phase.value,
                "guidance": f"{type(agent.guidance).__name__} {guidance}".strip(),
                "supervisor": state.supervisor,
                "place": _finite(*places[agent.index]),
                "speed": _finite(speeds[agent.index]),
                "battery": round(state.battery_v, 3) if math.isfinite(state.battery_v) else None,
                "estimate_error": round(state.estimate_error_m, 4) if math.isfinite(state.estimate_error_m) else None,
                "link": state.link,
                "motors": [round(duty, 2) for duty in state.motors],
                "failure": agent.failure or state.failure,
            }
        )
    return cards
