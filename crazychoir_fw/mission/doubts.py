"""Places that a mission may mean otherwise: centimeters taken for meters, and what a safety area forbids."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.fleet import Layout
from crazychoir_fw.mission.mixed import is_real
from crazychoir_fw.mission.schema import LayeredMission, Mission

FAR_M = 20.0
"""Distance from the origin along an axis beyond which a place is asked about (m)."""

_Place = tuple[str, Sequence[float], list[int]]
"""Key in the file, place (m), and the numbers of the drones that it is for."""


def doubts(mission: Mission) -> list[str]:
    """Return sentences about places that are so far away that they may be in centimeters."""
    far = [(key, at) for key, at, _ in _places(mission) if max(map(abs, at)) > FAR_M]
    if not far:
        return []
    key, at = far[0]
    more = "" if len(far) == 1 else f"; of its places {len(far)} are so far"
    return [f"{key} is {_shown(at)}, more than {FAR_M:g} m from the origin: {_proposal(at)}{more}"]


def check_safety_area(mission: LayeredMission) -> None:
    """Refuse places of real drones outside of the area that they are kept in.

    Raises:
        MissionError: With the first such place.
    """
    area = mission.hardware.safety_area
    if area is None or mission.backend not in ("hardware", "mixed"):
        return
    for key, at, drones in _places(mission):
        if mission.backend == "mixed" and not any(is_real(mission.fleet[i]) for i in drones):
            continue
        if not _is_inside(at, area):
            box = f"hardware.safety_area, {_shown(area.low)} to {_shown(area.high)}"
            hint = f": {_proposal(at)}" if max(map(abs, at)) > FAR_M else ""
            raise MissionError(f"{key} is {_shown(at)}, outside of {box}{hint}")


def _is_inside(at: Sequence[float], area: Any) -> bool:
    # drones start on the floor, wherever that is
    axes = 2 if len(at) < 3 or at[2] == 0.0 else 3
    return all(low <= value <= high for low, value, high in zip(area.low[:axes], at, area.high, strict=False))


def _places(mission: Mission) -> Iterator[_Place]:
    everyone = list(range(len(mission.fleet)))
    if not isinstance(mission.drones, Layout):  # which keeps a distance that the file says
        for i, drone in enumerate(mission.fleet):
            yield f"drones[{i}].position", drone.position, [i]
    for i, phase in enumerate(mission.flight):
        for order in phase.orders:
            at = getattr(order.maneuver, "position", None)
            if order.name == "go_to" and at is not None:
                wanted = order.maneuver.drones
                numbers = [k for k in everyone if wanted is None or mission.fleet[k].id in wanted]
                yield f"flight[{i}].go_to.position", at, numbers


def _proposal(at: Sequence[float]) -> str:
    return f"places are in meters; {_shown([value / 100.0 for value in at])} if it was meant in centimeters"


def _shown(at: Sequence[float]) -> str:
    return f"[{', '.join(f'{value:g}' for value in at)}]"
