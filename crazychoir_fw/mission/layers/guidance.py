"""What decides where the drones go."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Discriminator, Field, Tag

from crazychoir_fw.common.constraints import choice, number, point
from crazychoir_fw.guidance import CFGuidance
from crazychoir_fw.mission.communication import Communication
from crazychoir_fw.mission.factory import class_of
from crazychoir_fw.mission.fleet import LAYOUTS, places_in
from crazychoir_fw.mission.layers.control import ControlLayer, PlanningLayer
from crazychoir_fw.mission.layers.values import Gains, Name, Options, class_word
from crazychoir_fw.mission.section import Section


class Places(Section):
    """A formation by rule, for as many drones as there are."""

    layout: Annotated[str, choice(*LAYOUTS)]
    """A square grid, a line along x, or a circle."""

    spacing: Annotated[float, number(0.0, 100.0, "m")]
    """Distance between neighbors (m)."""

    center: Annotated[tuple[float, ...], point("x", "y")] = (0.0, 0.0)
    """Middle of the formation (m, world)."""

    def of(self, count: int) -> list[tuple[float, float]]:
        """Return the places [x, y] (m) of so many drones."""
        return places_in(self.layout, count, self.spacing, self.center)


Place = Annotated[tuple[float, ...], point("x", "y", "[z]")]


class GuidanceLayer(Section):
    """What decides where the drones go."""

    kind: Annotated[str, class_word("guidance")] = Field(alias="class")
    """A name of the registry, or a class of yours."""

    drones: Annotated[list[Name], Field(min_length=1)] | None = None
    """Whom it decides for, where there are several kinds of guidance."""

    leaders: list[Name] = Field(default_factory=list)
    """Drones that do not follow the formation, but their own trajectory, or stay."""

    formation: (
        Annotated[
            Annotated[list[Place], Tag("#list")] | Annotated[Places, Tag("#places")],
            Discriminator(lambda value: "#places" if isinstance(value, Mapping | Places) else "#list"),
        ]
        | None
    ) = None
    """Where the drones are in the formation (m), in the order of `drones`, or how they are laid out: what counts is the
    bearing between two of them, or their distance."""

    gains: Gains | None = None
    """Set of gains; None is that of the class."""

    height: Annotated[float, number(0.05, 100.0, "m")] = 1.0
    """Height of the take-off (m)."""

    goals: Mapping[str, list[Annotated[tuple[float, ...], point("duration", "x", "y", "z")]]] | None = None
    """Of laws that take goals: rows [duration (s), x, y, z (m)] by drone."""

    options: Options = Field(default_factory=dict)
    """Further keyword arguments of the class."""

    options_by_drone: Mapping[str, Options] = Field(default_factory=dict)
    """Those that differ from drone to drone, by its id."""

    communication: Communication | None = None
    """Who of its drones talks to whom, in a list of several kinds: beside what all have in common."""

    planning: PlanningLayer | None = None
    """What plans for its drones, instead of what plans for all."""

    control: ControlLayer | None = None
    """What controls its drones, instead of what controls all."""

    def law(self, key: str = "layers.guidance.class") -> type[CFGuidance]:
        """Return the class of the law, named in the file at a key."""
        return class_of(self, "guidance", key, self.kind, CFGuidance)


def _shape_of_guidance(value: object) -> str:
    # tags with # are left out of messages
    return "#several" if isinstance(value, list | tuple) else "#one"


GuidanceEntries = Annotated[
    Annotated[GuidanceLayer, Tag("#one")] | Annotated[list[GuidanceLayer], Field(min_length=1), Tag("#several")],
    Discriminator(_shape_of_guidance),
]
