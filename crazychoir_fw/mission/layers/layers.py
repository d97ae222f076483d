"""The key `layers`: guidance, planning, control and communication."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from crazychoir_fw.common.constraints import choice, number
from crazychoir_fw.mission.communication import Communication
from crazychoir_fw.mission.layers.control import ControlLayer, PlanningLayer
from crazychoir_fw.mission.layers.guidance import GuidanceEntries, GuidanceLayer
from crazychoir_fw.mission.layers.safety import SafetyLayer
from crazychoir_fw.mission.layers.tables import DeliveryLayer, TasksLayer
from crazychoir_fw.mission.layers.values import Rate
from crazychoir_fw.mission.section import Section

ODOMETRY = ("estimate", "truth", "mocap")


class Layers(Section):
    """The key `layers`."""

    rate: Rate = 100
    """Rounds per second (Hz)."""

    command_timeout_s: Annotated[float, number(0.02, 10.0, "s")] = 0.2
    """After which a simulated drone without commands stays where it is, by its planner on board:
    a layer of it in another process was killed. Over the radio its handler has a time-out of its own."""

    odometry: Annotated[str, choice(*ODOMETRY)] = "estimate"
    """Where the layers know the poses from: `estimate` of the onboard filter, `truth`, or `mocap`, noisy poses whose
    velocity comes from a derivative filter."""

    communication: Communication = Communication()
    """The communication graph."""

    decides: GuidanceEntries = Field(alias="guidance")
    """What decides: one for all, or a list of which each entry names its `drones`."""

    planning: PlanningLayer | None = None
    """What plans; without it points go to the planners on board."""

    control: ControlLayer | None = None
    """What controls; without it points go to the planners on board."""

    safety: SafetyLayer | None = None
    """What keeps drones apart; without it nothing does."""

    tasks: TasksLayer | None = None
    """Table of tasks, for `TaskGuidance`."""

    delivery: DeliveryLayer | None = None
    """Table of requests, for `DeliveryGuidance`."""

    @property
    def guidance(self) -> GuidanceLayer:
        """What decides; the first, where there are several kinds."""
        return self.guidances[0]

    @property
    def guidances(self) -> tuple[GuidanceLayer, ...]:
        """All that decides."""
        return tuple(self.decides) if isinstance(self.decides, list) else (self.decides,)

    def entry_of(self, name: str) -> int:
        """Return which of `guidances` decides for a drone."""
        if isinstance(self.decides, list):
            for number, entry in enumerate(self.decides):
                if entry.drones is None or name in entry.drones:
                    return number
        return 0

    def guidance_of(self, name: str) -> GuidanceLayer:
        """Return what decides for a drone."""
        return self.guidances[self.entry_of(name)]

    def communication_of(self, name: str) -> Communication:
        """Return how a drone talks to others."""
        return self.guidance_of(name).communication or self.communication

    def planning_of(self, name: str) -> PlanningLayer | None:
        """Return what plans for a drone."""
        entry = self.guidance_of(name)
        return entry.planning if "planning" in entry.model_fields_set else self.planning

    def control_of(self, name: str) -> ControlLayer | None:
        """Return what controls a drone."""
        entry = self.guidance_of(name)
        return entry.control if "control" in entry.model_fields_set else self.control

    @property
    def commands(self) -> tuple[str, ...]:
        """What drones are commanded by: fpqr, frpy, vel, or xyz where they plan on board."""
        controls = [self.control, *(entry.control for entry in self.guidances if "control" in entry.model_fields_set)]
        if all("control" in entry.model_fields_set for entry in self.guidances):
            controls = controls[1:]
        return tuple(dict.fromkeys("xyz" if one is None else one.command for one in controls))

    def path_of(self, name: str, layer: str = "guidance") -> str:
        """Return where in the file a layer of a drone stands."""
        entry = "layers.guidance" + (f"[{self.entry_of(name)}]" if isinstance(self.decides, list) else "")
        if layer == "guidance":
            return entry
        return f"{entry}.{layer}" if layer in self.guidance_of(name).model_fields_set else f"layers.{layer}"
