"""Moment of forward flight and drag, as those with which predictions come closest.

A regression of torques takes them too small where the true motion is noisy: 9 % of `flight_moment.x` on flights of our
own simulator with motors that wander by 2 % and markers that jitter by 0.15 degrees. The errors of predictions whose
trim is followed are least within 4 % of the truth there. They tell nothing of inertia on calm flights: the more of it,
the less a torque that nobody knows can do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.comparison.nanobench import RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.prediction import predict
from crazychoir_fw.comparison.signals import Array
from crazychoir_fw.comparison.tuning import tune

try:
    from scipy.optimize import minimize
except ImportError:
    minimize = None

REFINED = ("flight_moment.x", "flight_moment.y", "drag.rotor_xy")

_FIRST_STEP = 0.12  # of the logarithm of each
_ENOUGH = 0.005  # of the same
_MAX_TRIES = 45


def check_refinable() -> None:
    """See whether `refine` can do its work, before others begin theirs.

    Raises:
        MissingLibraryError: If scipy is not installed.
    """
    if minimize is None:
        raise MissingLibraryError(
            "refining needs scipy: run pip install scipy; --no-refining (refines=False) does without"
        )


def refine(
    parts: Sequence[tuple[RecordedFlight, Phases]],
    vehicle: Mapping[str, Any],
    report: Callable[[str], None] = lambda sentence: None,
) -> dict[str, float]:
    """Return the parameters `REFINED` that leave the least errors of predictions, from those of a vehicle on.

    What is minimized is the mean over flights, horizons, position and tilt of squares of errors, each in units of the
    root mean square that it has at first.

    Args:
        parts: Flights, and their parts.
        vehicle: Parameters that differ from the platform's.
        report: Told what came about, in a sentence.

    Raises:
        MissingLibraryError: If scipy is not installed.
    """
    check_refinable()
    start = np.log([vehicle[name] for name in REFINED])

    def errors(point: Array) -> Array:
        tried = {**vehicle, **_named(point)}
        squares = []
        for flight, phases in parts:
            ahead = predict(flight, phases, tried, tune(flight, phases, tried))
            squares.append(np.square([*ahead.followed_position_cm, *ahead.followed_tilt_deg]))
        return np.mean(squares, axis=0)

    unit = errors(start)
    simplex = start + _FIRST_STEP * np.vstack([np.zeros(len(REFINED)), np.eye(len(REFINED))])
    found = minimize(
        lambda point: float(np.mean(errors(point) / unit)),
        start,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": _ENOUGH, "fatol": 1e-4, "maxfev": _MAX_TRIES},
    )
    report(f"squares of errors of predictions are {100 * found.fun:.1f} % with {_words(_named(found.x))}")
    return _named(found.x)


def _named(point: Array) -> dict[str, float]:
    return {name: float(value) for name, value in zip(REFINED, np.exp(point), strict=True)}


def _words(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.3g}" for name, value in values.items())
