"""What of a mission with layers can only be judged when all of it is known: names, numbers, what needs what."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.mission.communication import Graph
from crazychoir_fw.mission.fleet import Layout
from crazychoir_fw.mission.layers import GUIDANCE, GuidanceLayer
from crazychoir_fw.mission.mixed import is_real
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.mission.values import did_you_mean

FORMATION_CONTROL = ("FormationControl", "FormationControlGuidance")
CONTAINMENT = ("Containment", "ContainmentGuidance", "TimeVaryingContainment", "TimeVaryingContainmentGuidance")
TAKE_GOALS = ("GoToGuidance", "TargetListGuidance", "SimpleDIControl")

NEED_GRAPH = (
    "TaskGuidance",
    "DeliveryGuidance",
    "BearingFormation",
    *FORMATION_CONTROL,
    *CONTAINMENT,
    "MPCGuidance",
    "AggregativeGuidance",
    "AggregativeGuidanceCrazyflie",
    "AggregativeGuidanceCrazyflieMovingIntruder",
)
"""Guidance that can do nothing without neighbors."""


def check_layers(mission: LayeredMission) -> None:
    """Refuse names that nobody has, and layers that lack what they need.

    Raises:
        MissionError: With the key and what is allowed.
    """
    names = [drone.id for drone in mission.fleet]
    _check_guidance(mission, names)
    _check_graph(mission, names)
    _check_formation(mission)
    _check_distances_and_leaders(mission)
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


def _check_guidance(mission: LayeredMission, names: list[str]) -> None:
    _check_cover(mission, names)
    for number, guidance in enumerate(mission.layers.guidances):
        path = _path(mission, number)
        members = names if guidance.drones is None else guidance.drones
        _known(f"{path}.leaders", guidance.leaders, members)
        _known(f"{path}.options_by_drone", guidance.options_by_drone, members)
        _check_goals(guidance, path, members)
        _check_places(guidance, path, members)


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


def _check_goals(guidance: GuidanceLayer, path: str, names: Sequence[str]) -> None:
    if guidance.goals is not None:
        if guidance.kind in GUIDANCE and guidance.kind not in TAKE_GOALS:
            raise MissionError(
                f"{path}.goals are for the class {' or '.join(TAKE_GOALS)}, but class is {guidance.kind}"
            )
        _known(f"{path}.goals", guidance.goals, names)
        for name, rows in guidance.goals.items():
            for i, (duration, *_rest, z) in enumerate(rows):
                if not (duration > 0.0 and z >= 0.0):
                    raise MissionError(
                        f"{path}.goals.{name}[{i}] must be [duration, x, y, z] with duration > 0 and z >= 0"
                    )
    elif guidance.kind == "GoToGuidance":
        raise MissionError(f"{path}.goals is missing: GoToGuidance needs lists of [duration, x, y, z] by drone")


def _check_places(guidance: GuidanceLayer, path: str, names: Sequence[str]) -> None:
    if guidance.formation is None:
        if guidance.kind == "BearingFormation":
            raise MissionError(f"{path}.formation is missing: BearingFormation needs a place for each drone")
        return
    if isinstance(guidance.formation, list) and len(guidance.formation) != len(names):
        raise MissionError(
            f"{path}.formation has {len(guidance.formation)} places, but must have {len(names)}, one for each drone"
        )
    if guidance.kind == "BearingFormation" and not guidance.leaders:
        raise MissionError(f"{path}.leaders is missing: without a leader the formation is nowhere")


def _check_graph(mission: LayeredMission, names: list[str]) -> None:
    layers = mission.layers
    given = [("layers.communication", layers.communication, names)]
    for number, guidance in enumerate(layers.guidances):
        if guidance.communication is not None:
            given.append((f"layers.guidance[{number}].communication", guidance.communication, guidance.drones or names))
    for path, communication, members in given:
        if isinstance(communication.graph, tuple):
            for i, pair in enumerate(communication.graph):
                _known(f"{path}.graph[{i}]", pair, members)
    for guidance in layers.guidances:
        wanted = (layers.communication, guidance.communication or layers.communication)
        if guidance.kind in NEED_GRAPH and not any(isinstance(one.graph, Graph) or one.graph for one in wanted):
            members = guidance.drones or names
            raise MissionError(
                f"layers.communication.graph is missing: {guidance.kind} needs who talks to whom, such as complete or "
                f"[[{members[0]}, {members[min(1, len(members) - 1)]}]]"
            )


def _check_formation(mission: LayeredMission) -> None:
    """Refuse a formation that leaders and bearings do not determine, or that has two places in one."""
    from crazychoir_fw.guidance import Graph as WhoHearsWhom
    from crazychoir_fw.guidance.bearing import check_formation
    from crazychoir_fw.mission.communicators import graph_of
    from crazychoir_fw.mission.roles import formation_of, leads, names_of

    names = names_of(mission)
    for number, guidance in enumerate(mission.layers.guidances):
        if guidance.kind != "BearingFormation":
            continue
        path = _path(mission, number)
        members = [names.index(name) for name in guidance.drones or names]
        graph, places = graph_of(mission), {i: k for k, i in enumerate(members)}
        for i, j in graph.edges:
            if (i in places) != (j in places):
                raise MissionError(f"{path}: {names[i]} talks to {names[j]}, but only one of them is in this formation")
        edges = [(places[i], places[j]) for i, j in graph.edges if i in places]
        own = WhoHearsWhom.directed(len(members), edges, [names[i] for i in members])
        leaders = [places[i] for i in members if leads(mission, i)]
        try:
            check_formation(formation_of(mission, members[0])[members], own, leaders)  # type: ignore[index]
        except CrazychoirError as error:
            raise MissionError(f"{path}: {error}") from None


TABLES = {"TaskGuidance": "tasks", "DeliveryGuidance": "delivery"}
"""Guidance that works for a table, and the key of that."""


def _check_tables(mission: LayeredMission) -> None:
    """Refuse guidance without the table that it works for, and tables that nobody works for."""
    layers, criteria = mission.layers, mission.criteria
    kinds = [guidance.kind for guidance in layers.guidances]
    for kind, key in TABLES.items():
        table = getattr(layers, key)
        if kind in kinds and set(kinds) != {kind}:
            raise MissionError(f"layers.guidance: {kind} works for all drones, or for none")
        if kind in kinds and table is None:
            raise MissionError(f"layers.{key} is missing: {kind} needs a table to work for")
        if table is not None and kind not in kinds and all(":" not in word for word in kinds):
            raise MissionError(f"layers.{key} is for the class {kind}, but class is {kinds[0]}")
    if layers.tasks is not None and layers.delivery is not None:
        raise MissionError("layers.tasks and layers.delivery: there is one table at a time")
    if layers.tasks is not None and not all(
        low < high for low, high in zip(layers.tasks.low, layers.tasks.high, strict=True)
    ):
        raise MissionError(
            f"layers.tasks.low is {list(layers.tasks.low)}, but must be below high, {list(layers.tasks.high)}"
        )
    needs = {
        "tasks_completed": (criteria.tasks_completed is not None, layers.tasks or layers.delivery, "layers.tasks"),
        "assignment_optimal": (criteria.assignment_optimal, layers.tasks, "layers.tasks"),
        "routes_gap": (criteria.routes_gap is not None, layers.delivery, "layers.delivery"),
    }
    for key, (is_asked, table, missing) in needs.items():
        if is_asked and table is None:
            raise MissionError(f"criteria.{key} needs {missing}")


def _check_distances_and_leaders(mission: LayeredMission) -> None:
    """Refuse distances that nobody knows, followers without leaders, and leaders that nobody can tell where to fly."""
    from crazychoir_fw.mission.communicators import graph_of
    from crazychoir_fw.mission.roles import leads

    for number, guidance in enumerate(mission.layers.guidances):
        path = _path(mission, number)
        if guidance.kind in FORMATION_CONTROL and guidance.formation is None and "weights" not in guidance.options:
            raise MissionError(f"{path}.formation is missing: {guidance.kind} needs a place for each drone")
        if guidance.kind in CONTAINMENT:
            if guidance.formation is not None:
                raise MissionError(
                    f"{path}.formation: {guidance.kind} has none, its followers gather among the leaders"
                )
            if not guidance.leaders:
                raise MissionError(f"{path}.leaders is missing: followers need somebody to gather among")
            members = guidance.drones or [drone.id for drone in mission.fleet]
            inside = [i for i, drone in enumerate(mission.fleet) if drone.id in members]
            reached = graph_of(mission).reachable(i for i in inside if leads(mission, i))
            if lonely := [mission.fleet[i].id for i in inside if i not in reached]:
                raise MissionError(f"layers.communication.graph: no way leads from a leader to {', '.join(lonely[:5])}")
        if guidance.kind in (*FORMATION_CONTROL, *CONTAINMENT):
            for name in guidance.leaders:
                if mission.layers.planning_of(name) is None:
                    raise MissionError(f"layers.planning is missing: leaders such as {name} fly trajectories")


def _check_control(mission: LayeredMission) -> None:
    for drone in mission.fleet:
        control, planning = mission.layers.control_of(drone.id), mission.layers.planning_of(drone.id)
        path = mission.layers.path_of(drone.id, "control")
        if control is None and planning is not None:
            raise MissionError(f"{path} is missing: what is planned here must be controlled here")
        if control is None:
            continue
        if control.kind == "VelocityController" and control.command != "vel":
            raise MissionError(f"{path}.sender is '{control.sender}', but a VelocityController sends by VelSender")
        if control.kind == "HierarchicalController" and control.command == "vel":
            raise MissionError(f"{path}.sender is 'VelSender', but must be FPQRSender or FRPYSender there")
        if drone.motor_ctrl is not None:
            raise MissionError(f"{drone.id} has a motor_ctrl, but layers fly it already")


_FILTERED = {"DoubleIntegratorCBF": "HierarchicalController", "SingleIntegratorCBF": "VelocityController"}
_OF_ONE = {
    "DoubleIntegratorCBF": ("kappa", "max_acceleration", "max_braking_acceleration"),
    "SingleIntegratorCBF": ("max_velocity", "max_braking_velocity", "rate"),
}


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
    needed = _FILTERED[safety.filter]
    if control.kind != needed:
        raise MissionError(
            f"layers.safety.filter is {safety.filter}, which filters the commands of a {needed}, but "
            f"layers.control.class is {control.kind}"
        )
    for kind, keys in _OF_ONE.items():
        for key in keys:
            if kind != safety.filter and getattr(safety, key) is not None:
                raise MissionError(f"layers.safety.{key} is for the filter {kind}, but filter is {safety.filter}")
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
        wanted = getattr(phase.maneuver, "drones", None)
        if wanted is not None:
            _known(f"{path}.drones", wanted, names)
        if phase.name == "go_to" and len(wanted or names) > 1:
            raise MissionError(f"{path} sends {len(wanted or names)} drones to one point; name one with drones: [id]")
        if phase.name == "trajectory" and any(mission.layers.planning_of(name) is None for name in wanted or names):
            raise MissionError(f"{path} needs layers.planning, which makes references out of its points")


def _check_criteria(mission: LayeredMission) -> None:
    criteria = mission.criteria
    for key in ("bearing_error_deg", "bearing_error_max_deg"):
        layers = mission.layers
        if getattr(criteria, key) is not None and (len(layers.guidances) > 1 or layers.guidance.formation is None):
            raise MissionError(f"criteria.{key} needs layers.guidance.formation of all drones, whose bearings count")
    if criteria.surveillance_error_m is not None or criteria.surveillance_rms_m is not None:
        from crazychoir_fw.mission.surveillance import surveillance_of

        if surveillance_of(mission) is None:
            raise MissionError(
                "criteria.surveillance_error_m and surveillance_rms_m need layers.guidance of class "
                "AggregativeGuidance, with an intruder for each defender"
            )
    layers = mission.layers
    is_one = len(layers.guidances) == 1
    if criteria.distance_error_m is not None and not (is_one and layers.guidance.formation is not None):
        raise MissionError(
            "criteria.distance_error_m needs layers.guidance.formation of all drones, whose distances count"
        )
    if criteria.coupling_error_m is not None and not (is_one and layers.guidance.kind == "MPCGuidance"):
        raise MissionError("criteria.coupling_error_m is for the class MPCGuidance, which keeps drones together")
    if criteria.containment and not (is_one and layers.guidance.leaders):
        raise MissionError("criteria.containment needs layers.guidance.leaders, whose hull counts")
    if mission.layers.rate % mission.log_rate:
        raise MissionError(f"log_rate is {mission.log_rate}, but must be a divisor of {mission.layers.rate} Hz")


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
