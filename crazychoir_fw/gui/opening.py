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
        uri_base: URI of the first real drone, if the others follow it; see `numbered_uris`.
        overrides: What is stronger than the file, for `load_mission`.

    Raises:
        MissionError: If the file cannot be flown.
    """
    from crazychoir_fw.mission.layers import GuidanceLayer, Layers
    from crazychoir_fw.mission.numbered_uris import load_numbered
    from crazychoir_fw.mission.schema import LayeredMission

    mission = load_numbered(path, uri_base, overrides)
    if isinstance(mission, LayeredMission):
        return mission
    given = {name: getattr(mission, name) for name in type(mission).model_fields if name != "flight"}
    layers = Layers(guidance=GuidanceLayer.model_validate({"class": "SimpleGuidance"}))
    return LayeredMission.model_construct(**given, flight=[], layers=layers)
