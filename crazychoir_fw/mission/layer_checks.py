"""What of a mission with layers can only be judged when all of it is known: names, numbers, what needs what."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.common.user_code import describe
from crazychoir_fw.guidance import CFGuidance
from crazychoir_fw.guidance.law import arguments_of, options_of
from crazychoir_fw.mission.communication import Graph
from crazychoir_fw.mission.fleet import Layout
from crazychoir_fw.mission.layers import GuidanceLayer
from crazychoir_fw.mission.layers.control import SENDERS
from crazychoir_fw.mission.mixed import is_real
from crazychoir_fw.mission.registry import our_laws
from crazychoir_fw.mission.roles import context_of, metrics_of
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.mission.values import did_you_mean


def check_layers(mission: LayeredMission) -> None:
    """Refuse names that nobody has, and layers that lack what they need.

    Raises:
        MissionError: With the key and what is allowed.
    """
    names = [drone.id for drone in mission.fleet]
    _check_cover(mission, names)
    _check_edges(mission, names)
    for number in range(len(mission.layers.guidances)):
        _check_guidance(mission, number, names)
    _check_control(mission)
    _check_safety(mission)
    _check_tables(mission)
    _check_buttons(mission, names)
    _check_criteria(mission)
    _check_backend(mission)


def with_uris(mission: LayeredMission, uris: Sequence[str] | None) -> LayeredMission:
    """Return the mission with these URIs for its drones, in their order.

    Raises:
        MissionError: If their number is another one.
    """
    if uris is None:
        return mission
    entries = mission.drones.entries() if isinstance(mission.drones, Layout) else mission.drones
    if len(uris) != len(entries):
        raise MissionError(f"there are {len(uris)} uris, but must be {len(entries)}, one for each drone")
    drones = [entry.model_copy(update={"uri": uri}) for entry, uri in zip(entries, uris, strict=True)]
    copy = mission.model_copy(update={"drones": drones})
    copy.__dict__.pop("fleet", None)  # the copy brings along what the original had decided
    return copy


def _known(path: str, wanted: Iterable[str], names: Collection[str]) -> None:
    for name in wanted:
        if name not in names:
            hint = did_you_mean(name, names)
            raise MissionError(f"{path} names '{name[:40]}', but must name drones of the mission{hint}")


def _check_guidance(mission: LayeredMission, number: int, names: list[str]) -> None:
    """Refuse an entry of guidance that lacks what its law needs."""
    guidance, path = mission.layers.guidances[number], _path(mission, number)
    try:
        law = guidance.law(f"{path}.class")
    except CrazychoirError as error:
        raise MissionError(str(error)) from None
    members = names if guidance.drones is None else guidance.drones
    _known(f"{path}.leaders", guidance.leaders, members)
    _known(f"{path}.options_by_drone", guidance.options_by_drone, members)
    _check_options(guidance, law, path)
    _check_goals(guidance, law, path, members)
    _check_graph(mission, guidance, law, members)
    _check_places(guidance, law, path, members)
    _check_leaders(mission, guidance, law, path)
    try:
        law.check(context_of(mission, number))
    except CrazychoirError as error:
        raise MissionError(f"{path}: {error}") from None


def _check_options(guidance: GuidanceLayer, law: type[CFGuidance], path: str) -> None:
    known, taken = options_of(law), arguments_of(law)
    given = {"options": guidance.options, **{f"options_by_drone.{k}": v for k, v in guidance.options_by_drone.items()}}
    for key, options in given.items():
        for name, value in options.items():
            if name not in taken:
                hint = did_you_mean(name, taken)
                raise MissionError(f"{path}.{key} has no key '{name}'{hint}, but only {', '.join(taken)}")
            try:
                if name in known:
                    known[name].checked(f"{path}.{key}", name, value)
            except CrazychoirError as error:
                raise MissionError(str(error)) from None


def _path(mission: LayeredMission, number: int) -> str:
    """Return where in the file an entry of guidance stands."""
    return f"layers.guidance[{number}]" if isinstance(mission.layers.decides, list) else "layers.guidance"


def _check_cover(mission: LayeredMission, names: list[str]) -> None:
    """Refuse drones that nobody decides for, or two."""
    layers = mission.layers
    if not isinstance(layers.decides, list):
        for key in ("drones", "communication"):
            if getattr(layers.guidance, key) is not None:
                raise MissionError(f"layers.guidance.{key} is for a list of several kinds of guidance")
        return
    decided: dict[str, int] = {}
    for number, guidance in enumerate(layers.guidances):
        path = f"layers.guidance[{number}].drones"
        if guidance.drones is None:
            raise MissionError(f"{path} is missing: each of several kinds of guidance names the drones it decides for")
        _known(path, guidance.drones, names)
        for name in guidance.drones:
            if name in decided:
                raise MissionError(
                    f"{path} names '{name}', but layers.guidance[{decided[name]}] decides for it already"
                )
            decided[name] = number
    for name in names:
        if name not in decided:
            raise MissionError(f"layers.guidance decides nothing for '{name}', but must name each drone in one entry")


def _laws_that(fit: Callable[[type[CFGuidance]], bool]) -> str:
    """Return the names of our laws that fit, for messages."""
    return " or ".join(name for name, law in our_laws("guidance").items() if fit(law))


def _check_goals(guidance: GuidanceLayer, law: type[CFGuidance], path: str, names: Sequence[str]) -> None:
    if guidance.goals is None:
        if law.needs.goals:
            raise MissionError(f"{path}.goals is missing: {guidance.kind} needs lists of [duration, x, y, z] by drone")
        return
    if "goals" not in arguments_of(law):
        takers = _laws_that(lambda one: "goals" in arguments_of(one))
        raise MissionError(f"{path}.goals are for the class {takers}, but class is {guidance.kind}")
    _known(f"{path}.goals", guidance.goals, names)
    for name, rows in guidance.goals.items():
        for i, (duration, *_rest, z) in enumerate(rows):
            if not (duration > 0.0 and z >= 0.0):
                raise MissionError(f"{path}.goals.{name}[{i}] must be [duration, x, y, z] with duration > 0 and z >= 0")


def _check_graph(
    mission: LayeredMission, guidance: GuidanceLayer, law: type[CFGuidance], members: Sequence[str]
) -> None:
    given = (mission.layers.communication, guidance.communication or mission.layers.communication)
    if law.needs.graph and not any(isinstance(one.graph, Graph) or one.graph for one in given):
        raise MissionError(
            f"layers.communication.graph is missing: {guidance.kind} needs who talks to whom, such as complete or "
            f"[[{members[0]}, {members[min(1, len(members) - 1)]}]]"
        )


def _check_places(guidance: GuidanceLayer, law: type[CFGuidance], path: str, names: Sequence[str]) -> None:
    needs, formation = law.needs, guidance.formation
    if formation is None:
        if needs.formation and (not needs.formation_or or needs.formation_or not in guidance.options):
            raise MissionError(f"{path}.formation is missing: {guidance.kind} needs a place for each drone")
        return
    if needs.formation is False:
        raise MissionError(f"{path}.formation: {guidance.kind} has none, its followers gather among the leaders")
    if isinstance(formation, list) and len(formation) != len(names):
        raise MissionError(
            f"{path}.formation has {len(formation)} places, but must have {len(names)}, one for each drone"
        )


def _check_leaders(mission: LayeredMission, guidance: GuidanceLayer, law: type[CFGuidance], path: str) -> None:
    if law.needs.leaders and not guidance.leaders:
        raise MissionError(f"{path}.leaders is missing: {guidance.kind} needs a drone that leads")
    for name in guidance.leaders if law.needs.planning_of_leaders else ():
        if mission.layers.planning_of(name) is None:
            raise MissionError(f"layers.planning is missing: leaders such as {name} fly trajectories")


def _check_edges(mission: LayeredMission, names: list[str]) -> None:
    layers = mission.layers
    given = [("layers.communication", layers.communication, names)]
    for number, guidance in enumerate(layers.guidances):
        if guidance.communication is not None:
            given.append((f"layers.guidance[{number}].communication", guidance.communication, guidance.drones or names))
    for path, communication, members in given:
        if isinstance(communication.graph, tuple):
            for i, pair in enumerate(communication.graph):
                _known(f"{path}.graph[{i}]", pair, members)


def _check_tables(mission: LayeredMission) -> None:
    """Refuse laws without the table that they work for, and tables that no law works for."""
    layers = mission.layers
    needed = {guidance.law().needs.table: guidance.kind for guidance in layers.guidances}
    for key in ("tasks", "delivery"):
        table = getattr(layers, key)
        if key in needed and len(needed) > 1:
            raise MissionError(f"layers.guidance: {needed[key]} works for all drones, or for none")
        if key in needed and table is None:
            raise MissionError(f"layers.{key} is missing: {needed[key]} needs a table to work for")
        if key not in needed and table is not None:
            workers = _laws_that(lambda law, key=key: law.needs.table == key)  # type: ignore[misc]
            raise MissionError(f"layers.{key} is for the class {workers}, but class is {layers.guidance.kind}")
    if layers.tasks is not None and not all(
        low < high for low, high in zip(layers.tasks.low, layers.tasks.high, strict=True)
    ):
        raise MissionError(
            f"layers.tasks.low is {list(layers.tasks.low)}, but must be below high, {list(layers.tasks.high)}"
        )


def _check_control(mission: LayeredMission) -> None:
    for drone in mission.fleet:
        control, planning = mission.layers.control_of(drone.id), mission.layers.planning_of(drone.id)
        path = mission.layers.path_of(drone.id, "control")
        if control is None and planning is not None:
            raise MissionError(f"{path} is missing: what is planned here must be controlled here")
        if control is None:
            continue
        try:
            commands = control.law(f"{path}.class").commands
        except CrazychoirError as error:
            raise MissionError(str(error)) from None
        if control.command not in commands:
            senders = " or ".join(sender for sender, kind in SENDERS.items() if kind in commands)
            raise MissionError(f"{path}.sender is '{control.sender}', but must be {senders} with a {control.kind}")
        if drone.motor_ctrl is not None:
            raise MissionError(f"{drone.id} has a motor_ctrl, but layers fly it already")


def _check_safety(mission: LayeredMission) -> None:
    layers = mission.layers
    safety, control = layers.safety, layers.control
    for path, rate in (
        ("control.rate", None if control is None else control.rate),
        ("safety.rate", None if safety is None else safety.rate),
        ("safety.sensing_rate", None if safety is None else safety.sensing_rate),
    ):
        if rate is not None and layers.rate % rate:
            raise MissionError(f"layers.{path} is {rate}, but must be a divisor of layers.rate, {layers.rate} Hz")
    if safety is None:
        return
    if control is None:
        raise MissionError("layers.safety needs layers.control: what the planners on board do is not filtered")
    try:
        law, taken = safety.law(), arguments_of(safety.law())
    except CrazychoirError as error:
        raise MissionError(str(error)) from None
    if control.law().filtered != law.filters:
        needed = [name for name, one in our_laws("control").items() if one.filtered == law.filters]  # type: ignore[attr-defined]
        raise MissionError(
            f"layers.safety.filter is {safety.filter}, which filters the commands of a {' or '.join(needed)}, but "
            f"layers.control.class is {control.kind}"
        )
    for key in safety.of_filter:
        if key not in taken:
            owners = [name for name, one in our_laws("safety").items() if key in arguments_of(one)]
            raise MissionError(
                f"layers.safety.{key} is for the filter {' or '.join(owners)}, but filter is {safety.filter}"
            )
    if safety.rate is not None and law.filters != "velocity":
        raise MissionError(f"layers.safety.rate is for filters of velocities, but filter is {safety.filter}")
    if safety.sensing_distance <= safety.distance + safety.margin:
        raise MissionError(
            f"layers.safety.sensing_distance is {safety.sensing_distance:g}, but must be above distance and margin, "
            f"{safety.distance + safety.margin:g} m"
        )
    if safety.sees == "truth" and mission.backend == "hardware":
        raise MissionError("layers.safety.sees is 'truth', but nobody knows the truth of real drones; use odometry")


def _check_buttons(mission: LayeredMission, names: list[str]) -> None:
    for i, phase in enumerate(mission.flight):
        path = f"flight[{i}].{phase.name}"
        wanted = getattr(phase.button, "drones", None)
        if wanted is not None:
            _known(f"{path}.drones", wanted, names)
        if phase.name == "go_to" and len(wanted or names) > 1:
            raise MissionError(f"{path} sends {len(wanted or names)} drones to one point; name one with drones: [id]")
        if phase.name == "trajectory" and any(mission.layers.planning_of(name) is None for name in wanted or names):
            raise MissionError(f"{path} needs layers.planning, which makes references out of its points")


def _check_criteria(mission: LayeredMission) -> None:
    """Refuse criteria that no law of the mission declares, and limits out of their ranges."""
    try:
        declared = {key: one for metrics in metrics_of(mission) for key, one in metrics.criteria.items()}
    except Exception as error:  # a user's code may raise anything
        raise MissionError(f"layers.guidance: its metrics cannot be made: {describe(error)}") from error
    for key, limit in mission.criteria.of_laws.items():
        if key not in declared:
            raise _no_criterion(mission, key, declared)
        try:
            declared[key].checked(key, limit)
        except CrazychoirError as error:
            raise MissionError(str(error)) from None
    if mission.layers.rate % mission.log_rate:
        raise MissionError(f"log_rate is {mission.log_rate}, but must be a divisor of {mission.layers.rate} Hz")


def _no_criterion(mission: LayeredMission, key: str, declared: Collection[str]) -> MissionError:
    """Return the error about a criterion that the laws of a mission do not answer."""
    owners = {name: law for name, law in our_laws("guidance").items() if key in law.metrics.criteria}
    if not owners:
        known = sorted({*type(mission.criteria).model_fields, *declared})
        others = {one for law in our_laws("guidance").values() for one in law.metrics.criteria}
        hint = did_you_mean(key, [*known, *others])
        return MissionError(f"criteria has no key '{key[:40]}'{hint}, but only {', '.join(known)}")
    tables = {law.needs.table for law in owners.values()} - {""}
    missing = " or ".join(f"layers.{table}" for table in sorted(tables))
    if not missing and all(law.metrics is CFGuidance.metrics for law in owners.values() if law.needs.formation):
        missing = "layers.guidance.formation of all drones"
    names = " or ".join({law: name for name, law in reversed(owners.items())}.values())
    return MissionError(f"criteria.{key} needs {missing or f'layers.guidance of class {names}, for all drones'}")


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
