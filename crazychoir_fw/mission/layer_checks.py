"""What of a mission with layers can only be judged when all of it is known: names, numbers, what needs what."""

from __future__ import annotations

from collections.abc import Sequence

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.mission.control_checks import check_control, check_safety
from crazychoir_fw.mission.doubts import check_safety_area
from crazychoir_fw.mission.fleet import Layout
from crazychoir_fw.mission.guidance_checks import check_guidance, check_names
from crazychoir_fw.mission.mixed import is_real
from crazychoir_fw.mission.schema import LayeredMission


def check_layers(mission: LayeredMission) -> None:
    """Refuse names that no drone has, and layers that lack what they need.

    Raises:
        MissionError: With the key and what is allowed.
    """
    try:
        check_guidance(mission)
        check_control(mission)
        check_safety(mission)
    except MissionError:
        raise
    except CrazychoirError as error:
        raise MissionError(str(error)) from None
    _check_buttons(mission, [drone.id for drone in mission.fleet])
    _check_backend(mission)
    check_safety_area(mission)


def with_uris(mission: LayeredMission, uris: Sequence[str] | None) -> LayeredMission:
    """Return the mission with these URIs for its drones, in their order; simulated drones of `mixed` stay simulated.

    Raises:
        MissionError: If their number is another one, or no drone of a mixed mission has a URI.
    """
    if uris is None:
        return mission
    entries = mission.drones.entries() if isinstance(mission.drones, Layout) else mission.drones
    if len(uris) != len(entries):
        raise MissionError(f"there are {len(uris)} uris, but must be {len(entries)}, one for each drone")
    of_file = [drone.uri is not None or mission.backend != "mixed" for drone in mission.fleet]
    if not any(of_file):
        raise MissionError("no drone has a uri in the mission, so that --uri-base has none to number; backend is mixed")
    left = iter(uris)
    drones = [
        entry.model_copy(update={"uri": next(left)}) if has_uri else entry
        for entry, has_uri in zip(entries, of_file, strict=True)
    ]
    copy = mission.model_copy(update={"drones": drones})
    copy.__dict__.pop("fleet", None)  # the copy brings along what the original had decided
    return copy


def _check_buttons(mission: LayeredMission, names: list[str]) -> None:
    for i, phase in enumerate(mission.flight):
        ordered: set[str] = set()
        for order in phase.orders:
            path = f"flight[{i}].{order.name}" if phase.together is None else f"flight[{i}].together.{order.name}"
            wanted = getattr(order.maneuver, "drones", None)
            if wanted is not None:
                check_names(f"{path}.drones", wanted, names)
            _check_button(mission, order.name, path, wanted or names)
            twice = [] if order.name == "hover" else [name for name in wanted or names if name in ordered]
            if twice:
                raise MissionError(
                    f"{path} gives {twice[0]} two orders at once; name the drones of each phase with drones: [ids]"
                )
            ordered |= set() if order.name == "hover" else set(wanted or names)


def _check_button(mission: LayeredMission, button: str, path: str, wanted: list[str]) -> None:
    if button == "go_to" and len(wanted) > 1:
        raise MissionError(f"{path} sends {len(wanted)} drones to one point; name one with drones: [id]")
    if button == "trajectory" and any(mission.layers.planning_of(name) is None for name in wanted):
        raise MissionError(f"{path} needs layers.planning, which makes references out of its points")


def _check_backend(mission: LayeredMission) -> None:
    if mission.backend == "sim":
        return
    for key in ("radios",) if mission.backend == "mixed" else ("faults", "radios"):
        if getattr(mission, key):
            raise MissionError(f"{key} are for the backend sim, but backend is {mission.backend}")
    if mission.backend not in ("hardware", "mixed"):
        return
    if mission.backend == "hardware" and len(mission.layers.commands) > 1:
        raise MissionError(
            f"layers.control: drones are commanded by {', '.join(mission.layers.commands)}, but the radio sends one "
            "kind of command to all"
        )
    for i, drone in enumerate(mission.fleet):
        if drone.mocap is not None and mission.hardware.mocap is None:
            raise MissionError(
                f"hardware.mocap is missing: drones[{i}].mocap needs motion capture, such as hardware: {{mocap: "
                f"{{system: udp}}}}"
            )
    if mission.backend == "mixed":
        real = sum(is_real(drone) for drone in mission.fleet)
        if real == 0:
            raise MissionError("backend mixed needs a drone that is real: one with uri or mocap")
        if real == len(mission.fleet):
            raise MissionError("backend mixed needs a simulated drone, but all have uri or mocap: take hardware")
    _check_uris(mission)


def _check_uris(mission: LayeredMission) -> None:
    for i, drone in enumerate(mission.fleet):
        if drone.uri is None and mission.backend == "hardware":
            raise MissionError(
                f"drones[{i}].uri is missing: the backend hardware must know where {drone.id} is, such as "
                f"radio://0/80/2M/E7E7E7E7{i + 1:02X}; or number ports with --uri-base udp://127.0.0.1:19850"
            )
    uris = [drone.uri for drone in mission.fleet]
    for i, uri in enumerate(uris):
        if uri is not None and uri in uris[:i]:
            raise MissionError(f"drones[{i}].uri is {uri}, but drones[{uris.index(uri)}] has it already")
