"""The mission file: what may stand in it, and what each key means."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator

from crazychoir_fw.common.constraints import choice, number, whole, word
from crazychoir_fw.common.errors import MissionError, RangeError
from crazychoir_fw.mission.backend_settings import HardwareSettings, IntegratorSettings
from crazychoir_fw.mission.criteria import Criteria
from crazychoir_fw.mission.faults import Faults
from crazychoir_fw.mission.fleet import Drone, Drones, Settings, decide
from crazychoir_fw.mission.layers import Layers
from crazychoir_fw.mission.mixed import MixedSettings
from crazychoir_fw.mission.phases import LayeredPhase, PhaseEntry
from crazychoir_fw.mission.radios import Radios
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.values import beside, did_you_mean, is_file, refusal, wind_parameters

SCENES = ("arena", "flight_lab", "gates", "pillars", "room")


BACKENDS = ("sim", "integrator", "hardware", "mixed")


class Tolerance(Section):
    """How close is close enough."""

    endpoint: Annotated[float, number(0.001, 10.0, "m")] = 0.10
    """Largest distance between where a drone ends and its last goal (m)."""

    waypoint: Annotated[float, number(0.001, 10.0, "m")] = 0.20
    """Largest distance at which a target on the way counts as reached (m)."""

    collision_speed: Annotated[float, number(0.0, 100.0, "m/s")] = 0.2
    """Largest speed at which a drone may touch another drone or an obstacle (m/s)."""


class Mission(Section):
    """A whole flight: the drones, their starts and the phases in order."""

    name: Annotated[str, word(r"\w[\w.-]{0,63}", "a name of at most 64 letters, digits, _, - and .")]
    """Name of the mission and of its output folder."""

    extends: str | None = None
    """Mission file, seen from this one, that this one changes: mappings are merged, everything else is replaced."""

    description: Annotated[
        str, word(r"[^\x00-\x08\x0b-\x1f\x7f]{0,2000}", "text of at most 2000 printable characters")
    ] = ""
    """One line for people."""

    scene: str = "arena"
    """`arena`, `flight_lab`, `gates`, `pillars`, `room`, an MJCF or YAML file seen from the mission's folder, or a
    mapping with the keys of such a YAML file: `light`, `boxes`, `walls`, `pillars`, `gates`."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 0
    """Seed of all noise: the same seed gives the same flight, to the last bit."""

    wind: Annotated[Mapping[str, Any], wind_parameters()] = Field(default_factory=dict)
    """Wind over all drones: `velocity` [x, y, z] (m/s), `turbulence` (none, indoor or dryden) and its numbers."""

    backend: Annotated[str, choice("sim", must="sim; the others fly missions with layers")] = "sim"
    """Where the drones live: a mission without `layers` is flown in simulation."""

    defaults: Settings = Settings()
    """Settings of all drones that do not say otherwise."""

    drones: Drones
    """A list of drones, or a layout of many."""

    flight: Annotated[list[PhaseEntry], Field(min_length=1, max_length=10000)]
    """The phases in order."""

    layers: Layers | None = None
    """What decides, plans and controls; without it, the planners on board fly the phases."""

    faults: Faults = Field(default_factory=list)
    """What goes wrong, with whom and when."""

    radios: Radios = Field(default_factory=list)
    """Which Crazyradio serves which drones, and how good it is; without it, every link is perfect."""

    may_fail: list[str] = Field(default_factory=list)
    """Ids of the drones that are not expected to come home: the flight goes on without them, and is judged without
    them."""

    tolerance: Tolerance = Tolerance()
    """When the flight counts as a success."""

    @field_validator("scene", mode="before")
    @classmethod
    def _take_scene(cls, scene: Any) -> Any:
        """Have a scene that stands in the mission as the text that worlds take."""
        if not isinstance(scene, Mapping) and not (isinstance(scene, str) and scene.startswith("{")):
            return scene
        from crazychoir_fw.simulation.scene_file import inline_scene

        try:
            return inline_scene(scene)
        except RangeError as error:
            raise MissionError(str(error)) from None

    @field_validator("scene")
    @classmethod
    def _find_scene(cls, scene: str, info: ValidationInfo) -> str:
        if scene in SCENES or scene.startswith("{"):
            return scene
        path = beside(scene, info)
        if path.suffix not in (".xml", ".yaml", ".yml") or not is_file(path):
            raise refusal(f"one of {', '.join(SCENES)}{did_you_mean(scene, SCENES)} or an existing .xml or .yaml file")
        if path.suffix != ".xml":
            from crazychoir_fw.simulation.scene_file import read_scene

            try:
                read_scene(path)
            except RangeError as error:
                raise MissionError(str(error)) from None
        return str(path)

    @cached_property
    def fleet(self) -> tuple[Drone, ...]:
        """Every drone with its settings decided, in the order of the file."""
        return decide(self.drones, self.defaults, self.wind)


class LayeredMission(Mission):
    """A flight of guidance, planning and control, on any backend."""

    backend: Annotated[str, choice(*BACKENDS)] = "sim"
    """Where the drones live: `sim` (MuJoCo and the onboard software), `integrator`, `hardware` (over the radio), or
    `mixed`: drones with `uri` or `mocap` are real, the others simulated."""

    layers: Layers
    """What decides, plans and controls."""

    flight: Annotated[list[LayeredPhase], Field(min_length=1, max_length=10000)]
    """The phases in order."""

    criteria: Criteria = Criteria()
    """What makes the flight a success."""

    log_rate: Annotated[int, whole(1, 100)] = 100
    """Rate of the log (Hz), at most the rate of the layers; a divisor of it."""

    integrator: IntegratorSettings = IntegratorSettings()
    """What the backend `integrator` is like."""

    hardware: HardwareSettings = HardwareSettings()
    """How the backends `hardware` and `mixed` fly real drones."""

    mixed: MixedSettings = MixedSettings()
    """How the backend `mixed` shows real drones in the simulated world."""
