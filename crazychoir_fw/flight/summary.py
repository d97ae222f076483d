"""The content of `summary.json`, the same for simulated and real flights."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.onboard.core import identity

if TYPE_CHECKING:
    from crazychoir_fw.flight.backend import Backend
    from crazychoir_fw.flight.criteria import Judge
    from crazychoir_fw.flight.event import Event
    from crazychoir_fw.guidance.metrics import Verdict
    from crazychoir_fw.mission.schema import Mission
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.simulation.events import Event as WorldEvent


@dataclass(frozen=True)
class Assessment:
    """Figures and failures of a flight."""

    drones: Sequence[dict[str, Any]]
    """Figures of each drone, in the order of the mission."""
    failures: list[str]
    """What went wrong, one sentence each."""
    expected: list[str]
    """What went wrong with drones that may fail, one sentence each."""
    shares: Mapping[str, float]
    """Time that each part took on this machine (s)."""
    criteria: Sequence[Verdict] = ()
    """How the flight did by each criterion that was asked for."""
    swarm: Mapping[str, Any] = field(default_factory=dict)
    """Figures of all drones together."""
    events: Sequence[Event] = ()
    """What happened in the layers, in order."""
    communication: dict[str, Any] | None = None
    """What communicators have seen, if there are some."""
    judge: Judge | None = None
    """Where the figures come from, if layers flew: for pictures and films."""


def collision_failures(mission: Mission, events: Sequence[WorldEvent]) -> list[tuple[str, str]]:
    """Return the collisions that a mission does not forgive, each with its drone and a sentence.

    Those with drones and obstacles that were faster than `tolerance.collision_speed` are. How a drone came down on a
    floor is judged by its supervisor and by the place where it ends.
    """
    return [
        (
            event.drone or "",
            f"{event.drone}: hit {event.details['other']} with {event.details['speed']:.2f} m/s at {event.time:.2f} s, "
            f"tolerance {mission.tolerance.collision_speed:g} m/s",
        )
        for event in events
        if event.kind == "collision"
        and event.details["what"] != "floor"
        and event.details["speed"] > mission.tolerance.collision_speed
    ]


def summarize(
    mission: Mission, backend: Backend, log: FlightLog, assessment: Assessment, flown: float, wall_seconds: float
) -> dict[str, Any]:
    """Return the content of summary.json.

    `collisions` lists what drones hit, and how fast (see `crazychoir_fw.simulation.collisions`), `expected_failures`
    are those of drones that may fail, `faults` what was planned to go wrong, in times of the world. `providers` says
    once per provider what it was built from. What only simulated drones have is missing elsewhere.

    Args:
        mission: What was flown.
        backend: Where the drones were.
        log: Its log.
        assessment: What came of it.
        flown: How long it took (s, of the flight).
        wall_seconds: How long it took (s, wall).
    """
    world = getattr(backend, "world", None)
    simulated = {} if world is None else {drone.id: drone for drone in world.drones}
    summary = {
        "mission": mission.name,
        "backend": mission.backend,
        "platform": ", ".join(sorted({drone.platform for drone in mission.fleet})),
        "seed": mission.seed,
        "success": not assessment.failures,
        "failures": assessment.failures,
        "sim_seconds": rounded(flown),
        "wall_seconds": rounded(wall_seconds),
        "real_time_factor": rounded(flown / wall_seconds if wall_seconds > 0.0 else math.nan),
        "criteria": [verdict.as_dict() for verdict in assessment.criteria],
        **assessment.swarm,
        "drones": [
            {"id": drone.id, **figures, **_onboard(simulated.get(drone.id))}
            for drone, figures in zip(mission.fleet, assessment.drones, strict=True)
        ],
        "events": [event.as_dict() for event in assessment.events],
        "collisions": _collisions(() if world is None else world.events),
        "shares": {name: rounded(value) for name, value in assessment.shares.items()},
        "build": identity(),
        "expected_failures": assessment.expected,
        "faults": getattr(backend, "faults", []),
    }
    if world is not None:
        summary["provider"] = ", ".join(sorted({drone.config.provider for drone in world.drones}))
        summary["providers"] = log.metadata.get("providers", [])
    if assessment.communication is not None:
        summary["communication"] = assessment.communication
    if (mirror := getattr(backend, "mirror", None)) is not None:
        summary["mirrored"] = mirror.report()
        summary["behind_s"] = rounded(backend.behind_s)  # type: ignore[attr-defined]
    if (radio := getattr(backend, "radio", None)) is not None:
        summary["link"] = radio.link.statistics()
    return summary


def _collisions(events: Sequence[WorldEvent]) -> list[dict[str, Any]]:
    """Return what drones hit, among the events of their world."""
    return [
        {"time": rounded(event.time), "drone": event.drone, **event.details}
        for event in events
        if event.kind == "collision"
    ]


def _onboard(drone: Any) -> dict[str, Any]:
    """Return how the onboard software of a simulated drone is at the end."""
    if drone is None:
        return {}
    return {
        "provider": drone.config.provider,
        "battery_V": rounded(drone.battery_voltage),
        "supervisor_state": drone.supervisor_state,
    }


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write summary.json whole or not at all: a reader never meets half of it."""
    text = json.dumps(summary, indent=2, allow_nan=False) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def rounded(value: float, digits: int = 4) -> float | None:
    """Return a figure as it is written: to a tenth of a millimeter, and null instead of NaN."""
    return round(float(value), digits) if math.isfinite(value) else None
