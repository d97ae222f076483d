"""From a mission file to what the page flies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission


def open_mission(path: Path, uri_base: str | None = None, **overrides: Any) -> LayeredMission:
    """Return a mission; the drones of one without layers get buttons, and are flown by their planners on board.

    Args:
        path: The mission file.
        uri_base: URI of the first real drone, if the others follow it.
        overrides: What is stronger than the file, for `load_mission`.

    Raises:
        MissionError: If the file cannot be flown.
    """
    from crazychoir_fw.mission.layers import GuidanceLayer, Layers
    from crazychoir_fw.mission.loader import load_mission
    from crazychoir_fw.mission.schema import LayeredMission

    mission: Any = load_mission(path, uri_base, **overrides)
    if mission.layers is not None:
        return mission
    given = {name: getattr(mission, name) for name in type(mission).model_fields if name != "layers"}
    layers = Layers(guidance=GuidanceLayer.model_validate({"class": "SimpleGuidance"}))
    return LayeredMission.model_construct(**given, layers=layers)
