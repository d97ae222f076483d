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
        """Tasks or deliveries, for the picture and the film."""
        log, metrics = self.log, [] if self.judge is None else self.judge.metrics
        found = (one.timeline(log.events, log.drone_ids, float(log.time[-1])) for one in metrics)
        return next((timeline for timeline in found if timeline is not None), None)

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
        metrics = [] if self.judge is None else self.judge.metrics
        leaders = next((one.leads for one in metrics if one.leads is not None), None)
        mirrored = self.world.mirrored if self.world is not None else {}
        if leaders is not None:
            for i, drone in enumerate(self.mission.fleet):
                if drone.id not in mirrored:  # those keep the color of real drones
                    _paint(model, drone.id, _LEADER if i in leaders else _FOLLOWER)
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
