"""What a flight of layers comes down to: errors of formation and tracking, and whether they are small enough.

Plain data in (the log, reference positions), figures and sentences out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.guidance.metrics import FINAL_S, Flown, Metrics, Verdict, worst

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Window:
    """A button and the time until the next one."""

    name: str
    begin: float  # [s]
    end: float  # [s]


def positions(log: FlightLog) -> Array:
    """Return where the drones were (m), shape (T, N, 3): the truth, or what is known of it."""
    found = log.stack("sim.x", "sim.y", "sim.z")
    if found is None:
        found = log.stack("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
    assert found is not None
    return np.asarray(found, np.float64)


def references(log: FlightLog) -> Array:
    """Return the logged reference positions (m), shape (T, N, 3); NaN where the log has none."""
    found = log.stack("layers.x", "layers.y", "layers.z")
    assert found is not None
    return np.asarray(found, np.float64)


def is_up(log: FlightLog) -> NDArray[np.bool_]:
    """Return whose motors turned when, shape (T, N)."""
    phase = np.asarray(log.signals["layers.phase"])
    return (phase == DronePhase.FLYING.number) | (phase == DronePhase.LANDING.number)


class Judge:
    """Takes the figures of a flight: those of any flight, and those of its laws."""

    def __init__(self, log: FlightLog, windows: Sequence[Window], metrics: Sequence[Metrics] = ()) -> None:
        """Read a flight.

        Args:
            log: With the signals ``layers.*``.
            windows: What was pressed when.
            metrics: Those of the laws that flew.
        """
        self.log = log
        self.windows = list(windows)
        self.metrics = list(metrics)
        self._at = positions(log)
        self._wanted = references(log)
        self._up = is_up(log)
        starts = [(window.begin, window.end) for window in windows if window.name == "start"]
        self.flown = Flown(
            log.drone_ids,
            log.time,
            self._at,
            self._wanted,
            self._up,
            self._final,
            starts[-1] if starts else None,
            log.events,
        )
        """The flight as arrays."""

    # ---------------------------------------------------------------- figures

    @property
    def _final(self) -> slice | None:
        """The last second of the last phase that counts."""
        counted = [w for w in self.windows if w.name in ("start", "trajectory", "go_to")]
        if not counted:
            counted = [w for w in self.windows if w.name in ("takeoff", "hover")]
        if not counted:
            return None
        end = counted[-1].end
        first, last = np.searchsorted(self.log.time, [end - FINAL_S - 1e-9, end + 1e-9])
        return slice(int(first), int(last)) if last > first else None

    @property
    def final_positions(self) -> Array | None:
        """Where all drones are at the end, on average over the last second (m), shape (N, 3)."""
        return self.flown.final_positions

    def places(self) -> Array:
        """Return where all drones shall be at the end (m), shape (N, 3), NaN where that is open.

        The guidance laws supply them; otherwise they are the last logged references.
        """
        if self._final is None:
            return np.full(self._at.shape[1:], np.nan)
        places = self._places_of_laws()
        return self._wanted[self._final][-1] if places is None else places

    def _places_of_laws(self) -> Array | None:
        found = (one.places(self.final_positions, self._wanted[self._final][-1]) for one in self.metrics)  # type: ignore[arg-type]
        return next((places for places in found if places is not None), None)

    def position_errors(self) -> Array:
        """Return how far each drone is from its place at the end (m), shape (N,); NaN where it has none."""
        if self._final is None:
            return np.full(self._at.shape[1], np.nan)
        places = self._places_of_laws()
        if places is None:
            # a drone that is still under way is compared with its reference at that time
            errors = np.linalg.norm(np.mean(self._at[self._final] - self._wanted[self._final], axis=0), axis=1)
        else:
            errors = np.linalg.norm(np.mean(self._at[self._final], axis=0) - places, axis=1)
        return np.where(self._up[self._final].all(axis=0), errors, np.nan)

    def figures_of_laws(self) -> dict[str, float | None]:
        """Return what laws add to summary.json."""
        return {key: value for one in self.metrics for key, value in one.figures(self.flown).items()}

    def tracking(self) -> tuple[Array, Array]:
        """Return RMS and largest distance of each drone from its reference (m), shape (N,) each; NaN without one.

        What counts is the time after the take-off until the landing.
        """
        counts = np.zeros(len(self.log.time), bool)
        for window in self.windows:
            if window.name in ("start", "trajectory", "go_to", "hover"):
                counts |= (self.log.time >= window.begin - 1e-9) & (self.log.time < window.end - 1e-9)
        distance = np.linalg.norm(self._at - self._wanted, axis=2)
        distance[~(counts[:, None] & self._up)] = np.nan
        rms, largest = np.full(distance.shape[1], np.nan), np.full(distance.shape[1], np.nan)
        for i, column in enumerate(distance.T):
            known = column[np.isfinite(column)]
            if len(known):
                rms[i], largest[i] = float(np.sqrt(np.mean(known**2))), float(known.max())
        return rms, largest

    def least_distances(self, in_the_plane: bool = False) -> Array:
        """Return the min distance of each drone to another flying one (m), shape (N,); NaN for one that flew alone.

        Args:
            in_the_plane: Whether heights do not count.
        """
        count, axes = self._at.shape[1], 2 if in_the_plane else 3
        least = np.full(count, np.inf)
        for i in range(count):
            for j in range(i):
                both = self._up[:, i] & self._up[:, j]
                if both.any():
                    offsets = self._at[both, i, :axes] - self._at[both, j, :axes]
                    apart = float(np.nanmin(np.linalg.norm(offsets, axis=1)))
                    least[i], least[j] = min(least[i], apart), min(least[j], apart)
        return np.where(np.isfinite(least), least, np.nan)

    def horizontal_distances(self) -> Array:
        """Return how far the nearest two flying drones are apart in the plane over time (m), shape (T,); else NaN."""
        least = np.full(len(self._at), np.inf)
        for i in range(self._at.shape[1]):
            for j in range(i):
                both = self._up[:, i] & self._up[:, j]
                offsets = self._at[both, i, :2] - self._at[both, j, :2]
                least[both] = np.fmin(least[both], np.linalg.norm(offsets, axis=1))
        return np.where(np.isfinite(least), least, np.nan)

    def landed(self) -> NDArray[np.bool_]:
        """Return which drones stand with motors off after a flight, shape (N,)."""
        return np.asarray(self.log.signals["layers.phase"])[-1] == DronePhase.LANDED.number

    # ---------------------------------------------------------------- verdicts

    def verdicts(self, criteria: Any, names: Sequence[str], excused: Sequence[str] = ()) -> list[Verdict]:
        """Return how the flight did by each criterion that was asked for.

        Args:
            criteria: See `crazychoir_fw.mission.criteria.Criteria`.
            names: The drones.
            excused: Drones that may fail, which do not count.
        """
        counted = np.array([name not in excused for name in names])
        flown = replace(self.flown, counted=counted)
        found = [
            _verdict_of_law(one, key, one.criteria[key].checked(key, limit), flown)
            for key, limit in criteria.of_laws.items()
            for one in self.metrics
            if key in one.criteria
        ]
        if (limit := criteria.position_error_m) is not None:
            found.append(worst("position_error_m", limit, self.position_errors(), flown, "its place"))
        if (limit := criteria.tracking_rms_m) is not None:
            found.append(worst("tracking_rms_m", limit, self.tracking()[0], flown, "its reference (RMS)"))
        for key, in_the_plane in (("min_distance_m", False), ("min_horizontal_distance_m", True)):
            if (limit := getattr(criteria, key)) is not None:
                found.append(self._distance(key, limit, in_the_plane, counted, names))
        if criteria.landed and self.windows and self.windows[-1].name == "land":
            found.append(self._landed(counted, names))
        return found

    def _landed(self, counted: NDArray[np.bool_], names: Sequence[str]) -> Verdict:
        # drones that failed or were stopped are reported by their failures
        last = np.asarray(self.log.signals["layers.phase"])[-1]
        elsewhere = [phase.number for phase in (DronePhase.FAILED, DronePhase.STOPPED, DronePhase.GROUND)]
        asked = counted & ~np.isin(last, elsewhere)
        late = [name for name, down, counts in zip(names, self.landed(), asked, strict=True) if counts and not down]
        sentence = f"{', '.join(late)}: did not land" if late else "all landed"
        return Verdict("landed", True, float(self.landed().sum()), not late, sentence)

    def _distance(
        self, key: str, limit: float, in_the_plane: bool, counted: NDArray[np.bool_], names: Sequence[str]
    ) -> Verdict:
        least = np.where(counted, self.least_distances(in_the_plane), np.nan)
        if not np.isfinite(least).any():
            return Verdict(key, limit, None, True, "no two drones flew together")
        worst = int(np.nanargmin(least))
        value = float(least[worst])
        how = " in the plane" if in_the_plane else ""
        sentence = f"{names[worst]}: came within {value:.3f} m of another drone{how}, allowed: {limit:g} m or more"
        return Verdict(key, limit, round(value, 4), value >= limit, sentence)


def _verdict_of_law(metrics: Metrics, key: str, limit: Any, flown: Flown) -> Verdict:
    try:
        return metrics.verdict(key, limit, flown)
    except USER_ERRORS as error:  # a user's code may raise anything, and the flight is over
        return Verdict(key, limit, None, False, f"criteria.{key}: {describe(error)}")
