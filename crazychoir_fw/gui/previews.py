"""Drawings made into curves, looked at before they are flown: limits, distances, and a flight of point masses."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.gui.requests import PreviewRequest
from crazychoir_fw.planning import Drawn, DrawnFit, Limits, fit_drawn

if TYPE_CHECKING:
    from crazychoir_fw.gui.drawings import Drawing, Drawings
    from crazychoir_fw.mission.schema import LayeredMission

Array = NDArray[np.float64]

SAMPLES = 200
"""Of a curve, for pictures."""
NEAR_M = 0.3
"""Distance between two drones that is worth a warning (m)."""
_KEPT = 50
_STEADINESS = 2.0  # a hand draws as fast here as there, within this factor


@dataclass(frozen=True)
class Part:
    """What one drone would fly."""

    drone: int
    drawing: Drawing
    fit: DrawnFit
    limits: Limits


@dataclass(frozen=True)
class Preview:
    """What would be flown."""

    key: str
    name: str
    parts: tuple[Part, ...]
    request: PreviewRequest

    @property
    def duration(self) -> float:
        """Time until all curves have ended (s)."""
        return max(part.fit.curve.duration for part in self.parts)

    def positions(self, times: Array) -> Array:
        """Return where the curves are at times (s); shape (T, parts, 3)."""
        return np.stack([part.fit.curve.position(np.clip(times, 0.0, part.fit.curve.duration))[:, :3]
                         for part in self.parts], axis=1)  # fmt: skip


class Previews:
    """Makes previews, and keeps the latest. May be used from any thread."""

    def __init__(self, mission: LayeredMission, drawings: Drawings) -> None:
        self._mission = mission
        self._names = [drone.id for drone in mission.fleet]
        self._drawings = drawings
        self._kept: OrderedDict[str, Preview] = OrderedDict()
        self._lock = threading.Lock()
        self._next = 1

    def find(self, key: str) -> Preview:
        """Return a preview.

        Raises:
            UnknownNameError: If there is none of that key any more.
        """
        if key not in self._kept:
            raise UnknownNameError("there is no such preview any more; press PREVIEW again")
        return self._kept[key]

    def make(self, request: PreviewRequest) -> Preview:
        """Return curves through the drawings.

        Raises:
            StateError: If there is nothing to preview, or two drawings are for one drone.
            RangeError: If a drawing makes no curve.
        """
        chosen = list(self._drawings)
        if request.drawings is not None:
            chosen = [self._drawings.find(key) for key in request.drawings]
        if not chosen:
            raise StateError("there is nothing to preview: draw something first, or load an example")
        drones = [drawing.drone for drawing in chosen]
        for name in drones:
            if drones.count(name) > 1:
                raise StateError(f"{name} has {drones.count(name)} drawings, allowed: one; choose another drone")
        parts = tuple(self._part(drawing, request) for drawing in chosen)
        with self._lock:
            preview = Preview(f"p{self._next}", ", ".join(d.name for d in chosen)[:60], parts, request)
            self._next += 1
            self._kept[preview.key] = preview
            while len(self._kept) > _KEPT:
                self._kept.popitem(last=False)
        return preview

    def _part(self, drawing: Drawing, request: PreviewRequest) -> Part:
        number = self._names.index(drawing.drone)
        limits = Limits.of_platform(self._mission.fleet[number].platform)
        drawn = Drawn(drawing.points, drawing.times)
        # a hand that rests gives two samples one time
        moves = np.concatenate([[True], np.diff(drawing.times) > 1e-6])
        drawn = Drawn(drawing.points[moves], drawing.times[moves])
        if len(drawn.points) < 2:
            raise RangeError(f"'{drawing.name}' was drawn in no time at all, and makes no curve")
        try:
            fit = fit_drawn(
                drawn,
                distance=request.distance,
                time_scale=request.time_scale,
                limits=limits if request.stretch else None,
                method=request.method,
                steadiness=_STEADINESS,
            )
        except RangeError as error:
            raise RangeError(f"'{drawing.name}': {error}") from None
        return Part(number, drawing, fit, limits)


def about(preview: Preview) -> dict[str, Any]:
    """Return a preview as plain data, with everything that its pictures show."""
    times = np.linspace(0.0, preview.duration, 4 * SAMPLES)
    return {
        "key": preview.key,
        "name": preview.name,
        "duration": round(preview.duration, 2),
        "warnings": _warnings(preview, times),
        "least_distance": _rounded(_least_distance(preview.positions(times))[0]),
        "parts": [_part_about(part) for part in preview.parts],
    }


def _part_about(part: Part) -> dict[str, Any]:
    curve, limits = part.fit.curve, part.limits
    times = np.linspace(0.0, curve.duration, SAMPLES)
    position, velocity, acceleration = (np.atleast_2d(curve.at(times, order))[:, :3] for order in range(3))
    speed, force = np.linalg.norm(velocity, axis=1), np.linalg.norm(acceleration, axis=1)
    return {
        "drone": part.drawing.drone,
        "drawing": part.drawing.name,
        "times": np.round(times, 3).tolist(),
        "position": np.round(position, 4).tolist(),
        "velocity": np.round(velocity, 4).tolist(),
        "acceleration": np.round(acceleration, 4).tolist(),
        "speed": np.round(speed, 4).tolist(),
        "force": np.round(force, 4).tolist(),
        "limits": {"speed": limits.speed, "acceleration": limits.acceleration},
        "violations": {
            "speed": _spans(times, speed > 1.001 * limits.speed),
            "acceleration": _spans(times, force > 1.001 * limits.acceleration),
        },
        "slowdown": _rounded(part.fit.slowdown),
        "deviation": _rounded(part.fit.deviation),
    }


def _warnings(preview: Preview, times: Array) -> list[str]:
    from crazychoir_fw.planning import check_limits

    found = []
    for part in preview.parts:
        for load in check_limits(part.fit.curve, part.limits).loads:
            if load.share > 1.001:
                found.append(
                    f"{part.drawing.drone}: {load.name.replace('_', ' ')} is {load.peak:.2f} at {load.time:.1f} s, "
                    f"allowed: {load.allowed:.2f}; fly it more slowly"
                )
    distance, pair, when = _least_distance(preview.positions(times))
    if distance < NEAR_M:
        first, second = (preview.parts[k].drawing.drone for k in pair)
        found.append(
            f"{first} and {second} come as near as {distance:.2f} m at {times[when]:.1f} s; change a height or a drone"
        )
    return found


def _least_distance(positions: Array) -> tuple[float, tuple[int, int], int]:
    """Return the min distance (m) of two drones, which, and the number of the sample."""
    least: tuple[float, tuple[int, int], int] = (float("inf"), (0, 0), 0)
    for i, j in combinations(range(positions.shape[1]), 2):
        distances = np.linalg.norm(positions[:, i] - positions[:, j], axis=1)
        k = int(distances.argmin())
        if distances[k] < least[0]:
            least = (float(distances[k]), (i, j), k)
    return least


def _spans(times: Array, where: NDArray[np.bool_]) -> list[list[float]]:
    """Return begin and end (s) of each span in which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int)))
    last = len(times) - 1
    return [[round(float(times[a]), 3), round(float(times[min(b, last)]), 3)] for a, b in edges.reshape(-1, 2)]


def _rounded(value: float) -> float | None:
    return round(float(value), 4) if np.isfinite(value) else None


def dry_run(
    mission: LayeredMission, preview: Preview, tell: Callable[[float], None] = lambda share: None
) -> dict[str, Any]:
    """Fly the curves of a preview with the layers of a mission on point masses, from where they begin.

    Args:
        mission: Whose layers fly.
        preview: The curves.
        tell: Called with the share that is flown, 0 to 1.

    Raises:
        StateError: If the layers follow no curves, or a drone fails.
    """
    from crazychoir_fw.flight.access import Access
    from crazychoir_fw.flight.agents import make_agents, make_groups, masses_of, names_of, starts_of
    from crazychoir_fw.flight.experiment import Experiment
    from crazychoir_fw.flight.integrator_backend import IntegratorBackend
    from crazychoir_fw.gui.flying import follow

    places = starts_of(mission)
    for part in preview.parts:
        places[part.drone] = part.fit.curve.position(0.0)[:3]
    platform = mission.fleet[preview.parts[0].drone].platform
    backend = IntegratorBackend(names_of(mission), places, mass=masses_of(mission), platform=platform)
    backend.record = lambda extra: None  # type: ignore[method-assign]
    agents = make_agents(mission, lambda: backend.time)
    experiment = Experiment(backend, agents, make_groups(mission, list(backend.masses)), mission.layers.rate, 1)
    chosen = [part.drone for part in preview.parts]
    if any(agents[i].planner is None for i in chosen):
        raise StateError("a dry run needs layers.planning and layers.control: point masses have no planner on board")
    experiment.takeoff([agents[i].name for i in chosen])
    experiment.step()  # in which the guidance asks for its take-off; from now on the curve is what counts
    begin = experiment.time
    for part in preview.parts:
        follow(experiment, Access(backend), part.drone, part.fit.curve, begin)
    rounds = round((preview.duration + 0.5) / experiment.period)
    times, positions = [], []
    for number in range(rounds):
        experiment.step()
        if number % 5 == 0:
            times.append(experiment.time - begin)
            positions.append(backend.true_positions()[chosen])
            tell(number / rounds)
            time.sleep(0.0005)  # the flight in the air comes first
    if experiment.failures:
        raise StateError("; ".join(experiment.failures))
    clock, flown = np.array(times), np.array(positions)
    errors = np.linalg.norm(flown - preview.positions(clock), axis=2)
    return {
        "seconds": round(float(clock[-1]), 2),
        "least_distance": _rounded(_least_distance(flown)[0]),
        "parts": [
            {
                "drone": part.drawing.drone,
                "rms": _rounded(np.sqrt((errors[:, k] ** 2).mean())),
                "largest": _rounded(errors[:, k].max()),
                "path": np.round(flown[:, k], 3).tolist(),
            }
            for k, part in enumerate(preview.parts)
        ],
    }
