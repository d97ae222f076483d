"""What came of a flight: its figures, the curve of its errors, its tasks over time, and what a film is made of."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.flight.criteria import Judge
from crazychoir_fw.flight.distance_curve import distance_curve
from crazychoir_fw.flight.task_timeline import timeline_of
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.marks import Mark, TaskTimeline

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.simulation import World

_LEADER, _FOLLOWER = (0.85, 0.1, 0.1), (0.1, 0.4, 0.85)


@dataclass
class Film:
    """What a video of the flight is rendered from."""

    fps: int
    times: Sequence[float] = ()
    """Of the states (s), shape (F,)."""
    qpos: NDArray[np.float64] | None = None
    """Positions of the whole model, shape (F, nq)."""
    speed: float = 1.0
    """Seconds of flight per second of film."""
    links: list[tuple[int, int]] = field(default_factory=list)
    """Drones that talk to each other."""
    marks: list[Mark] = field(default_factory=list)
    """Points that are shown."""
    drones: list[str] | None = None
    """Which bodies are drones, where not all of them are simulated."""
    missing: str | None = None
    """Why there is nothing to be filmed."""


@dataclass(frozen=True)
class FlightResult:
    """A flight that is over."""

    mission: Mission
    world: World | None
    log: FlightLog
    film: Film
    summary: dict[str, Any]
    judge: Judge | None = None
    """Figures of a flight of layers."""

    @property
    def success(self) -> bool:
        """Whether every drone did what it was told."""
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
        """Errors of formation or defenders, or distances that a filter keeps, over time, for the picture."""
        if self.judge is None:
            return None
        if self.judge.surveillance is not None:
            return self._surveillance_curve
        label, limit = "bearing error (deg)", self.mission.criteria.bearing_error_deg  # type: ignore[attr-defined]
        errors = self.judge.bearing_errors()
        if errors is None:
            errors = self.judge.formation_errors()
            is_distance = errors is not None and self.judge.formation.kind == "distance"  # type: ignore[union-attr]
            label = "error of distances (m)" if is_distance else "distance from its place (m)"
            criteria = self.mission.criteria  # type: ignore[attr-defined]
            limit = criteria.distance_error_m if is_distance else criteria.position_error_m
        if errors is None or np.isnan(errors).all():
            return None if self.timeline is not None else distance_curve(self.mission, self.judge)  # type: ignore[arg-type]
        flies = ~np.isnan(errors).all(axis=1)
        mean, largest = np.full(len(errors), np.nan), np.full(len(errors), np.nan)
        mean[flies], largest[flies] = np.nanmean(errors[flies], axis=1), np.nanmax(errors[flies], axis=1)
        pairs = list(self.judge.formation.graph.pairs)  # type: ignore[union-attr]
        end = self.judge.final_positions
        return ErrorCurve(label, mean, largest, limit, self.judge.places(), end, pairs, judged=self.judge.judged)

    @property
    def _surveillance_curve(self) -> ErrorCurve | None:
        judge, criteria = self.judge, self.mission.criteria  # type: ignore[attr-defined]
        errors = judge.surveillance_errors()
        flies = ~np.isnan(errors).any(axis=1)
        if not flies.any():
            return None
        mean, largest = np.full(len(errors), np.nan), np.full(len(errors), np.nan)
        mean[flies], largest[flies] = np.mean(errors[flies], axis=1), np.max(errors[flies], axis=1)
        end, label = judge.final_positions, "distance from optimum (m)"
        places = None
        if end is not None:
            places = np.full_like(end, np.nan)
            places[list(judge.surveillance.defenders), :2] = judge.surveillance.places(end)
        return ErrorCurve(
            label, mean, largest, criteria.surveillance_error_m, places, marks=judge.surveillance.marks(end)
        )

    @property
    def timeline(self) -> TaskTimeline | None:
        """Tasks or deliveries, for the picture and the film."""
        return timeline_of(self.log.events, self.log.drone_ids, float(self.log.time[-1]))

    @property
    def film_model(self) -> Any:
        """The model that the film is made with: drones of an integrator are drawn where they were."""
        from crazychoir_fw.simulation import DroneConfig
        from crazychoir_fw.simulation.builder import build_model

        if self.world is not None:
            model = copy(self.world.model)
        else:
            drones = [DroneConfig(**drone_settings(drone)) for drone in self.mission.fleet]
            model = build_model(drones, self.mission.scene, self.mission.seed, True)
        formation = None if self.judge is None else self.judge.formation
        surveillance = None if self.judge is None else self.judge.surveillance
        if surveillance is not None:
            for i, drone in enumerate(self.mission.fleet):
                _paint(model, drone.id, _FOLLOWER if i in surveillance.defenders else _LEADER)
        if formation is not None:
            mirrored = self.world.mirrored if self.world is not None else {}
            for i, drone in enumerate(self.mission.fleet):
                if drone.id in mirrored:
                    continue  # it keeps the color of real drones
                _paint(model, drone.id, _LEADER if i in formation.leaders else _FOLLOWER)
        elif self.timeline is not None:
            from matplotlib.colors import to_rgb

            from crazychoir_fw.recording.plot import palette

            for drone, color in zip(self.mission.fleet, palette(len(self.mission.fleet)), strict=True):
                _paint(model, drone.id, to_rgb(color))
        return model


def _paint(model: Any, drone: str, color: tuple[float, float, float]) -> None:
    """Give the colored part of a drone another color."""
    geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{drone}/accent")
    if geom >= 0:
        model.geom_rgba[geom, :3] = color
        model.geom_matid[geom] = -1
