"""How far the nearest two drones are apart in flights with a safety filter, for the picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crazychoir_fw.recording.error_curve import ErrorCurve

if TYPE_CHECKING:
    from crazychoir_fw.flight.criteria import Judge
    from crazychoir_fw.mission.schema import LayeredMission


def distance_curve(mission: LayeredMission, judge: Judge) -> ErrorCurve | None:
    """Return the least horizontal distance over time, if a filter keeps drones apart and two of them flew together.

    The limit is that of the criterion, otherwise the filter's distance. Crosses show the reference positions.
    """
    layer, limit = mission.layers.safety, mission.criteria.min_horizontal_distance_m
    if layer is None:
        return None
    least = judge.horizontal_distances()
    if np.isnan(least).all():
        return None
    return ErrorCurve(
        "least distance (m)",
        least,
        least,
        layer.distance if limit is None else limit,
        judge.places(),
        is_logarithmic=False,
        note="the nearest two drones, horizontally",
    )
