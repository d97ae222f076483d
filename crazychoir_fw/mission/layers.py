"""The key `layers` of a mission file: what decides, plans and controls, and who talks to whom.

Which classes there are, and what they take, is known to the layers alone; here stands how they are named.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationInfo

from crazychoir_fw.mission.communication import Communication
from crazychoir_fw.mission.fleet import LAYOUTS, places_in
from crazychoir_fw.mission.mixed import MocapSettings
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.values import (
    choice,
    did_you_mean,
    existing_file,
    number,
    point,
    refusal,
    switch,
    whole,
    word,
)

GUIDANCE = (
    "BearingFormation",
    "SimpleGuidance",
    "GoToGuidance",
    "TaskGuidance",
    "DeliveryGuidance",
    "TargetListGuidance",
    "SimpleDIControl",
    "FormationControl",
    "FormationControlGuidance",
    "Containment",
    "ContainmentGuidance",
    "TimeVaryingContainment",
    "TimeVaryingContainmentGuidance",
    "MPCGuidance",
    "AggregativeGuidance",
    "AggregativeGuidanceCrazyflie",
    "AggregativeGuidanceCrazyflieMovingIntruder",
)
"""Classes of `crazychoir_fw.guidance` and `crazychoir_fw.schemes`."""

PLANNING = ("Spline", "SplinePosition", "Polynomial7th", "MinimumSnap")
CONTROL = ("HierarchicalController", "VelocityController")
POSITION = ("FlatnessPositionCtrl",)
ACCELERATION = ("FlatnessAccelerationCtrl",)
ATTITUDE = ("GeometryAttitudeCtrl",)
VELOCITY = ("VelocityCtrlStrategy",)
FILTERS = ("SingleIntegratorCBF", "DoubleIntegratorCBF")
SENDERS = {"FPQRSender": "fpqr", "FRPYSender": "frpy", "VelSender": "vel"}
"""What each sender sends."""

ODOMETRY = ("estimate", "truth", "mocap")
RATES = (10, 20, 25, 50, 100)
"""Rounds per second (Hz): whole steps of every backend."""


def class_word(*known: str) -> BeforeValidator:
    """A class by a word that is known, or one of the user's: package.module:Class or file.py:Class."""
    must = f"one of {', '.join(known)}, package.module:Class or file.py:Class"

    def check(value: object, info: ValidationInfo) -> str:
        if isinstance(value, str) and value in known:
            return value
        if not isinstance(value, str) or not re.fullmatch(r"(.*\.py|[\w.]+):[^\W\d]\w*", value):
            raise refusal(must + did_you_mean(value, known))
        file, _, class_name = value.rpartition(":")
        if not file.endswith(".py"):
            return value
        return f"{existing_file(file, info, must)}:{class_name}"

    return BeforeValidator(check)


def gain_set() -> BeforeValidator:
    """The name of a set of gains, or a mapping of what differs from the default set."""
    must = "the name of a set of gains, or a mapping such as {k_p: 0.2, k_v: [1, 1, 1]}"

    def is_gain(value: object) -> bool:
        items = value if isinstance(value, Sequence) and not isinstance(value, str | bytes) else [value]
        return len(items) in (1, 3) and all(
            isinstance(item, int | float) and not isinstance(item, bool) and -1e6 <= item <= 1e6 for item in items
        )

    def check(value: object) -> str | dict[str, Any]:
        if isinstance(value, str) and re.fullmatch(r"[a-z]\w{0,30}", value):
            return value
        is_mapping = isinstance(value, Mapping) and len(value) > 0
        if is_mapping and all(
            isinstance(key, str) and (is_gain(item) or key == "base")
            for key, item in value.items()  # type: ignore[union-attr]
        ):
            return dict(value)  # type: ignore[call-overload]
        raise refusal(must)

    return BeforeValidator(check)


def law_gains() -> BeforeValidator:
    """The name of a set of gains of all laws, or one for each kind of law."""
    must = "the name of a set of gains, or a mapping of position, attitude, velocity to one each"
    of_one = gain_set().func

    def check(value: object) -> str | dict[str, Any]:
        if isinstance(value, Mapping) and value:
            if set(value) <= {"position", "attitude", "velocity"}:
                return {key: of_one(item) for key, item in value.items()}  # type: ignore[call-arg]
        elif isinstance(value, str):
            return of_one(value)  # type: ignore[call-arg]
        raise refusal(must)

    return BeforeValidator(check)


def plain_options() -> BeforeValidator:
    """Keyword arguments for a class of the user's."""
    must = "a mapping from words to plain values, such as {radius: 0.5}"

    def check(value: object) -> dict[str, Any]:
        if not isinstance(value, Mapping) or not all(
            isinstance(key, str) and key.isidentifier() and not key.startswith("_") for key in value
        ):
            raise refusal(must)
        return dict(value)

    return BeforeValidator(check)


Name = Annotated[str, word(r"[A-Za-z]\w{0,30}", "the id of a drone")]
Options = Annotated[Mapping[str, Any], plain_options()]
Gains = Annotated[str | Mapping[str, Any], gain_set()]


class Goal(Section):
    """One point of a list of go-tos."""

    position: Annotated[tuple[float, ...], point("x", "y", "z", floor=0.0)]
    duration: Annotated[float, number(0.1, 3600.0, "s")]


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


class PlanningLayer(Section):
    """What makes references out of points."""

    kind: Annotated[str, class_word(*PLANNING)] = Field(alias="class")
    """`Spline`, `SplinePosition`, `Polynomial7th`, `MinimumSnap`, or a class of yours."""

    options: Options = Field(default_factory=dict)
    """Further keyword arguments of the class."""


class ControlLayer(Section):
    """What turns references into commands."""

    kind: Annotated[str, class_word(*CONTROL)] = Field("HierarchicalController", alias="class")
    """`HierarchicalController` or `VelocityController`."""

    position: Annotated[str, class_word(*POSITION)] = "FlatnessPositionCtrl"
    """Law of drones that follow a trajectory."""

    acceleration: Annotated[str, class_word(*ACCELERATION)] = "FlatnessAccelerationCtrl"
    """Law of drones whose guidance asks for accelerations."""

    attitude: Annotated[str, class_word(*ATTITUDE)] = "GeometryAttitudeCtrl"
    """Law from attitude to body rates."""

    velocity: Annotated[str, class_word(*VELOCITY)] = "VelocityCtrlStrategy"
    """Law of a `VelocityController`."""

    sender: Annotated[str, choice(*SENDERS)] | None = None
    """`FPQRSender`, `FRPYSender`, `VelSender`; None is that of the class."""

    gains: Annotated[str | Mapping[str, Any], law_gains()] = "webots"
    """Set of gains of all laws, or {position: ..., attitude: ..., velocity: ...}."""

    mass: Annotated[float, number(0.005, 1.0, "kg")] | None = None
    """Mass that the laws believe in (kg); None is that of the vehicle."""

    rate: Annotated[int, BeforeValidator(lambda value: _rate(value))] | None = None
    """Commands per second (Hz), a divisor of the rate of the layers; None is that rate."""

    @property
    def command(self) -> str:
        """What is sent: fpqr, frpy or vel."""
        if self.sender is not None:
            return SENDERS[self.sender]
        return "vel" if self.kind == "VelocityController" else "fpqr"


class GuidanceLayer(Section):
    """What decides where the drones go."""

    kind: Annotated[str, class_word(*GUIDANCE)] = Field(alias="class")
    """One of `GUIDANCE`, or a class of yours."""

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
    """Of `GoToGuidance`: rows [duration (s), x, y, z (m)] by drone."""

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


def _shape_of_guidance(value: object) -> str:
    # tags with # are left out of messages
    return "#several" if isinstance(value, list | tuple) else "#one"


GuidanceEntries = Annotated[
    Annotated[GuidanceLayer, Tag("#one")] | Annotated[list[GuidanceLayer], Field(min_length=1), Tag("#several")],
    Discriminator(_shape_of_guidance),
]


class SafetyLayer(Section):
    """What keeps drones apart, whatever guidance and planning want; see docs/optimization.md."""

    filter: Annotated[str, choice(*FILTERS)]
    """`DoubleIntegratorCBF` filters accelerations within a `HierarchicalController`, `SingleIntegratorCBF` velocities
    behind a `VelocityController`."""

    distance: Annotated[float, number(0.01, 10.0, "m")] = 0.4
    """Least distance of two drones, horizontally (m)."""

    margin: Annotated[float, number(0.0, 5.0, "m")] = 0.0
    """Added to the distance for the filter (m): what real drones fall short of the filter's ideal ones."""

    gamma: Annotated[float, number(1e-6, 1e6)] | None = None
    """How fast a barrier may fall: higher brakes later; None is that of the class."""

    kappa: Annotated[float, number(1e-3, 2.0)] | None = None
    """Of accelerations: share of both drones' braking that is counted on."""

    max_acceleration: Annotated[float, number(1e-3, 10.0, "m/s^2")] | None = None
    """Of accelerations: largest one, along x and along y (m/s^2)."""

    max_braking_acceleration: Annotated[float, number(1e-3, 10.0, "m/s^2")] | None = None
    """Of accelerations: deceleration of who must brake (m/s^2)."""

    max_velocity: Annotated[float, number(1e-3, 10.0, "m/s")] | None = None
    """Of velocities: largest one, along x and along y (m/s)."""

    max_braking_velocity: Annotated[float, number(1e-3, 10.0, "m/s")] | None = None
    """Of velocities: speed at which who is too near backs off (m/s)."""

    keep_right: Annotated[float, number(0.0, 10.0)] = 1.0
    """Which part of what the filter takes away goes to the right: drones that block each other turn about each other.
    0 is the filter alone, behind which they may wait for ever."""

    rate: Annotated[int, BeforeValidator(lambda value: _rate(value))] | None = None
    """Of velocities: how often the latest one is filtered (Hz), a divisor of the rate of the layers; None is that."""

    sensing_distance: Annotated[float, number(0.05, 100.0, "m")] = 3.0
    """How far a drone sees others, horizontally (m)."""

    sensing_rate: Annotated[int, BeforeValidator(lambda value: _rate(value))] | None = None
    """How often it looks (Hz), a divisor of the rate of the layers; None is that rate."""

    sees: Annotated[str, choice("odometry", "truth")] = "odometry"
    """Whether drones see others where these believe to be, or where they are."""


def _rate(value: object) -> int:
    if isinstance(value, bool) or value not in RATES:
        raise refusal(f"one of {', '.join(map(str, RATES))} Hz")
    return int(value)  # type: ignore[call-overload]


class TasksLayer(Section):
    """The table that `TaskGuidance` works for: points to be visited, always as many as drones."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 4
    """Seed of the draws."""

    low: Annotated[tuple[float, ...], point("x", "y")] = (-3.0, -3.0)
    """Least x and y of a point (m)."""

    high: Annotated[tuple[float, ...], point("x", "y")] = (3.0, 3.0)
    """Largest x and y of a point (m)."""

    probability: Annotated[float, number(0.01, 1.0)] = 0.5
    """That a drone can do a task."""

    generations: Annotated[int, whole(1, 10_000)] = 8
    """How often tasks are drawn: once at START, then after each completion."""

    deadline: Annotated[float, number(0.1, 60.0, "s")] = 1.0
    """Who does not ask for its tasks for so long after a new list counts as gone (s)."""

    patience: Annotated[float, number(1.0, 3600.0, "s")] = 30.0
    """After so long without a completion tasks are assigned anew (s)."""


class RequestEntry(Section):
    """Something that is to be brought from one point to another."""

    pickup: Annotated[tuple[float, ...], point("x", "y")]
    """Where it is (m)."""

    delivery: Annotated[tuple[float, ...], point("x", "y")]
    """Where it shall be (m)."""

    load: Annotated[float, number(0.0, 1000.0)] = 1.0
    """How much it takes of the capacity of a drone."""

    at: Annotated[float, number(0.0, 36000.0, "s")] = 0.0
    """When it turns up, after START (s)."""


class DeliveryLayer(Section):
    """The table that `DeliveryGuidance` works for."""

    requests: Annotated[list[RequestEntry], Field(min_length=1, max_length=64)]
    """What is to be brought where."""

    deadline: Annotated[float, number(0.1, 60.0, "s")] = 1.0
    """Who does not ask for its list for so long counts as gone (s)."""

    patience: Annotated[float, number(1.0, 3600.0, "s")] = 30.0
    """After so long without a pickup or a delivery routes are planned anew (s)."""


class Layers(Section):
    """The key `layers`."""

    rate: Annotated[int, BeforeValidator(_rate)] = 100
    """Rounds per second (Hz)."""

    odometry: Annotated[str, choice(*ODOMETRY)] = "estimate"
    """Where the layers know the poses from: `estimate` of the onboard filter, `truth`, or `mocap`, noisy poses whose
    velocity comes from a derivative filter."""

    communication: Communication = Communication()
    """Who talks to whom."""

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


class Disturbance(Section):
    """A random force."""

    sigma: Annotated[float, number(0.0, 10.0, "N")]
    """Standard deviation per axis (N)."""

    time_constant: Annotated[float, number(0.0, 1000.0, "s")] = 1.0
    """Correlation time (s)."""


class IntegratorSettings(Section):
    """What the backend `integrator` is like."""

    drag: Annotated[Any, BeforeValidator(lambda value: _drag(value))] = None
    """Rotor drag: `rotor`, three coefficients (N s/m) along body x, y, z, or none."""

    disturbance: Disturbance | None = None
    """Random force on each drone."""


def _drag(value: object) -> object:
    if value is None or value == "rotor":
        return value
    is_list = isinstance(value, Sequence) and not isinstance(value, str | bytes) and len(value) == 3
    if not is_list or not all(isinstance(v, int | float) and 0.0 <= v <= 10.0 for v in value):
        raise refusal("rotor, or three numbers in [0, 10] N s/m")
    return tuple(float(v) for v in value)


class SafetyBox(Section):
    """The box that real drones are kept in."""

    low: Annotated[tuple[float, ...], point("x", "y", "z")]
    """Lowest corner (m, world)."""

    high: Annotated[tuple[float, ...], point("x", "y", "z")]
    """Highest corner (m, world)."""

    breach: Annotated[str, choice("land", "stop", "report")] = "land"
    """What happens to a drone that leaves it."""


class HardwareSettings(Section):
    """How the backend `hardware` flies."""

    odometry_hz: Annotated[float, number(10.0, 100.0, "Hz")] = 100.0
    """Rate at which drones log their poses (Hz)."""

    safety_area: SafetyBox | None = None
    """Box that drones are kept in."""

    radio: Options = Field(default_factory=dict)
    """Further options of the radio handler, see `crazychoir_fw.radio.Options`."""

    mocap: MocapSettings | None = None
    """Motion capture; drones with `mocap` are told their poses by it."""


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
