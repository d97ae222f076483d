"""What came of a flight: its figures, the curve of its errors, its tasks over time, and what explains its pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from crazychoir_fw.flight.criteria import Judge
from crazychoir_fw.flight.distance_curve import distance_curve
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.marks import TaskTimeline

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.simulation import World


@dataclass(frozen=True)
class FlightResult:
    """A flight that is over."""

    mission: Mission
    world: World | None
    log: FlightLog
    summary: dict[str, Any]
    judge: Judge | None = None
    """Figures of a flight of layers."""

    @property
    def success(self) -> bool:
        """Whether every drone met the criteria of its mission."""
        return self.summary["success"]

    @property
    def failures(self) -> list[str]:
        """What went wrong, one sentence each."""
        return self.summary["failures"]

    @property
    def expected_failures(self) -> list[str]:
        """What went wrong with drones that may fail, one sentence each."""
        return self.summary["expected_failures"]

    @property
    def curve(self) -> ErrorCurve | None:
        """Errors that count by the laws, or distances that a filter keeps, over time, for the picture."""
        if self.judge is None:
            return None
        criteria = self.mission.criteria  # type: ignore[attr-defined]
        curves = (one.curve(self.judge.flown, criteria) for one in self.judge.metrics)
        found = next((curve for curve in curves if curve is not None), None)
        if found is not None or self.timeline is not None:
            return found
        return distance_curve(self.mission, self.judge)  # type: ignore[arg-type]

    @property
    def timeline(self) -> TaskTimeline | None:
        """Tasks or deliveries, for pictures."""
        log, metrics = self.log, [] if self.judge is None else self.judge.metrics
        found = (one.timeline(log.events, log.drone_ids, float(log.time[-1])) for one in metrics)
        return next((timeline for timeline in found if timeline is not None), None)


def explained(result: FlightResult) -> dict[str, Any]:
    """Return what metadata of a log says beside the flight itself, for pictures made of the log alone.

    `pictures` has marks, links and leaders (`crazychoir_fw.recording.storyboard`), `stage` what simulated worlds
    have in the journal: how scene and drones look.
    """
    about: dict[str, Any] = {"pictures": {name: value for name, value in _pictures(result).items() if value}}
    if result.world is None:
        from crazychoir_fw.simulation import DroneConfig
        from crazychoir_fw.simulation.recipe import write_recipe

        mission = result.mission
        drones = [DroneConfig(**drone_settings(drone)) for drone in mission.fleet]
        about["stage"] = write_recipe(drones, mission.scene, mission.seed, {})
    return {name: value for name, value in about.items() if value}


def _pictures(result: FlightResult) -> dict[str, Any]:
    """Return marks, links and leaders as plain data."""
    metrics = [] if result.judge is None else result.judge.metrics
    marks = [mark for one in metrics for mark in one.marks(None)]
    if result.timeline is not None:
        marks += result.timeline.marks
    leaders = next((one.leads for one in metrics if one.leads is not None), None)
    return {
        "marks": [mark.as_dict() for mark in marks],
        "links": [[int(first), int(second)] for one in metrics for first, second in one.pairs],
        "leaders": None if leaders is None else sorted(int(number) for number in leaders),
    }
