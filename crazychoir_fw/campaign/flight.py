"""One flight of a campaign, and what is kept of it."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.campaign.campaign import Job, load_job
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.user_code import describe
from crazychoir_fw.firmware.checkout import VARIABLE
from crazychoir_fw.recording.signals import LazySignals

if TYPE_CHECKING:
    from crazychoir_fw.flight.flight_result import FlightResult

PASSED, FAILED, CRASHED = "passed", "failed", "crashed"
"""Ends of a flight: the mission says so; it says not; there is no flight, because something broke."""

MARGIN = "margin"
"""The figure by which flights are ordered, see `margin_of`."""

_LEAST = ("least_", "battery_", "min_")
"""Figures of drones of which the least one is the worst, by the begin of their names."""


@dataclass(frozen=True)
class Record:
    """What is kept of a flight."""

    number: int
    outcome: str
    """`PASSED`, `FAILED` or `CRASHED`."""
    values: dict[str, Any] = field(default_factory=dict)
    """What was varied."""
    figures: dict[str, float] = field(default_factory=dict)
    """Figures of `summary.json`, those of the worst drone."""
    failures: tuple[str, ...] = ()
    digest: str = ""
    """Of the log: equal bits give equal digests."""
    sim_seconds: float = 0.0
    wall_seconds: float = 0.0
    """For people: nothing depends on it."""

    @property
    def passed(self) -> bool:
        """Whether the mission calls it a success."""
        return self.outcome == PASSED


def fly_job(job: Job, values: Mapping[str, Any]) -> Record:
    """Fly, and return what is kept; a flight that cannot be flown is a record, too."""
    try:
        result = fly_whole(job)
        record = record_of(job, values, result)
        if result.world is not None:
            result.world.release()  # the next world takes its memory: new memory costs more than the copy into it
        return record
    except CrazychoirError as error:
        return Record(job.number, CRASHED, dict(values), failures=(str(error),))
    except Exception as error:  # a user's code may raise anything
        return Record(job.number, CRASHED, dict(values), failures=(describe(error),))


def record_of(job: Job, values: Mapping[str, Any], result: FlightResult) -> Record:
    """Return what is kept of a flight."""
    return Record(
        job.number,
        PASSED if result.success else FAILED,
        dict(values),
        figures_of(result.summary),
        tuple(result.failures),
        digest_of(result),
        float(result.summary["sim_seconds"] or 0.0),
        float(result.summary["wall_seconds"] or 0.0),
    )


def fly_whole(job: Job, visuals: bool = False) -> FlightResult:
    """Fly, and return everything.

    Raises:
        CrazychoirError: If the mission cannot be flown.
    """
    from crazychoir_fw.flight.engine import fly

    if job.checkout is not None:  # of the whole process: variants fly in processes of their own
        os.environ[VARIABLE] = job.checkout
    return fly(load_job(job), threads=1, visuals=visuals)


def figures_of(summary: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of a summary by name: those of the swarm, and of each figure of the drones the worst."""
    found = {name: float(value) for name, value in summary.items() if _is_figure(name, value)}
    drones = summary.get("drones", [])
    for name in drones[0] if drones else ():
        values = [float(drone[name]) for drone in drones if _is_figure(name, drone.get(name))]
        if values:
            found[name] = min(values) if name.startswith(_LEAST) else max(values)
    for criterion in summary.get("criteria", []):
        if _is_figure(criterion["criterion"], criterion["value"]):
            found[criterion["criterion"]] = float(criterion["value"])
    margin = margin_of(summary)
    return found if margin is None else {**found, MARGIN: margin}


def margin_of(summary: Mapping[str, Any]) -> float | None:
    """Return how far the criterion that is nearest to its limit is from it, as a share of the limit; below 0 it fails.

    A criterion of which a least value is asked has a name that begins with ``min_``.
    """
    margins = []
    for criterion in summary.get("criteria", []):
        limit, value = criterion["limit"], criterion["value"]
        if isinstance(limit, bool) or not limit or value is None:
            continue
        slack = value - limit if criterion["criterion"].startswith("min_") else limit - value
        margins.append(slack / limit)
    return round(min(margins), 6) if margins else None


def _is_figure(name: str, value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    return is_number and name not in ("seed", "wall_seconds", "real_time_factor", "behind_s")


def digest_of(result: FlightResult) -> str:
    """Return a digest of the bits of a log: of its samples as the drones were read, where they are at hand."""
    log = result.log
    digest = hashlib.sha256(np.ravel(log.time).data)
    for name in sorted(log.signals):
        digest.update(name.encode())
    bits = log.signals.raw() if isinstance(log.signals, LazySignals) else log.signals.values()
    for samples in bits:
        digest.update(np.ravel(samples).data)
    return digest.hexdigest()
