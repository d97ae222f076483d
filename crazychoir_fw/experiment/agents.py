"""From a mission to the layers of its drones: one process builds them all here, ROS processes one each."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw import control, guidance, planning, safety
from crazychoir_fw.errors import CrazychoirError, MissionError, RangeError, UnknownNameError
from crazychoir_fw.experiment.agent import Agent
from crazychoir_fw.experiment.both_laws import BothFlatnessLaws
from crazychoir_fw.experiment.communicators import graph_of, make_communicators, schedule_of
from crazychoir_fw.experiment.control_group import ControlGroup
from crazychoir_fw.experiment.safe_group import FilteredController, SafeBothFlatnessLaws, SafeControlGroup
from crazychoir_fw.experiment.sensing import Sensing
from crazychoir_fw.guidance.gains import FORMATION_GAINS, FormationGains
from crazychoir_fw.guidance.graph import Schedule
from crazychoir_fw.user_code import describe, load_module

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import ControlLayer, GuidanceLayer
    from crazychoir_fw.mission.schema import LayeredMission

_CONTROL_GAINS = {
    "position": (control.POSITION_GAINS, control.PositionGains),
    "attitude": (control.ATTITUDE_GAINS, control.AttitudeGains),
    "velocity": (control.VELOCITY_GAINS, control.VelocityGains),
}


# -------------------------------------------------------------------------------- numbers of a mission


def names_of(mission: LayeredMission) -> list[str]:
    """Return the names of all drones."""
    return [drone.id for drone in mission.fleet]


def starts_of(mission: LayeredMission) -> NDArray[np.float64]:
    """Return where the drones start (m, world), shape (N, 3)."""
    return np.array([(*drone.position, 0.0)[:3] for drone in mission.fleet])


def guidance_of(mission: LayeredMission, i: int) -> GuidanceLayer:
    """Return what the mission says about the guidance of a drone."""
    return mission.layers.guidance_of(mission.fleet[i].id)


def formation_of(mission: LayeredMission, i: int = 0) -> NDArray[np.float64] | None:
    """Return the formation of a drone (m), shape (N, 3), if there is one; drones of other guidance are at 0."""
    layer = guidance_of(mission, i)
    if layer.formation is None:
        return None
    names = names_of(mission)
    members = names if layer.drones is None else layer.drones
    chosen = layer.formation if isinstance(layer.formation, list) else layer.formation.of(len(members))
    places = np.zeros((len(names), 3))
    for name, place in zip(members, chosen, strict=True):
        places[names.index(name)] = place if len(place) == 3 else (*place, layer.height)
    return places


def leads(mission: LayeredMission, i: int) -> bool:
    """Tell whether a drone leads the formation."""
    return mission.fleet[i].id in guidance_of(mission, i).leaders


def follows_trajectory(mission: LayeredMission, i: int) -> bool:
    """Tell whether a drone follows the references of a trajectory handler, and not those of its guidance."""
    layers, name = mission.layers, mission.fleet[i].id
    if layers.planning_of(name) is None:
        return layers.control_of(name) is None
    if issubclass(guidance_class(mission, i), guidance.CFDistributedFeedback):
        return leads(mission, i)
    return True


def is_only_watched(mission: LayeredMission, i: int) -> bool:
    """Tell whether nobody here commands a drone, because only motion capture knows it."""
    drone = mission.fleet[i]
    return mission.backend == "mixed" and drone.uri is None and drone.mocap is not None


def takeoff_time_of(mission: LayeredMission) -> float:
    """Return the time of the take-off (s): that of the first button."""
    for phase in mission.flight:
        if phase.name == "takeoff" and phase.button.duration > 0.0:
            return float(phase.button.duration)
    return 5.0


# -------------------------------------------------------------------------------- classes


def _class(word: str, stock: Any, base: type | None, key: str) -> type:
    """Return the class of a word: one of ours, or one of the user's, whose module is executed.

    Raises:
        UnknownNameError: If there is no such class.
        RangeError: If it is of another kind.
    """
    module_name, colon, class_name = word.rpartition(":")
    if not colon:
        return getattr(stock, word) if hasattr(stock, word) else getattr(_schemes(), word)
    what = f"{key} '{word}'"
    module = load_module(module_name, what)
    found = getattr(module, class_name, None)
    if found is None:
        own = [
            name
            for name, value in vars(module).items()
            if isinstance(value, type) and value.__module__ == module.__name__
        ]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'none at all'}")
    if not isinstance(found, type) or (base is not None and not issubclass(found, base)):
        must = f"a subclass of {base.__name__}" if base is not None else "a class"
        raise RangeError(f"{what}: {found!r} is allowed to be {must} only")
    return found


def _schemes() -> Any:
    """Return the package of guidance that optimizes; whoever does without it need not load it."""
    from crazychoir_fw import schemes

    return schemes


def guidance_class(mission: LayeredMission, i: int = 0) -> type:
    """Return the class of the guidance of a drone; a file of the user's is executed once per mission."""
    key = mission.layers.path_of(mission.fleet[i].id) + ".class"
    return _once(mission, key, guidance_of(mission, i).kind, guidance, guidance.CFGuidance)


def _once(mission: Any, key: str, word: str, stock: Any, base: type | None) -> type:
    classes = mission.__dict__.setdefault("_layer_classes", {})
    if (word, base) not in classes:
        classes[word, base] = _class(word, stock, base, key)
    return classes[word, base]


def _made(cls: type, key: str, arguments: Mapping[str, Any], options: Mapping[str, Any]) -> Any:
    """Return an object, given as much of what is known as its class asks for, and all that the file says.

    Raises:
        MissionError: If it cannot be made.
    """
    asked = inspect.signature(cls).parameters
    takes_all = any(parameter.kind is parameter.VAR_KEYWORD for parameter in asked.values())
    for name in options:
        if name not in asked and not takes_all:
            raise MissionError(f"{key}.options has no key '{name}', but only {', '.join(asked)}")
    known = {name: value for name, value in arguments.items() if name in asked or takes_all}
    try:
        return cls(**{**known, **options})
    except CrazychoirError as error:
        raise MissionError(f"{key}: {error}") from error
    except Exception as error:  # a user's code may raise anything
        raise MissionError(f"{key}: {cls.__name__} cannot be made: {describe(error)}") from error


# -------------------------------------------------------------------------------- guidance


def make_guidance(mission: LayeredMission, i: int, communicator: Any, schedule: Schedule | None = None) -> Any:
    """Return what decides for one drone.

    Args:
        mission: The mission.
        i: Its number.
        communicator: How it talks to others.
        schedule: Its neighbors, if they change.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    layer, name = guidance_of(mission, i), mission.fleet[i].id
    cls, key = guidance_class(mission, i), mission.layers.path_of(name)
    arguments: dict[str, Any] = {
        "agent_id": i,
        "communicator": communicator,
        "init_pos": starts_of(mission)[i],
        "height": layer.height,
        "takeoff_time": takeoff_time_of(mission),
        "update_frequency": float(mission.layers.rate),
        "is_leader": leads(mission, i),
        "deadline": mission.layers.communication_of(name).deadline_s,
    }
    if schedule is not None:
        arguments["schedule"] = schedule
    if "graph" in inspect.signature(cls).parameters:
        arguments["graph"] = graph_of(mission)
    formation = formation_of(mission, i)
    if formation is not None:
        arguments["formation"] = formation
    if layer.gains is not None:
        arguments["gains"] = layer.gains if isinstance(layer.gains, str) else _formation_gains(key, layer.gains)
    if mission.layers.delivery is not None:
        arguments["slots"] = len(mission.layers.delivery.requests)
    if layer.goals is not None:
        arguments["goals"] = [tuple(row) for row in layer.goals.get(name, [])]
    asked = inspect.signature(cls).parameters
    if "team" in asked:
        arguments["team"] = team_of(mission, i)
    # those of a formation are distances
    if "weights" in asked and "formation" not in asked and graph_of(mission).is_undirected:
        arguments["weights"] = graph_of(mission).metropolis_hastings()[i].tolist()
    return _made(cls, key, arguments, {**layer.options, **layer.options_by_drone.get(name, {})})


def team_of(mission: LayeredMission, i: int) -> list[int]:
    """Return the numbers of all drones with the guidance of a drone."""
    layer, names = guidance_of(mission, i), names_of(mission)
    return list(range(len(names))) if layer.drones is None else [names.index(name) for name in layer.drones]


def _formation_gains(key: str, given: Mapping[str, Any]) -> Any:
    """Return a set of formation gains that differs from another one."""
    return _gains(f"{key}.gains", given, FORMATION_GAINS, FormationGains, "webots")


def _gains(key: str, given: Mapping[str, Any], sets: Mapping[str, Any], kind: type, default: str) -> Any:
    base = given.get("base", default)
    if base not in sets:
        raise MissionError(f"{key}.base is {base!r}, but must be one of {', '.join(sets)}")
    known = [member.name for member in dataclasses.fields(kind)]
    changes = {name: value for name, value in given.items() if name != "base"}
    for name in changes:
        if name not in known:
            raise MissionError(f"{key} has no key '{name}', but only base, {', '.join(known)}")
    try:
        return dataclasses.replace(
            sets[base], **{k: tuple(v) if isinstance(v, list) else v for k, v in changes.items()}
        )
    except CrazychoirError as error:
        raise MissionError(f"{key}: {error}") from error


# -------------------------------------------------------------------------------- planning


def make_trajectory_handler(mission: LayeredMission, i: int) -> Any:
    """Return what plans for one drone, or None for one that follows no trajectory of ours.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    name = mission.fleet[i].id
    layer, key = mission.layers.planning_of(name), mission.layers.path_of(name, "planning")
    if layer is None or not follows_trajectory(mission, i):
        return None
    cls = _once(mission, f"{key}.class", layer.kind, planning, planning.TrajectoryHandler)
    return _made(cls, key, {"update_frequency": float(mission.layers.rate)}, layer.options)


# -------------------------------------------------------------------------------- control


def make_controller(
    mission: LayeredMission,
    i: int | Sequence[int],
    masses: Sequence[float] | None = None,
    follows: str | None = None,
    accelerated: Sequence[int] = (),
) -> Any:
    """Return the controller of a drone, or one for several that are controlled alike.

    Args:
        mission: The mission.
        i: Number of the drone, or numbers.
        masses: What all drones of the mission weigh (kg); None is what their platforms weigh.
        follows: What its references consist of; None is what the mission says of the first drone.
        accelerated: Which of several follow accelerations nevertheless, for the flatness laws.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    first = i if isinstance(i, int) else i[0]
    name = mission.fleet[first].id
    layer, where = mission.layers.control_of(name), mission.layers.path_of(name, "control")
    if layer is None:
        return None
    rate = float(layer.rate or mission.layers.rate)
    if layer.mass is not None:
        mass: Any = layer.mass
    else:
        known = np.array(masses_of(mission) if masses is None else masses, float)
        mass = float(known[i]) if isinstance(i, int) else known[list(i)]
    follows = what_it_follows(mission, first) if follows is None else follows
    topic = {"acceleration": planning.AccelerationTraj, "position": planning.PositionTraj}
    traj_handler = topic.get(follows, planning.FullStateTraj)()
    sender = getattr(control, layer.sender or ("VelSender" if layer.command == "vel" else "FPQRSender"))(rate)

    def strategy(role: str, word: str, gains: str, base: Any) -> Any:
        key = f"{where}.{role}"
        cls = _once(mission, key, word, control, base)
        sets, kind = _CONTROL_GAINS[gains]
        chosen = layer.gains if isinstance(layer.gains, str) else layer.gains.get(gains, "webots")
        if isinstance(chosen, Mapping):
            chosen = _gains(f"{where}.gains.{gains}", chosen, sets, kind, "webots")
        known = {"update_frequency": rate, "gains": chosen, "mass": mass, "gravity": GRAVITY}
        return _made(cls, key, {**known, "safety_filter": safe}, {})

    safe = make_safety_filter(mission)

    if layer.kind == "VelocityController":
        law = strategy("velocity", layer.velocity, "velocity", None)
        return control.VelocityController(velocity_strategy=law, command_sender=sender, traj_handler=traj_handler)
    word = layer.acceleration if follows == "acceleration" else layer.position
    if safe is not None:
        word = _SAFE_LAWS.get(word, word)
    position = strategy(
        "acceleration" if follows == "acceleration" else "position", word, "position", control.PositionCtrlStrategy
    )
    if len(accelerated):
        arguments = {"update_frequency": rate, "gains": position.gains, "mass": position.mass, "gravity": GRAVITY}
        if safe is None:
            position = BothFlatnessLaws(np.isin(i, accelerated), **arguments)
        else:
            position = SafeBothFlatnessLaws(np.isin(i, accelerated), safe, **arguments)
    attitude = None
    if layer.command == "fpqr":
        attitude = strategy("attitude", layer.attitude, "attitude", control.AttitudeCtrlStrategy)
    if layer.kind == "HierarchicalController":
        cls: type = control.HierarchicalController if safe is None else control.SafeHierarchicalController
    else:
        cls = _once(mission, f"{where}.class", layer.kind, control, control.CrazyflieController)
    parts = {
        "pos_strategy": position,
        "attitude_strategy": attitude,
        "command_sender": sender,
        "traj_handler": traj_handler,
    }
    return _made(cls, where, parts, {})


_SAFE_LAWS = {
    "FlatnessPositionCtrl": "SafeFlatnessPositionCtrl",
    "FlatnessAccelerationCtrl": "SafeFlatnessAccelerationCtrl",
}

GRAVITY = 9.81
"""Acceleration of gravity of both simulations (m/s^2)."""


def masses_of(mission: LayeredMission) -> list[float]:
    """Return what the vehicles of a mission weigh, as far as their file tells (kg)."""
    from crazychoir_fw.integrator.platforms import platform_mass

    masses = []
    for drone in mission.fleet:
        mass = platform_mass(drone.platform) if drone.mass is None else drone.mass
        masses.append(mass + (float(drone.payload["mass"]) if drone.payload else 0.0))
    return masses


def what_it_follows(mission: LayeredMission, i: int) -> str:
    """Return what the references of a drone consist of: acceleration, position or fullstate."""
    if not follows_trajectory(mission, i):
        return str(guidance_class(mission, i).kind)
    name = mission.fleet[i].id
    layer = mission.layers.planning_of(name)
    if layer is None:
        return "fullstate"
    key = mission.layers.path_of(name, "planning")
    return str(_once(mission, f"{key}.class", layer.kind, planning, planning.TrajectoryHandler).kind)


# -------------------------------------------------------------------------------- safety


def make_safety_filter(mission: LayeredMission) -> Any:
    """Return what keeps drones apart, or None.

    Raises:
        CrazychoirError: If it cannot be made as the mission says.
    """
    layer = mission.layers.safety
    if layer is None:
        return None
    names = ("gamma", "kappa", "max_acceleration", "max_braking_acceleration", "max_velocity", "max_braking_velocity")
    given = {name: getattr(layer, name) for name in names if getattr(layer, name) is not None}
    kind = getattr(safety, layer.filter)
    return kind(distance=layer.distance + layer.margin, keep_right=layer.keep_right, **given)


def make_collision_avoidance(mission: LayeredMission) -> Any:
    """Return the filter between velocity controllers and drones, or None if there is none of that kind."""
    filter_ = make_safety_filter(mission)
    if filter_ is None or mission.layers.safety.filter != "SingleIntegratorCBF":  # type: ignore[union-attr]
        return None
    return safety.SingleIntegratorCollisionAvoidance(filter_)


def make_sensing(mission: LayeredMission, truth: Callable[[], Any] | None = None) -> Sensing | None:
    """Return what the drones see each other by, or None.

    Args:
        mission: The mission.
        truth: Returns the true poses, for missions whose drones see others where they are.
    """
    layer = mission.layers.safety
    if layer is None:
        return None
    rate = float(layer.sensing_rate or mission.layers.rate)
    return Sensing(layer.sensing_distance, rate, truth if layer.sees == "truth" else None)


# -------------------------------------------------------------------------------- a whole swarm


def make_agents(
    mission: LayeredMission, clock: Callable[[], float], positions: Callable[[], NDArray[np.float64]] | None = None
) -> list[Agent]:
    """Return guidance and trajectory handler of every drone, talking to each other in this process.

    Args:
        mission: The mission.
        clock: Time of the backend (s).
        positions: Returns where all drones are (m, world), shape (N, 3), for graphs that depend on it.

    Raises:
        CrazychoirError: If one cannot be made as the mission says; the message names key and drone.
    """
    schedule = schedule_of(mission, clock(), positions)
    communicators = make_communicators(mission, guidance.InProcessTransport(), clock, schedule=schedule)
    agents = []
    for i, name in enumerate(names_of(mission)):
        is_watched = is_only_watched(mission, i)
        planner = None if is_watched else make_trajectory_handler(mission, i)
        agents.append(Agent(i, name, make_guidance(mission, i, communicators[i], schedule), planner, is_watched))
    return agents


def make_groups(
    mission: LayeredMission, masses: Sequence[float], truth: Callable[[], Any] | None = None
) -> list[ControlGroup]:
    """Return the controllers of all drones: one object for all that are controlled alike.

    Args:
        mission: The mission.
        masses: What all drones weigh (kg).
        truth: Returns their true poses, if anybody knows them.
    """
    of_layer: dict[str, tuple[Any, dict[str, list[int]]]] = {}
    for i, name in enumerate(names_of(mission)):
        layer = mission.layers.control_of(name)
        if layer is not None:
            _, alike = of_layer.setdefault(mission.layers.path_of(name, "control"), (layer, {}))
            alike.setdefault(what_it_follows(mission, i), []).append(i)
    sensing = make_sensing(mission, truth)
    return [group for layer, alike in of_layer.values() for group in _groups(mission, masses, layer, alike, sensing)]


def _groups(
    mission: LayeredMission,
    masses: Sequence[float],
    layer: ControlLayer,
    alike: Mapping[str, list[int]],
    sensing: Sensing | None,
) -> list[ControlGroup]:
    """Return the controllers of drones with one control layer.

    Args:
        mission: The mission.
        masses: Of all its drones (kg).
        layer: Their control layer.
        alike: Their numbers, by what they follow.
        sensing: What they see each other by, if they do.
    """

    def group(controller: Any, members: Sequence[int], follows: str, accelerated: Sequence[int] = ()) -> ControlGroup:
        if sensing is None:
            return ControlGroup(controller, members, layer.command, follows, accelerated)
        avoidance = make_collision_avoidance(mission)
        if avoidance is not None:
            rate = float(mission.layers.safety.rate or mission.layers.rate)  # type: ignore[union-attr]
            controller = FilteredController(controller, avoidance, rate)
        return SafeControlGroup(sensing, controller, members, layer.command, follows, accelerated)

    laws = (layer.kind, layer.position, layer.acceleration)
    stock = ("HierarchicalController", "FlatnessPositionCtrl", "FlatnessAccelerationCtrl")
    if set(alike) == {"fullstate", "acceleration"} and laws == stock:
        everybody = sorted([*alike["fullstate"], *alike["acceleration"]])
        # made as that of drones that follow full states
        controller = make_controller(mission, everybody, masses, "fullstate", alike["acceleration"])
        return [group(controller, everybody, "fullstate", alike["acceleration"])]
    return [group(make_controller(mission, members, masses), members, follows) for follows, members in alike.items()]
