"""Metrics of formations: where drones shall be, how far from it they are, and whether they are among their leaders."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.bearing import bearing_errors_deg, bearing_laplacian
from crazychoir_fw.guidance.hull import distance_from_hull
from crazychoir_fw.guidance.law import LawContext
from crazychoir_fw.guidance.metrics import Flown, Metrics, Verdict, criterion, worst

Array = NDArray[np.float64]

HULL_M = 0.05
"""Distance from the hull of the leaders at which a follower counts as inside (m): leaders move a little, too."""


class ShapeMetrics(Metrics):
    """What all kinds of formations have in common: leaders, and pairs of neighbors."""

    scope = "alone"

    @property
    def leads(self) -> frozenset[int]:
        """See `Metrics`."""
        return frozenset(self.context.leaders)

    @property
    def pairs(self) -> Sequence[tuple[int, int]]:
        """See `Metrics`."""
        return self.context.graph.pairs

    def fly_together(self, flown: Flown) -> NDArray[np.bool_]:
        """Return at which times both ends of each pair fly, shape (T, pairs)."""
        return flown.up[:, np.array(self.pairs, int).reshape(-1, 2)].all(axis=2)

    def counted_pairs(self, flown: Flown) -> list[bool]:
        """Return for each pair whether criteria count both ends, and both fly at the end."""
        up = flown.flew_at_the_end
        return [bool(up[i] and up[j] and flown.counts(i) and flown.counts(j)) for i, j in self.pairs]

    @criterion("the hull of the leaders", kind=bool)
    def containment(self, flown: Flown) -> Verdict:
        """Return whether all followers are in the hull of the leaders at the end."""
        distances = np.full(len(flown.names), np.nan)
        leaders, at = list(self.context.leaders), flown.final_positions
        if leaders and at is not None:
            distances[leaders] = 0.0
            for i in self.context.followers:
                distances[i] = distance_from_hull(at[i], at[leaders])
            distances[~flown.flew_at_the_end] = np.nan
        found = worst("containment", HULL_M, distances, flown, self.criteria["containment"].what)
        return Verdict("containment", True, found.value, found.passed, found.sentence)


class BearingMetrics(ShapeMetrics):
    """A formation by the directions between neighbors: that of any law to which a mission gives places."""

    curve_label, curve_limit = "bearing error (deg)", "bearing_error_deg"

    @classmethod
    def of(cls, context: LawContext) -> Metrics | None:
        """See `Metrics`."""
        return None if context.formation is None else cls(context)

    def errors(self, flown: Flown) -> Array:
        """Return the errors of all bearings over time (deg), shape (T, pairs)."""
        pairs = np.array(self.pairs, int).reshape(-1, 2)
        errors, at = np.full((len(flown.at), len(pairs)), np.nan), flown.at
        near = np.linalg.norm(at[:, pairs[:, 0]] - at[:, pairs[:, 1]], axis=-1) < 2e-3
        flies = self.fly_together(flown)
        for k, pair in enumerate(pairs):
            good = flies[:, k] & ~near[:, k] & np.isfinite(at[:, pair]).all(axis=(1, 2))
            if good.any():
                errors[good, k] = bearing_errors_deg(at[good], self.context.formation, [tuple(pair)])[:, 0]
        return errors

    def final_errors(self, flown: Flown) -> Array:
        """Return the errors of the bearings that count at the end (deg)."""
        if flown.final is None:
            return np.zeros(0)
        pairs = [pair for pair, counts in zip(self.pairs, self.counted_pairs(flown), strict=True) if counts]
        return bearing_errors_deg(flown.final_positions, self.context.formation, pairs)

    @criterion("the mean bearing error", "deg", 180.0)
    def bearing_error_deg(self, flown: Flown) -> float:
        """Return the mean error at the end (deg)."""
        errors = self.final_errors(flown)
        return float(np.mean(errors)) if len(errors) else np.nan

    @criterion("the largest bearing error", "deg", 180.0)
    def bearing_error_max_deg(self, flown: Flown) -> float:
        """Return the largest error at the end (deg)."""
        errors = self.final_errors(flown)
        return float(np.max(errors)) if len(errors) else np.nan

    def figures(self, flown: Flown) -> dict[str, float | None]:
        """Return both errors, of all drones."""
        if flown.final is None:
            return {}
        return {key: getattr(self, key)(flown) for key in ("bearing_error_deg", "bearing_error_max_deg")}

    def places(self, at: Array, wanted: Array) -> Array:
        """Return the commanded places of leaders, and the places that bearings then define for followers."""
        places = leaders_at(self.context.leaders, at, wanted)
        followers = self.context.followers
        with contextlib.suppress(np.linalg.LinAlgError, RangeError):  # the leaders leave them a choice
            laplacian = bearing_laplacian(self.context.formation, self.context.graph)
            rows = [3 * i + k for i in followers for k in range(3)]
            columns = [3 * i + k for i in self.context.leaders for k in range(3)]
            right = -laplacian[np.ix_(rows, columns)] @ places[list(self.context.leaders)].ravel()
            places[followers] = np.linalg.solve(laplacian[np.ix_(rows, rows)], right).reshape(-1, 3)
        return places


def leaders_at(leaders: Sequence[int], at: Array, wanted: Array) -> Array:
    """Return where leaders shall be (m), shape (N, 3): as told, else where they are; NaN for all others."""
    places, rows = np.full(at.shape, np.nan), list(leaders)
    places[rows] = np.where(np.isfinite(wanted[rows]), wanted[rows], at[rows])
    return places
