"""What makes a flight with layers a success."""

from __future__ import annotations

from typing import Annotated

from crazychoir_fw.common.constraints import number, switch, whole
from crazychoir_fw.mission.section import Section


class Criteria(Section):
    """What makes the flight a success; what is not named is not asked for."""

    bearing_error_deg: Annotated[float, number(0.0, 180.0, "deg")] | None = None
    """Largest mean error of the bearings over all edges, at the end of the last `start`."""

    bearing_error_max_deg: Annotated[float, number(0.0, 180.0, "deg")] | None = None
    """Largest error of a single bearing then."""

    distance_error_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest error of a distance between neighbors of a formation then."""

    coupling_error_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """By how much neighbors may ever be farther apart than `MPCGuidance` allows."""

    containment: Annotated[bool, switch()] = False
    """Whether followers must then be within the convex hull of the leaders."""

    position_error_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest distance of a drone from its place then."""

    tracking_rms_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest RMS distance of a drone from its reference while it follows a trajectory."""

    surveillance_error_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest distance of a defender from where it should be, on average over the last second of the last `start`."""

    surveillance_rms_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest RMS of that distance over the second half of the last `start`: how far defenders are behind."""

    min_distance_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Least distance between two drones in flight."""

    min_horizontal_distance_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """The same in the plane, where filters of `safety` work: heights do not count."""

    tasks_completed: Annotated[int, whole(0, 1_000_000)] | None = None
    """Least number of tasks, or deliveries, that were completed."""

    assignment_optimal: Annotated[bool, switch()] = False
    """Whether drones must have shared out each list of tasks as well as one who knows everything could."""

    routes_gap: Annotated[float, number(0.0, 10.0)] | None = None
    """Largest part by which all routes of `DeliveryGuidance` together may be longer than the lower bound."""

    landed: Annotated[bool, switch()] = True
    """Whether all drones must stand on the floor at the end, if the flight ends with a landing."""
