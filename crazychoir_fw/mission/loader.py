"""From a file to a `Mission`, or to one sentence that says what is wrong with it."""

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.documents import read_all, read_file
from crazychoir_fw.mission.fleet import BUILTIN, START_DISTANCE, Layout, Settings, close_pair
from crazychoir_fw.mission.layer_checks import check_layers, with_uris
from crazychoir_fw.mission.plan import plan_flight
from crazychoir_fw.mission.radios import check_radios
from crazychoir_fw.mission.schema import LayeredMission, Mission
from crazychoir_fw.mission.values import did_you_mean
from crazychoir_fw.mission.wording import one_line, show

_HIGHEST_PORT = 65535


def load_mission(path: str | Path, uri_base: str | None = None, **overrides: Any) -> Mission:
    """Read a mission file and check everything that can be checked before the flight.

    Args:
        path: The mission file (YAML).
        uri_base: URI of the first real drone, from which the others are numbered; None leaves the file alone.
        overrides: `seed`, `provider`, `app`, `faults`, `backend`, `uris` or `changes`, stronger than the file; None
            leaves the file alone.

    Raises:
        MissionError: If the file cannot be read or flown; the text is one sentence that names the file, the key, its
            value and what is allowed.
    """
    path = Path(path)
    given = {"source": str(path), "folder": path.parent, "name": path.stem}
    data = read_file(path)
    if uri_base is None:
        return parse_mission(data, **given, **overrides)
    # how many drones there are is known before where they are
    simulated = parse_mission(data, **given, **{**overrides, "backend": "sim"})
    mission = parse_mission(data, **given, **overrides, uris=numbered_uris(uri_base, len(simulated.fleet)))
    if mission.backend not in ("hardware", "mixed"):
        raise MissionError(
            f"--uri-base is for real drones, but the backend is {mission.backend}: add --backend hardware"
        )
    return mission


def numbered_uris(base: str, count: int) -> list[str]:
    """Return the URIs of so many drones: each has the port, or the address, after that of the one before.

    ``udp://127.0.0.1:19850`` goes on with ``udp://127.0.0.1:19851``, ``radio://0/80/2M/E7E7E7E701`` with
    ``radio://0/80/2M/E7E7E7E702``.

    Raises:
        MissionError: If it ends in neither, or the numbers do not suffice.
    """
    port = re.fullmatch(r"(udp://[^\s:/]+):(\d{1,5})", base)
    if port:
        first = int(port[2])
        if not 1 <= first <= _HIGHEST_PORT - count + 1:
            raise MissionError(f"--uri-base {base}: {count} drones need ports up to {first + count - 1}, at most 65535")
        return [f"{port[1]}:{first + i}" for i in range(count)]
    address = re.fullmatch(r"(radio://[^\s]+/)([0-9A-Fa-f]{10})", base)
    if address:
        first = int(address[2], 16)
        if first + count - 1 > 0xFFFFFFFFFF:
            raise MissionError(f"--uri-base {base}: there are no {count} addresses from there on")
        return [f"{address[1]}{first + i:010X}" for i in range(count)]
    raise MissionError(
        f"--uri-base is {base[:60]!r}, but must be one such as udp://127.0.0.1:19850 or radio://0/80/2M/E7E7E7E701"
    )


def parse_mission(
    data: Any,
    source: str = "mission",
    folder: str | Path = ".",
    name: str | None = None,
    seed: int | None = None,
    provider: str | None = None,
    app: Sequence[str | Path] | None = None,
    faults: Sequence[Any] | None = None,
    backend: str | None = None,
    uris: Sequence[str] | None = None,
    changes: Sequence[str] | None = None,
) -> Mission:
    """Make a mission from what a mission file holds.

    Args:
        data: Mapping of the keys of `Mission`.
        source: Where it comes from, for messages.
        folder: Folder that relative paths start from.
        name: Name of a mission that does not name itself.
        seed: Seed instead of that of *data*.
        provider: Provider instead of those of *data*, for all drones.
        app: C files that all drones carry instead of those of *data*, seen from where the program runs.
        faults: List of faults instead of that of *data*: as in a file, or made in Python, with `at` in seconds
            since the first phase.
        backend: Backend instead of that of *data*.
        uris: URIs of the drones, in their order, instead of those of *data*.
        changes: Single values such as "layers.rate=50", as `--set` takes them; the other arguments are stronger.

    Raises:
        MissionError: As `load_mission`.
    """
    told = read_all(data, source, Path(folder), changes or ())
    data = told.data
    if name is not None:
        data.setdefault("name", name)
    if seed is not None:
        data["seed"] = seed
    if faults is not None:
        data["faults"] = list(faults)
    if backend is not None:
        data["backend"] = backend

    overrides = {"provider": provider, "app": None if app is None else list(map(str, app))}
    try:
        context = {"folders": told.folders, "has_own_software": _has_own_software(data, provider, app)}
        kind = LayeredMission if "layers" in data else Mission
        mission = kind.model_validate(data, context=context)
        mission = _with(mission, {key: value for key, value in overrides.items() if value is not None})
        _check_fleet(mission)
        _check_faults(mission)
        check_radios(mission.radios, [drone.id for drone in mission.fleet])
        if isinstance(mission, LayeredMission):
            mission = with_uris(mission, uris)
            check_layers(mission)
        else:
            plan_flight(mission)
    except ValidationError as error:
        raise MissionError(told.blame(sentence_of(error))) from None
    except MissionError as error:
        raise MissionError(told.blame(str(error))) from None
    return mission


def _has_own_software(data: Mapping[str, Any], provider: str | None, app: Sequence[str | Path] | None) -> bool:
    """Tell whether a drone may fly with software that brings parameters of its own."""
    drones = data.get("drones")
    sections = [data.get("defaults"), *(drones if isinstance(drones, list) else [drones])]
    mappings = [section for section in sections if isinstance(section, Mapping)]
    providers = [provider] if provider is not None else [section.get("provider", BUILTIN) for section in mappings]
    apps = [app] if app is not None else [section.get("app") for section in mappings]
    return any(apps) or any(name != BUILTIN for name in providers)


def _check_fleet(mission: Mission) -> None:
    """Refuse two drones of one name, and two in one place."""
    seen: dict[str, int] = {}
    for i, drone in enumerate(mission.fleet):
        if drone.id in seen:
            raise MissionError(
                f"drones[{i}].id is '{drone.id}', but must be unique and drones[{seen[drone.id]}] has it already"
            )
        seen[drone.id] = i
    if pair := close_pair(mission.fleet):
        first, second = mission.fleet[pair[0]], mission.fleet[pair[1]]
        raise MissionError(
            f"drones[{pair[1]}].position is {list(second.position)}, but {second.id} must start at least "
            f"{START_DISTANCE:g} m from {first.id}, and starts {pair[2]:.3g} m from it"
        )


def _check_faults(mission: Mission) -> None:
    """Refuse unknown drones, and faults of what a drone does not have."""
    fleet = {drone.id: drone for drone in mission.fleet}
    for i, entry in enumerate(mission.faults):
        path = f"faults[{i}].{entry.name}"
        for name in entry.fault.drones or ():
            _check_name(f"{path}.drones", name, fleet)
        if entry.name == "positioning":
            is_late = entry.positioning.get("delay", 0) > 0
            for name in entry.fault.drones or fleet:
                system = fleet[name].positioning
                if system == "none" or (is_late and not system.startswith("mocap")):
                    what = "a delay" if is_late else "a loss"
                    raise MissionError(f"{path} befalls {name} with positioning '{system}', which knows no such {what}")
    for name in mission.may_fail:
        _check_name("may_fail", name, fleet)


def _check_name(path: str, name: str, fleet: Collection[str]) -> None:
    if name not in fleet:
        hint = did_you_mean(name, fleet)
        raise MissionError(f"{path} names '{name[:40]}', but must name drones of the mission{hint}")


def _with(mission: Mission, settings: Mapping[str, Any]) -> Mission:
    """Return the mission with settings that all drones share, whatever they said themselves."""
    if not settings:
        return mission
    try:
        chosen = Settings(**settings).model_dump(exclude_none=True)
    except ValidationError as error:
        raise MissionError(sentence_of(error)) from None
    if isinstance(mission.drones, Layout):
        drones = mission.drones.model_copy(update=chosen)
    else:
        drones = [entry.model_copy(update=chosen) for entry in mission.drones]
    copy = mission.model_copy(update={"drones": drones})
    # the copy brings along what the original had decided for its fleet
    copy.__dict__.pop("fleet", None)
    return copy


# what pydantic itself refuses, as it continues "must be"
_MUST = {
    "list_type": "a list",
    "tuple_type": "a list",
    "model_type": "a mapping",
    "dict_type": "a mapping",
    "model_attributes_type": "a mapping",
    "bool_type": "true or false",
    "string_type": "text",
    "string_unicode": "text",
    "recursion_loop": "something that does not contain itself",
    "invalid_key": "a mapping with words as keys",
}


def sentence_of(error: ValidationError) -> str:
    """Return what is wrong, in one sentence: the unknown keys first, because a typo also makes a key missing."""
    errors = error.errors(include_url=False)
    worst = next((e for e in errors if e["type"] == "unknown_key"), errors[0])
    context = worst.get("ctx", {})
    path = _key_path(worst["loc"]) + context.get("path", "")
    kind = worst["type"]

    if kind == "unknown_key":
        known = ", ".join(context["known"])
        return f"{path or 'a mission'} has no key {show(context['key'])}{context['hint']}, but only {known}"
    if kind == "missing":
        return f"{path} is missing"
    if kind == "objection":
        return f"{path}: {context['sentence']}"
    if isinstance(context.get("error"), MissionError):
        return f"{path}: {context['error']}"
    if kind == "too_short":
        must = f"a list of at least {context['min_length']}"
    elif kind == "too_long":
        must = f"a list of at most {context['max_length']}"
    else:
        must = context.get("must") or _MUST.get(kind) or one_line(worst["msg"])
    value = context.get("value", worst["input"])
    return f"{path} is {show(value)}, but must be {must}{_hint(value, context.get('known', '').split())}"


def _hint(value: Any, known: Sequence[str]) -> str:
    """Return " (did you mean 'pid'?)" where a value, or the first of a list that is unknown, is near a known word."""
    unknown = [one for one in (value if isinstance(value, list | tuple) else [value]) if one not in known]
    return did_you_mean(unknown[0], known) if unknown and isinstance(unknown[0], str) else ""


def _key_path(loc: tuple[int | str, ...]) -> str:
    """Return a location such as "flight[1].takeoff.height"."""
    path = ""
    for step in loc:
        if isinstance(step, int):
            path += f"[{step}]"
        elif not step.startswith("#"):
            path += f".{step}" if path else step
    return path
