"""From a mission to the controllers of its drones, with what keeps them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw import control, planning
from crazychoir_fw.experiment.both_laws import BothFlatnessLaws
from crazychoir_fw.experiment.control_group import ControlGroup
from crazychoir_fw.experiment.making import changed_gains, class_of, made
from crazychoir_fw.experiment.roles import masses_of, names_of, what_it_follows
from crazychoir_fw.experiment.safe_group import FilteredController, SafeBothFlatnessLaws, SafeControlGroup
from crazychoir_fw.experiment.safety_filters import make_collision_avoidance, make_safety_filter, make_sensing
from crazychoir_fw.experiment.sensing import Sensing

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import ControlLayer
    from crazychoir_fw.mission.schema import LayeredMission

GRAVITY = 9.81
"""Acceleration of gravity of both simulations (m/s^2)."""

_CONTROL_GAINS = {
    "position": (control.POSITION_GAINS, control.PositionGains),
    "attitude": (control.ATTITUDE_GAINS, control.AttitudeGains),
    "velocity": (control.VELOCITY_GAINS, control.VelocityGains),
}

_SAFE_LAWS = {
    "FlatnessPositionCtrl": "SafeFlatnessPositionCtrl",
    "FlatnessAccelerationCtrl": "SafeFlatnessAccelerationCtrl",
}


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
        cls = class_of(mission, key, word, control, base)
        sets, kind = _CONTROL_GAINS[gains]
        chosen = layer.gains if isinstance(layer.gains, str) else layer.gains.get(gains, "webots")
        if isinstance(chosen, Mapping):
            chosen = changed_gains(f"{where}.gains.{gains}", chosen, sets, kind, "webots")
        known = {"update_frequency": rate, "gains": chosen, "mass": mass, "gravity": GRAVITY}
        return made(cls, key, {**known, "safety_filter": safe}, {})

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
        cls = class_of(mission, f"{where}.class", layer.kind, control, control.CrazyflieController)
    parts = {
        "pos_strategy": position,
        "attitude_strategy": attitude,
        "command_sender": sender,
        "traj_handler": traj_handler,
    }
    return made(cls, where, parts, {})


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
