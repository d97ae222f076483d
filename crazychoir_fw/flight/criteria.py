"""What a flight of layers comes down to: errors of formation and tracking, and whether they are small enough.

Plain data in (the log, who shall be where), figures and sentences out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.formation_metrics import (
    Formation,
    coupling_errors,
    errors_over_time,
    hull_distances,
    places_of,
    shape_errors,
)
from crazychoir_fw.guidance.bearing import bearing_errors_deg
from crazychoir_fw.guidance.schemes.tasks.judging import agreements, completed, largest_gap

if TYPE_CHECKING:
    from crazychoir_fw.mission.surveillance import Surveillance
    from crazychoir_fw.recording.flight_log import FlightLog

Array = NDArray[np.float64]

FINAL_S = 1.0
"""Time before the end of a phase over which its final figures are averaged (s): noise is no error of a formation."""

HULL_M = 0.05
"""Distance from the hull of the leaders at which a follower counts as inside (m): leaders move a little, too."""


@dataclass(frozen=True)
class Window:
    """A button and the time until the next one."""

    name: str
    begin: float  # [s]
    end: float  # [s]


@dataclass(frozen=True)
class Verdict:
    """One criterion of a flight."""

    name: str
    """Key of the mission file."""
    limit: float | bool
    """What is allowed."""
    value: float | None
    """What was measured; None if it could not be."""
    passed: bool
    sentence: str
    """What is wrong, or what was measured."""

    def as_dict(self) -> dict[str, Any]:
        """Return it for summary.json."""
        return {"criterion": self.name, "limit": self.limit, "value": self.value, "passed": self.passed}


def positions(log: FlightLog) -> Array:
    """Return where the drones were (m), shape (T, N, 3): the truth, or what is known of it."""
    found = log.stack("sim.x", "sim.y", "sim.z")
    if found is None:
        found = log.stack("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
    assert found is not None
    return np.asarray(found, np.float64)


def references(log: FlightLog) -> Array:
    """Return where they were to be (m), shape (T, N, 3); NaN where nobody said."""
    found = log.stack("layers.x", "layers.y", "layers.z")
    assert found is not None
    return np.asarray(found, np.float64)


def is_up(log: FlightLog) -> NDArray[np.bool_]:
    """Return whose motors turned when, shape (T, N)."""
    phase = np.asarray(log.signals["layers.phase"])
    return (phase == DronePhase.FLYING.number) | (phase == DronePhase.LANDING.number)


class Judge:
    """Takes the figures of a flight."""

    def __init__(self, log: FlightLog, windows: Sequence[Window], formation: Formation | None = None) -> None:
        """Read a flight.

        Args:
            log: With the signals ``layers.*``.
            windows: What was pressed when.
            formation: The formation, if there was one.
        """
        self.log = log
        self.windows = list(windows)
        self.formation = formation
        self.surveillance: Surveillance | None = None
        """Who guards what, if somebody does."""
        self._at = positions(log)
        self._wanted = references(log)
        self._up = is_up(log)

    # ---------------------------------------------------------------- figures

    def bearing_errors(self) -> Array | None:
        """Return the errors of all bearings over time (deg), shape (T, edges); NaN while an end does not fly."""
        if self.formation is None or self.formation.kind != "bearing":
            return None
        pairs = np.array(self.formation.graph.pairs, int).reshape(-1, 2)
        errors = np.full((len(self._at), len(pairs)), np.nan)
        places = self._at.copy()
        flies = self._up[:, pairs].all(axis=2)
        near = np.linalg.norm(places[:, pairs[:, 0]] - places[:, pairs[:, 1]], axis=-1) < 2e-3
        for k, pair in enumerate(pairs):
            good = flies[:, k] & ~near[:, k] & np.isfinite(places[:, pair]).all(axis=(1, 2))
            if good.any():
                errors[good, k] = bearing_errors_deg(places[good], self.formation.places, [tuple(pair)])[:, 0]
        return errors

    def final_bearing_errors(self) -> Array | None:
        """Return the errors of all bearings at the end of the last start (deg), shape (edges,)."""
        if self.formation is None or self.formation.kind != "bearing" or self._final is None:
            return None
        mean = np.nanmean(self._at[self._final], axis=0)
        return bearing_errors_deg(mean, self.formation.places, self._flying_pairs())

    def formation_errors(self) -> Array | None:
        """Return what is wrong with a formation without bearings over time (m), see `errors_over_time`."""
        if self.formation is None or self.formation.kind == "bearing":
            return None
        return errors_over_time(self.formation, self._at, self._up)

    def final_distance_errors(self) -> Array | None:
        """Return the errors of all distances at the end of the last start (m), shape (edges,)."""
        if self.formation is None or self.formation.kind != "distance" or self._final is None:
            return None
        pairs, flying = self.formation.graph.pairs, self._flying_pairs()
        errors = np.abs(shape_errors(self.formation, np.nanmean(self._at[self._final], axis=0)))
        return errors[[pair in flying for pair in pairs]]

    def hull_distances(self) -> Array | None:
        """Return how far each follower is from the hull of its leaders then (m), shape (N,); NaN for who flies not."""
        if self.formation is None or not self.formation.leaders or self._final is None:
            return None
        distances = hull_distances(self.formation, np.nanmean(self._at[self._final], axis=0))
        return np.where(self._up[self._final].all(axis=0), distances, np.nan)

    def _flying_pairs(self) -> list[tuple[int, int]]:
        assert self.formation is not None and self._final is not None
        up = self._up[self._final].all(axis=0)
        return [pair for pair in self.formation.graph.pairs if up[pair[0]] and up[pair[1]]]

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
    def judged(self) -> tuple[float, float] | None:
        """From when to when final figures are averaged (s)."""
        if self._final is None:
            return None
        return float(self.log.time[self._final.start]), float(self.log.time[self._final.stop - 1])

    @property
    def final_positions(self) -> Array | None:
        """Where all drones are at the end, on average over the last second (m), shape (N, 3)."""
        return None if self._final is None else np.mean(self._at[self._final], axis=0)

    def places(self) -> Array:
        """Return where all drones shall be at the end (m), shape (N, 3).

        In a formation, leaders where they were told to be, and followers where bearings or leaders want them then; in
        a formation by distances, where it fits best. Otherwise where each was told to be. NaN where nobody knows.
        """
        count = self._at.shape[1]
        if self._final is None:
            return np.full((count, 3), np.nan)
        wanted = self._wanted[self._final][-1]
        if self.formation is None:
            return wanted
        return places_of(self.formation, np.nanmean(self._at[self._final], axis=0), wanted)

    def position_errors(self) -> Array:
        """Return how far each drone is from its place at the end (m), shape (N,); NaN where it has none."""
        if self._final is None:
            return np.full(self._at.shape[1], np.nan)
        if self.formation is None:
            # who is still under way is compared with where he is to be then
            errors = np.linalg.norm(np.mean(self._at[self._final] - self._wanted[self._final], axis=0), axis=1)
        else:
            errors = np.linalg.norm(np.mean(self._at[self._final], axis=0) - self.places(), axis=1)
        return np.where(self._up[self._final].all(axis=0), errors, np.nan)

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

    def surveillance_errors(self) -> Array | None:
        """Return how far each defender is from where it should be over time (m), shape (T, D); NaN on the ground."""
        if self.surveillance is None:
            return None
        errors = self.surveillance.errors(self._at)
        return np.where(self._up[:, list(self.surveillance.defenders)], errors, np.nan)

    def final_surveillance_errors(self, rms: bool = False) -> Array:
        """Return the errors of defenders on average over the last second of START (m), shape (N,); NaN for others.

        Args:
            rms: Rather the RMS over the second half of START, for intruders that move.
        """
        found = np.full(self._at.shape[1], np.nan)
        windows = [window for window in self.windows if window.name == "start"]
        if self.surveillance is None or not windows:
            return found
        begin, end = windows[-1].begin, windows[-1].end
        begin = (begin + end) / 2 if rms else end - FINAL_S
        first, last = np.searchsorted(self.log.time, [begin - 1e-9, end + 1e-9])
        errors = self.surveillance_errors()[first:last]  # type: ignore[index]
        if len(errors):
            mean = np.sqrt(np.mean(errors**2, axis=0)) if rms else np.mean(errors, axis=0)
            found[list(self.surveillance.defenders)] = mean
        return found

    def least_distances(self, in_the_plane: bool = False) -> Array:
        """Return how near another flying drone came to each (m), shape (N,); NaN for who was alone.

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
        """Return who stands with motors off after a flight, shape (N,)."""
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
        found = []
        errors = self.final_bearing_errors()
        if errors is not None and excused:
            pairs = self._flying_pairs()
            errors = errors[[bool(counted[i] and counted[j]) for i, j in pairs]]
        if criteria.bearing_error_deg is not None:
            value = float(np.mean(errors)) if errors is not None and len(errors) else math.nan
            found.append(
                _at_most("bearing_error_deg", criteria.bearing_error_deg, value, "the mean bearing error", "deg")
            )
        if criteria.bearing_error_max_deg is not None:
            value = float(np.max(errors)) if errors is not None and len(errors) else math.nan
            found.append(
                _at_most(
                    "bearing_error_max_deg", criteria.bearing_error_max_deg, value, "the largest bearing error", "deg"
                )
            )
        if criteria.distance_error_m is not None:
            wrong = self.final_distance_errors()
            value = float(np.max(wrong)) if wrong is not None and len(wrong) else math.nan
            found.append(
                _at_most("distance_error_m", criteria.distance_error_m, value, "the largest distance error", "m")
            )
        if criteria.coupling_error_m is not None:
            limit, what = criteria.coupling_error_m, "the largest excess of a difference between neighbors"
            found.append(_at_most("coupling_error_m", limit, self.coupling_error(), what, "m"))
        if criteria.containment:
            found.append(self._containment(counted, names))
        if criteria.position_error_m is not None:
            found.append(
                _worst(
                    "position_error_m", criteria.position_error_m, self.position_errors(), counted, names, "its place"
                )
            )
        if criteria.tracking_rms_m is not None:
            found.append(
                _worst(
                    "tracking_rms_m", criteria.tracking_rms_m, self.tracking()[0], counted, names, "its reference (RMS)"
                )
            )
        for key, rms in (("surveillance_error_m", False), ("surveillance_rms_m", True)):
            if (limit := getattr(criteria, key)) is not None:
                values, what = self.final_surveillance_errors(rms), "where it should be" + (" (RMS)" if rms else "")
                found.append(_worst(key, limit, values, counted, names, what))
        for key, in_the_plane in (("min_distance_m", False), ("min_horizontal_distance_m", True)):
            if (limit := getattr(criteria, key)) is not None:
                found.append(self._distance(key, limit, in_the_plane, counted, names))
        if criteria.tasks_completed is not None:
            found.append(self._completed(criteria.tasks_completed))
        if criteria.assignment_optimal:
            found.append(self._assignments())
        if criteria.routes_gap is not None:
            found.append(self._gap(criteria.routes_gap))
        if criteria.landed and self.windows and self.windows[-1].name == "land":
            # what became of those that failed is said elsewhere
            last = np.asarray(self.log.signals["layers.phase"])[-1]
            asked = counted & (last != DronePhase.FAILED.number) & (last != DronePhase.GROUND.number)
            late = [name for name, down, counts in zip(names, self.landed(), asked, strict=True) if counts and not down]
            sentence = f"{', '.join(late)}: did not land" if late else "all landed"
            found.append(Verdict("landed", True, float(self.landed().sum()), not late, sentence))
        return found

    def _completed(self, least: int) -> Verdict:
        done = completed(self.log.events)
        sentence = f"{done} tasks were completed, allowed: {least} or more"
        return Verdict("tasks_completed", least, float(done), done >= least, sentence)

    def _assignments(self) -> Verdict:
        agreed = agreements(self.log.events)
        good = sum(one.is_optimal for one in agreed)
        sentence = f"{good} of {len(agreed)} assignments were optimal"
        for bad in (one for one in agreed if not one.is_optimal):
            sentence += (
                f"; list {bad.label}: {bad.count} tasks at {bad.cost:.3f} m instead of {bad.best_count} at "
                f"{bad.best_cost:.3f} m"
            )
            break
        passed = bool(agreed) and good == len(agreed)
        return Verdict("assignment_optimal", True, float(good), passed, sentence)

    def _gap(self, limit: float) -> Verdict:
        gap = largest_gap(self.log.events)
        if gap is None:
            return Verdict("routes_gap", limit, None, False, "drones agreed on no routes")
        sentence = f"routes are {100 * gap:.1f} % longer than their lower bound, allowed: {100 * limit:g} %"
        return Verdict("routes_gap", limit, round(gap, 4), gap <= limit, sentence)

    def coupling_error(self) -> float:
        """Return by how much neighbors were ever farther apart than allowed in flight (m); NaN if nobody minds."""
        shape = self.formation
        if shape is None or shape.kind != "together" or not shape.graph.pairs:
            return math.nan
        errors = coupling_errors(shape, self._at)
        flies = self._up[:, np.array(shape.graph.pairs)].all(axis=2)
        return max(0.0, float(np.max(errors[flies]))) if flies.any() else math.nan

    def _containment(self, counted: NDArray[np.bool_], names: Sequence[str]) -> Verdict:
        outside = self.hull_distances()
        if outside is None:
            outside = np.full(len(names), np.nan)
        verdict = _worst("containment", HULL_M, outside, counted, names, "the hull of the leaders")
        return Verdict("containment", True, verdict.value, verdict.passed, verdict.sentence)

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


def _at_most(name: str, limit: float, value: float, what: str, unit: str) -> Verdict:
    passed = value <= limit  # not for NaN
    measured = f"{value:.3g} {unit}" if math.isfinite(value) else "not known"
    known = round(value, 4) if math.isfinite(value) else None
    return Verdict(name, limit, known, passed, f"{what} is {measured}, allowed: {limit:g} {unit}")


def _worst(
    name: str, limit: float, values: Array, counted: NDArray[np.bool_], names: Sequence[str], what: str
) -> Verdict:
    values = np.where(counted, values, np.nan)
    if not np.isfinite(values).any():
        return Verdict(name, limit, None, False, f"{name}: no drone has one at the end of the flight")
    worst = int(np.nanargmax(values))
    value = float(values[worst])
    sentence = f"{names[worst]}: is {value:.3f} m from {what}, allowed: {limit:g} m"
    return Verdict(name, limit, round(value, 4), value <= limit, sentence)
