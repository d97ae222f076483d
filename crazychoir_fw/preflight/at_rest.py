"""Drones that stand still for a while: how their positions spread, and how well their links carry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.preflight.check import Check, check

if TYPE_CHECKING:
    from crazychoir_fw.flight.hardware_backend import HardwareBackend
    from crazychoir_fw.radio import RadioDrone

Array = NDArray[np.float64]

REST_S = 2.0
"""How long drones are looked at (s)."""
_WINDOWS = 4  # of that time, until they keep still
SPREAD_M = 0.05
"""Largest distance from its mean (m) that the position of a drone at rest may have."""
LEAST_QUALITY = 80.0
"""Share of packets (%) that must get through at the first attempt or nearly so."""
LATENCY_S = 0.1
"""Time to a drone and back (s) beyond which setpoints come too late."""


@dataclass
class Rest:
    """What was seen of some drones."""

    positions: list[Array] = field(default_factory=list)
    """Of all drones (m), shape (N, 3), at several times."""
    quality: dict[str, float] = field(default_factory=dict)
    """By drone, how well its link carries (%); links without a Crazyradio say nothing."""


def look(backends: Sequence[HardwareBackend]) -> list[Rest]:
    """Look at the drones of each backend for a while, one backend after the other.

    Estimators that were just reset have some time to settle.
    """
    found = []
    for backend in backends:
        rest = Rest()
        with _qualities({drone.agent_id: drone for drone in backend.handler}, rest.quality):
            for _ in range(_WINDOWS):
                rest.positions = _sample(backend)
                if (spreads(rest.positions) <= SPREAD_M).all():
                    break
        found.append(rest)
    return found


def _sample(backend: HardwareBackend) -> list[Array]:
    positions: list[Array] = []

    def goes_on() -> bool:
        positions.append(backend.true_positions())
        return False

    backend.wait_until(goes_on, REST_S)
    return positions


def spreads(positions: Sequence[Array]) -> Array:
    """Return the largest distance (m) of each drone from its mean, shape (N,); NaN where it was not seen twice.

    Args:
        positions: Of all drones (m), shape (N, 3), at several times.
    """
    samples = np.array(positions)  # (T, N, 3)
    found = np.full(samples.shape[1], np.nan)
    for i in range(len(found)):
        known = samples[np.isfinite(samples[:, i]).all(axis=1), i]
        if len(known) > 1:
            found[i] = np.linalg.norm(known - known.mean(axis=0), axis=1).max()
    return found


@contextmanager
def _qualities(drones: Mapping[str, RadioDrone], told: dict[str, float]) -> Iterator[None]:
    callbacks: list[tuple[RadioDrone, Callable[..., None]]] = []
    for name, drone in drones.items():

        def hear(quality: float, name: str = name) -> None:
            told[name] = float(quality)

        drone.cf.link_statistics.link_quality_updated.add_callback(hear)
        callbacks.append((drone, hear))
    try:
        yield
    finally:
        for drone, hear in callbacks:
            drone.cf.link_statistics.link_quality_updated.remove_callback(hear)


def positioning(seen: Sequence[Rest], names: Sequence[Sequence[str]]) -> Check:
    """Return whether positions keep still while drones do.

    Args:
        seen: What was seen, by backend.
        names: The drones of each backend.
    """
    problems, worst = [], 0.0
    for rest, group in zip(seen, names, strict=True):
        for name, far in zip(group, spreads(rest.positions).tolist(), strict=True):
            if np.isnan(far):
                problems.append(f"{name} does not say where it is")
            elif far > SPREAD_M:
                problems.append(f"{name} wanders by {100 * far:.1f} cm")
            worst = max(worst, far)
    return check("positioning", problems, f"at rest within {100 * worst:.1f} cm")


def links(seen: Sequence[Rest], drones: Mapping[str, RadioDrone]) -> Check:
    """Return whether the links of all drones carry what a flight sends."""
    quality = {name: value for rest in seen for name, value in rest.quality.items()}
    late = {name: drone.link_latency_s for name, drone in drones.items()}
    problems = [
        f"{name}: {value:.0f} % of packets get through" for name, value in quality.items() if value < LEAST_QUALITY
    ]
    problems += [f"{name} answers within {1e3 * value:.0f} ms" for name, value in late.items() if value > LATENCY_S]
    good = f"95 % of answers within {1e3 * max(late.values()):.0f} ms"
    return check("links", problems, f"{good}, {min(quality.values()):.0f} % get through" if quality else good)
