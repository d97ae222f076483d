"""What came of a flight with layers: its figures, the curve of its errors, its story, and the model of its film."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import mujoco

from crazychoir_fw.flight.criteria import Judge
from crazychoir_fw.flight.distance_curve import distance_curve
from crazychoir_fw.flight.runner import FlightResult
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.marks import Story

_LEADER, _FOLLOWER = (0.85, 0.1, 0.1), (0.1, 0.4, 0.85)


@dataclass(frozen=True)
class LayeredResult(FlightResult):
    """A flight of layers that is over."""

    judge: Judge
    """Figures of the flight."""
    no_film: str | None = None
    """Why there is nothing to be filmed."""

    @property
    def curve(self) -> ErrorCurve | None:
        """Errors that count by the laws, or distances that a filter keeps, over time, for the picture."""
        criteria = self.mission.criteria  # type: ignore[attr-defined]
        curves = (one.curve(self.judge.flown, criteria) for one in self.judge.metrics)
        found = next((curve for curve in curves if curve is not None), None)
        if found is not None or self.story is not None:
            return found
        return distance_curve(self.mission, self.judge)  # type: ignore[arg-type]

    @property
    def story(self) -> Story | None:
        """Tasks or deliveries, for the picture and the film."""
        log = self.log
        stories = (one.timeline(log.events, log.drone_ids, float(log.time[-1])) for one in self.judge.metrics)
        return next((story for story in stories if story is not None), None)

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
        leaders = next((one.leads for one in self.judge.metrics if one.leads is not None), None)
        mirrored = self.world.mirrored if self.world is not None else {}
        if leaders is not None:
            for i, drone in enumerate(self.mission.fleet):
                if drone.id not in mirrored:  # those keep the color of real drones
                    _paint(model, drone.id, _LEADER if i in leaders else _FOLLOWER)
        elif self.story is not None:
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
