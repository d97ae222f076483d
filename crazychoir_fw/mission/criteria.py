"""What makes a flight with layers a success."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict

from crazychoir_fw.common.constraints import number, switch
from crazychoir_fw.mission.section import Section


class Criteria(Section):
    """What makes the flight a success; what is not named is not asked for.

    Further keys are those that the laws of the mission declare, see `crazychoir_fw.guidance.metrics`; `layer_checks`
    refuses all others.
    """

    model_config = ConfigDict(extra="allow", frozen=True)

    position_error_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest distance of a drone from its place then."""

    tracking_rms_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Largest RMS distance of a drone from its reference while it follows a trajectory."""

    min_distance_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """Least distance between two drones in flight."""

    min_horizontal_distance_m: Annotated[float, number(0.0, 1000.0, "m")] | None = None
    """The same in the plane, where filters of `safety` work: heights do not count."""

    landed: Annotated[bool, switch()] = True
    """Whether all drones must stand on the floor at the end, if the flight ends with a landing."""

    @property
    def of_laws(self) -> dict[str, Any]:
        """Limits of criteria that laws declare, by key; those that are not asked for are left out."""
        return {
            key: limit for key, limit in (self.model_extra or {}).items() if limit is not None and limit is not False
        }
