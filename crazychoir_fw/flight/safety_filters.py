"""From a mission to what keeps its drones apart."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from crazychoir_fw.control import safety
from crazychoir_fw.flight.sensing import Sensing
from crazychoir_fw.mission.factory import build

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission


def make_safety_filter(mission: LayeredMission) -> Any:
    """Return what keeps drones apart, or None.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    layer = mission.layers.safety
    if layer is None:
        return None
    distances = {"distance": layer.distance + layer.margin, "keep_right": layer.keep_right}
    return build(layer.law(), "layers.safety", distances, layer.of_filter)


def make_collision_avoidance(mission: LayeredMission) -> Any:
    """Return the filter between velocity controllers and drones, or None if there is none of that kind."""
    filter_ = make_safety_filter(mission)
    if filter_ is None or filter_.filters != "velocity":
        return None
    return safety.SingleIntegratorCollisionAvoidance(filter_)


def make_sensing(mission: LayeredMission, truth: Callable[[], Any] | None = None) -> Sensing | None:
    """Return what the drones see each other by, or None.

    Args:
        mission: The mission.
        truth: Returns the true poses, for missions whose drones see others where they are.
    """
    layer = mission.layers.safety
    if layer is None:
        return None
    rate = float(layer.sensing_rate or mission.layers.rate)
    return Sensing(layer.sensing_distance, rate, truth if layer.sees == "truth" else None)
