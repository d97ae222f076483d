"""The drones of a mission: the start, vehicle and onboard software of each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from crazychoir_fw.common.constraints import choice, choices, number, point, switch, whole, word
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.values import (
    motor_ctrl_name,
    parameter_values,
    plain_properties,
    provider_word,
    source_files,
    vehicle_parameters,
)

PLATFORMS = ("cf2", "cf21bl")
OUT_OF_TREE = "out_of_tree"
"""The controller or estimator that an app brings."""

CONTROLLERS = ("pid", "mellinger", "indi", "brescianini", "lee", OUT_OF_TREE)
ESTIMATORS = ("kalman", "complementary", OUT_OF_TREE)
MOCAP_QUALITIES = ("good", "typical", "poor")
POSITIONINGS = ("mocap", "mocap_position", "lighthouse", "loco_twr", "loco_tdoa2", "loco_tdoa3", "flow", "none")
DECKS = ("multiranger", "zranger")
BUILTIN = "builtin"

FORCE_CONTROLLERS = ("brescianini", "lee")
"""Controllers that command newtons: for them the firmware's log of the thrust shows a torque."""

START_DISTANCE = 0.15
"""Least distance between two drones at start (m): the span of a Crazyflie with its propellers."""

Start = Annotated[tuple[float, ...], point("x", "y", "[z]", floor=0.0)]


class Payload(Section):
    """What a drone carries."""

    mass: Annotated[float, number(1e-5, 0.2, "kg")]
    """Mass (kg)."""

    offset: Annotated[tuple[float, ...], point("x", "y", "z", low=-0.5, high=0.5)] = (0.0, 0.0, 0.0)
    """Where it is fixed, seen from the body (m)."""

    detachable: Annotated[bool, switch()] = False
    """Whether it hangs on a hook that can let go."""


class Settings(Section):
    """What may be set for one drone, or in `defaults` for all of them."""

    platform: Annotated[str, choice(*PLATFORMS)] | None = None
    """Airframe: `cf2` is the Crazyflie 2.1+, `cf21bl` the Crazyflie 2.1 Brushless."""

    controller: Annotated[str, choice(*CONTROLLERS)] | None = None
    """Onboard controller."""

    estimator: Annotated[str, choice(*ESTIMATORS)] | None = None
    """Onboard state estimator; without it, what the positioning asks for."""

    positioning: Annotated[str, choice(*POSITIONINGS)] | None = None
    """Where position measurements come from."""

    mocap_quality: Annotated[str, choice(*MOCAP_QUALITIES)] | None = None
    """How good simulated motion capture is: `good`, `typical` or `poor`."""

    decks: Annotated[tuple[str, ...], choices(*DECKS)] | None = None
    """Decks beside the one that positions the drone: `multiranger`, `zranger`."""

    provider: Annotated[str, provider_word()] | None = None
    """Whose implementation of the onboard software flies; `builtin` is ours, others are loaded before the flight.
    `{bitcraze: {modules: [commander, supervisor]}}` flies at least these modules of a checkout, `modules: all` all that
    compile."""

    app: Annotated[tuple[str, ...], source_files()] | None = None
    """C files with a controller or an estimator of the user's, seen from the folder of the mission file."""

    noise: Annotated[float, number(0.0, 100.0)] | None = None
    """Factor on all sensor noise: 0 is noise-free, 1 is the real vehicle."""

    battery: Annotated[float, number(0.01, 1.0)] | None = None
    """State of charge at start: 1 is full."""

    mass: Annotated[float, number(0.005, 0.5, "kg")] | None = None
    """Mass of the vehicle (kg); without it, that of the airframe."""

    vehicle: Annotated[Mapping[str, Any], vehicle_parameters()] | None = None
    """Parameters of the vehicle by dotted name, such as `rotors.thrust_scale`; or a YAML file with some, `kit`,
    `legacy`, `nanobench`; or a list of these."""

    payload: Payload | None = None
    """What the drone carries."""

    parameters: Annotated[Mapping[str, float], parameter_values()] | None = None
    """Onboard parameters by their cflib names, such as `colAv.enable`, set before the flight."""

    motor_ctrl: Annotated[str, motor_ctrl_name()] | None = None
    """Class that flies the drone from Python: `package.module:Class`, or `file.py:Class` seen from the folder of the
    mission file. Such a drone flies itself: only phases that name it command it."""

    motor_ctrl_properties: Annotated[Mapping[str, str | float], plain_properties()] | None = None
    """Properties of that class."""


class DroneEntry(Settings):
    """One entry of the list `drones`."""

    id: Annotated[str, word(r"[A-Za-z]\w{0,30}", "a name of at most 31 letters, digits and _, such as cf1")]
    """Unique name."""

    position: Start
    """Start position (m, world frame): [x, y], or [x, y, z] for a start above the floor."""

    yaw_deg: Annotated[float, number(-360.0, 360.0, "deg")] = 0.0
    """Heading at start."""

    uri: Annotated[str, word(r"\w+://[^\s]{1,120}", "a URI such as radio://0/80/2M/E7E7E7E701")] | None = None
    """Where the backend `hardware` reaches it. With the backend `mixed`, drones that have one are real."""

    mocap: Annotated[str, word(r"[^\s]{1,120}", "the name of a body in motion capture, such as cf1")] | None = None
    """What motion capture calls it. With the backend `mixed`, a drone with this and without `uri` is only watched."""


LAYOUTS = ("grid", "line", "circle")


def places_in(layout: str, count: int, spacing: float, center: Sequence[float]) -> list[tuple[float, float]]:
    """Return the places [x, y] (m) of a square grid, a line along x, or a circle around a center."""
    x0, y0 = center
    if layout == "circle":
        radius = spacing / (2.0 * math.sin(math.pi / count)) if count > 1 else 0.0
        angles = [2.0 * math.pi * i / count for i in range(count)]
        return [(x0 + radius * math.cos(a), y0 + radius * math.sin(a)) for a in angles]
    columns = count if layout == "line" else math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    return [
        (x0 + (i % columns - (columns - 1) / 2) * spacing, y0 + (i // columns - (rows - 1) / 2) * spacing)
        for i in range(count)
    ]


class Layout(Settings):
    """`drones` as a formation: for swarms that are too large to list."""

    count: Annotated[int, whole(1, 10000)]
    """Number of drones; their ids are cf1, cf2, …"""

    layout: Annotated[str, choice(*LAYOUTS)] = "grid"
    """A square grid, a line along x, or a circle."""

    spacing: Annotated[float, number(START_DISTANCE, 100.0, "m")] = 0.5
    """Distance between neighbors."""

    center: Annotated[tuple[float, ...], point("x", "y")] = (0.0, 0.0)
    """Middle of the formation (m, world frame)."""

    def starts(self) -> list[tuple[float, float]]:
        """Return the start positions [x, y] (m, world frame)."""
        return places_in(self.layout, self.count, self.spacing, self.center)

    def entries(self) -> list[DroneEntry]:
        """Return the same drones as a list."""
        settings = {key: getattr(self, key) for key in Settings.model_fields}
        return [
            DroneEntry(id=f"cf{i}", position=position, **settings) for i, position in enumerate(self.starts(), start=1)
        ]


def _kind(value: Any) -> str:
    return "#layout" if isinstance(value, dict | Layout) else "#list"


# the tags begin with # so that the loader can drop them from the key path of a message
Drones = Annotated[
    Annotated[list[DroneEntry], Field(min_length=1), Tag("#list")] | Annotated[Layout, Tag("#layout")],
    Discriminator(_kind),
]


@dataclass(frozen=True)
class Drone:
    """One drone with everything decided: its own settings, then `defaults`, then those of the package."""

    id: str
    position: tuple[float, ...]  # (2,) or (3,) [m], world frame
    yaw_deg: float = 0.0
    platform: str = "cf2"
    controller: str | None = None  # None: what the app brings, else that of the provider
    estimator: str | None = None  # None: what the app brings, else what the positioning asks for
    positioning: str = "mocap"
    mocap_quality: str = "good"
    decks: tuple[str, ...] = ()
    provider: str = BUILTIN
    app: tuple[str, ...] = ()
    noise: float = 1.0
    battery: float = 1.0
    mass: float | None = None  # [kg]
    vehicle: Mapping[str, Any] = field(default_factory=dict)
    payload: Mapping[str, Any] | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    motor_ctrl: str | None = None
    motor_ctrl_properties: Mapping[str, str | float] = field(default_factory=dict)
    uri: str | None = None
    mocap: str | None = None


def drone_settings(drone: Drone) -> dict[str, Any]:
    """Return a drone as the keywords of `crazychoir_fw.simulation.DroneConfig`."""
    settings = asdict(drone)
    del settings["uri"], settings["mocap"]  # a simulated drone has none of its own
    return settings


def decide(
    drones: list[DroneEntry] | Layout, defaults: Settings, wind: Mapping[str, Any] = MappingProxyType({})
) -> tuple[Drone, ...]:
    """Return every drone with its settings decided, in the order of the file.

    Args:
        drones: The drones of the mission.
        defaults: Settings of those that do not say otherwise.
        wind: Parameters of the vehicles that describe the wind, before both.

    Raises:
        MissionError: If a drone has to fly a user's own C and carries none.
    """
    entries = drones.entries() if isinstance(drones, Layout) else drones
    common = defaults.model_dump(exclude_none=True)
    fleet = []
    for entry in entries:
        settings = common | entry.model_dump(exclude_none=True)
        settings["vehicle"] = {**wind, **(defaults.vehicle or {}), **(entry.vehicle or {})}
        settings["parameters"] = {**(defaults.parameters or {}), **(entry.parameters or {})}
        if settings.get("motor_ctrl") is None and settings.pop("motor_ctrl_properties", None):
            _check_unused_properties(entry, entries)
        drone = Drone(**settings)
        _check_out_of_tree(drone)
        fleet.append(drone)
    return tuple(fleet)


def _check_unused_properties(entry: DroneEntry, entries: Sequence[DroneEntry]) -> None:
    """Refuse properties that no motor control reads; those of `defaults` may pass by a drone if others have one."""
    told = entry.motor_ctrl_properties is not None
    if told or all(other.motor_ctrl is None for other in entries):
        who = entry.id if told else "defaults"
        raise MissionError(f"{who}: motor_ctrl_properties are for a motor control, but motor_ctrl names none")


def _check_out_of_tree(drone: Drone) -> None:
    """Refuse a drone that has to fly C of an app and carries none."""
    for key in ("controller", "estimator"):
        # a provider with an app in its name was loaded by the code that asks for it
        if getattr(drone, key) == OUT_OF_TREE and not drone.app and "+" not in drone.provider:
            raise MissionError(
                f"{drone.id} has {key} '{OUT_OF_TREE}', but no app: name the C file that brings it, for instance "
                f"app: my_{key}.c"
            )


def close_pair(drones: tuple[Drone, ...]) -> tuple[int, int, float] | None:
    """Return two drones (indices, distance in m) that start closer than START_DISTANCE, if there are any."""
    cells: dict[tuple[int, ...], list[int]] = {}
    for i, drone in enumerate(drones):
        here = (*drone.position, 0.0)[:3]
        x, y, z = (math.floor(v / START_DISTANCE) for v in here)
        neighborhood = [(x + dx, y + dy, z + dz) for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1)]
        for j in (j for cell in neighborhood for j in cells.get(cell, ())):
            distance = math.dist(here, (*drones[j].position, 0.0)[:3])
            # a formation with the least spacing is allowed to round
            if distance < START_DISTANCE - 1e-9:
                return j, i, distance
        cells.setdefault((x, y, z), []).append(i)
    return None
