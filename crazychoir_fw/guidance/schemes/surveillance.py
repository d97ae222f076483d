"""Metrics of target surveillance: where defenders should be."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.guidance.law import LawContext
from crazychoir_fw.guidance.metrics import FINAL_S, Flown, Metrics, criterion, mean_and_largest
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.marks import Mark

Array = NDArray[np.float64]


class SurveillanceMetrics(Metrics):
    """Defenders shall be where the sum of all costs is least."""

    curve_label, curve_limit = "distance from optimum (m)", "surveillance_error_m"

    def __init__(self, context: LawContext) -> None:
        """Take target, intruders and weights."""
        super().__init__(context)
        self.defenders = context.members
        self.intruders = [self._intruder(context, i) for i in context.members]
        """Of each defender: the number of a drone, or a place (m), shape (2,); None where the mission names none."""
        target = context.option("target")
        self.target: Array | None = None if target is None else np.array(target[:2], float)
        self.gammas = tuple(float(context.option(f"gamma_{what}", 1.0)) for what in ("intruder", "target", "shape"))

    @classmethod
    def of(cls, context: LawContext) -> Metrics | None:
        """See `Metrics`; each defender must have an intruder."""
        made = cls(context)
        return None if any(one is None for one in made.intruders) else made

    def _intruder(self, context: LawContext, i: int) -> Any:
        options = context.options.get(i, {})
        moves = getattr(context.law, "intruder_moves", False)
        number = options.get("intruder_id", i + len(context.members) if moves else None)
        place = options.get("intruder")
        if number is not None:
            return int(number)
        return None if place is None else np.array(place[:2], float)

    def intruders_at(self, at: Array) -> Array:
        """Return where the intruders of the defenders are (m), shape (..., D, 2), given all drones, (..., N, 3)."""
        columns = [
            at[..., one, :2] if isinstance(one, int) else np.broadcast_to(one, (*at.shape[:-2], 2))
            for one in self.intruders
        ]
        return np.stack(columns, axis=-2)

    def optimum(self, at: Array) -> Array:
        """Return the optimum (m), shape (..., D, 2), given all drones, shape (..., N, 3).

        The gradients of the sum of all costs are zero there; with all weights 1 it is half-way between intruder and
        target.
        """
        intruder, target, shape = self.gammas
        where = self.intruders_at(at)
        center = where.mean(axis=-2, keepdims=True)
        pull = np.zeros_like(center)
        if self.target is not None:
            center = (intruder * center + target * self.target) / (intruder + target)
            pull = target * (center - self.target)
        return (intruder * where + shape * center - pull) / (intruder + shape)

    def distances(self, at: Array) -> Array:
        """Return how far each defender is from its place (m), shape (..., D), given all drones, shape (..., N, 3)."""
        return np.linalg.norm(at[..., list(self.defenders), :2] - self.optimum(at), axis=-1)

    def errors(self, flown: Flown) -> Array:
        """Return how far each defender is from its place over time (m), shape (T, D)."""
        return np.where(flown.up[:, list(self.defenders)], self.distances(flown.at), np.nan)

    @criterion("where it should be", "m")
    def surveillance_error_m(self, flown: Flown) -> Array:
        """Return the errors on average over the last second of START (m), shape (N,)."""
        return self._at_the_end(flown, lambda begin, end: end - FINAL_S, lambda errors: np.mean(errors, axis=0))

    @criterion("where it should be (RMS)", "m")
    def surveillance_rms_m(self, flown: Flown) -> Array:
        """Return their RMS over the second half of START (m), shape (N,): how far defenders are behind."""
        return self._at_the_end(
            flown, lambda begin, end: (begin + end) / 2, lambda errors: np.sqrt(np.mean(errors**2, axis=0))
        )

    def _at_the_end(self, flown: Flown, since: Any, figure: Any) -> Array:
        found = np.full(len(flown.names), np.nan)
        if flown.start is not None:
            begin, end = flown.start
            first, last = np.searchsorted(flown.time, [since(begin, end) - 1e-9, end + 1e-9])
            errors = self.errors(flown)[first:last]
            if len(errors):
                found[list(self.defenders)] = figure(errors)
        return found

    @property
    def leads(self) -> frozenset[int]:
        """All others, the intruders that fly among them."""
        return frozenset(range(len(self.context.names))).difference(self.defenders)

    @property
    def pairs(self) -> Any:
        """See `Metrics`."""
        return self.context.graph.pairs

    def marks(self, end: Array | None) -> list[Mark]:
        """Return target and intruders, those that move where they are at the end."""
        found = []
        if self.target is not None:
            found.append(Mark(np.array([*self.target, self.context.height]), kind="target"))
        for one in self.intruders:
            if not isinstance(one, int):
                found.append(Mark(np.array([*one, self.context.height]), kind="intruder"))
            elif end is not None:
                found.append(Mark(end[one], kind="intruder", moves=True))
        return found

    def curve(self, flown: Flown, criteria: Any) -> ErrorCurve | None:
        """See `Metrics`; crosses are the optimum, and no lines connect neighbors."""
        errors, end = self.errors(flown), flown.final_positions
        if np.isnan(errors).all():
            return None
        places = None
        if end is not None:
            places = np.full_like(end, np.nan)
            places[list(self.defenders), :2] = self.optimum(end)
        limit = getattr(criteria, self.curve_limit, None)
        return ErrorCurve(self.curve_label, *mean_and_largest(errors), limit, places, marks=self.marks(end))
