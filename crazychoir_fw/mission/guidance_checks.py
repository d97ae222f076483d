"""Whether a mission has what its guidance laws say that they need, by what they say of themselves."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.common.user_code import USER_ERRORS, describe
from crazychoir_fw.guidance import CFGuidance
from crazychoir_fw.guidance.law import arguments_of, options_of
from crazychoir_fw.mission.communication import Graph
from crazychoir_fw.mission.layers import GuidanceLayer
from crazychoir_fw.mission.registry import our_laws
from crazychoir_fw.mission.roles import context_of, metrics_of
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.mission.values import did_you_mean


def check_guidance(mission: LayeredMission) -> None:
    """Refuse entries of guidance that lack something, and tables and criteria that no law takes.

    Raises:
        CrazychoirError: With the key and what is allowed.
    """
    names = [drone.id for drone in mission.fleet]
    _check_cover(mission, names)
    _check_edges(mission, names)
    _check_tables(mission)
    for number in range(len(mission.layers.guidances)):
        _check_entry(mission, number, names)
    _check_criteria(mission)


def check_names(path: str, wanted: Iterable[str], names: Collection[str]) -> None:
    """Refuse names of drones that are none of those known."""
    for name in wanted:
        if name not in names:
            hint = did_you_mean(name, names)
            raise MissionError(f"{path} names '{name[:40]}', but must name drones of the mission{hint}")


def _check_cover(mission: LayeredMission, names: list[str]) -> None:
    """Refuse drones without a guidance, or with two."""
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
        check_names(path, guidance.drones, names)
        for name in guidance.drones:
            if name in decided:
                raise MissionError(
                    f"{path} names '{name}', but layers.guidance[{decided[name]}] decides for it already"
                )
            decided[name] = number
    for name in names:
        if name not in decided:
            raise MissionError(f"layers.guidance decides nothing for '{name}', but must name each drone in one entry")


def _path(mission: LayeredMission, number: int) -> str:
    """Return where in the file an entry of guidance stands."""
    return f"layers.guidance[{number}]" if isinstance(mission.layers.decides, list) else "layers.guidance"


def _check_entry(mission: LayeredMission, number: int, names: list[str]) -> None:
    """Refuse an entry of guidance that lacks what its law needs."""
    guidance, path = mission.layers.guidances[number], _path(mission, number)
    law = guidance.law(f"{path}.class")
    members = names if guidance.drones is None else guidance.drones
    check_names(f"{path}.leaders", guidance.leaders, members)
    check_names(f"{path}.options_by_drone", guidance.options_by_drone, members)
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
    check_names(f"{path}.goals", guidance.goals, names)
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
                check_names(f"{path}.graph[{i}]", pair, members)


def _check_tables(mission: LayeredMission) -> None:
    """Refuse laws without the table that they work for, and tables that no law works for."""
    layers = mission.layers
    needed = {
        guidance.law(f"{_path(mission, number)}.class").needs.table: guidance.kind
        for number, guidance in enumerate(layers.guidances)
    }
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


def _check_criteria(mission: LayeredMission) -> None:
    """Refuse criteria that no law of the mission declares, and limits out of their ranges."""
    try:
        declared = {key: one for metrics in metrics_of(mission) for key, one in metrics.criteria.items()}
    except USER_ERRORS as error:  # a user's code may raise anything
        raise MissionError(f"layers.guidance: its metrics cannot be made: {describe(error)}") from error
    for key, limit in mission.criteria.of_laws.items():
        if key not in declared:
            raise _no_criterion(mission, key, declared)
        declared[key].checked(key, limit)
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
