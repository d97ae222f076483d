"""From a mission to the controllers of its drones, with what keeps them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw import control, planning
from crazychoir_fw.flight.control_group import ControlGroup
from crazychoir_fw.flight.control_laws import LawMaker
from crazychoir_fw.flight.mixed_reference_ctrl import MixedReferenceCtrl
from crazychoir_fw.flight.safe_group import FilteredController, SafeControlGroup
from crazychoir_fw.flight.safety_filters import make_collision_avoidance, make_sensing
from crazychoir_fw.flight.sensing import Sensing
from crazychoir_fw.guidance.law import arguments_of
from crazychoir_fw.mission.factory import build
from crazychoir_fw.mission.roles import masses_of, names_of, what_it_follows

if TYPE_CHECKING:
    from crazychoir_fw.mission.layers import ControlLayer
    from crazychoir_fw.mission.schema import LayeredMission

_TRAJ_HANDLERS = {"acceleration": planning.AccelerationTraj, "position": planning.PositionTraj}


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
    follows = what_it_follows(mission, first) if follows is None else follows
    laws = LawMaker(mission, layer, where, layer.mass if layer.mass is not None else _mass_of(mission, i, masses))
    parts = {
        "command_sender": _sender(layer, float(layer.rate or mission.layers.rate)),
        "traj_handler": _TRAJ_HANDLERS.get(follows, planning.FullStateTraj)(),
    }
    cls = layer.law(f"{where}.class")
    if "velocity_strategy" in arguments_of(cls):
        parts["velocity_strategy"] = laws.velocity()
    if "pos_strategy" in arguments_of(cls):
        parts["pos_strategy"] = laws.both_positions(i, accelerated) if len(accelerated) else laws.position(follows)
        parts["attitude_strategy"] = laws.attitude()
    return build(cls if laws.safe is None else cls.with_filter(), where, parts, {})


def _mass_of(mission: LayeredMission, i: int | Sequence[int], masses: Sequence[float] | None) -> Any:
    known = np.array(masses_of(mission) if masses is None else masses, float)
    return float(known[i]) if isinstance(i, int) else known[list(i)]


def _sender(layer: ControlLayer, rate: float) -> Any:
    return getattr(control, layer.sender or ("VelSender" if layer.command == "vel" else "FPQRSender"))(rate)


def make_groups(
    mission: LayeredMission, masses: Sequence[float], truth: Callable[[], Any] | None = None
) -> list[ControlGroup]:
    """Return the controllers of all drones: one object for all that are controlled alike.

    Args:
        mission: The mission.
        masses: What all drones weigh (kg).
        truth: Returns their true poses; None where the backend has none.
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

    def of_one(i: int) -> ControlGroup:
        return group(make_controller(mission, [i], masses), [i], what_it_follows(mission, i))

    def with_one(made: ControlGroup) -> ControlGroup:
        made.of_one = of_one
        return made

    def group(controller: Any, members: Sequence[int], follows: str, accelerated: Sequence[int] = ()) -> ControlGroup:
        if sensing is None:
            return with_one(ControlGroup(controller, members, layer.command, follows, accelerated))
        avoidance = make_collision_avoidance(mission)
        if avoidance is not None:
            rate = float(mission.layers.safety.rate or mission.layers.rate)  # type: ignore[union-attr]
            controller = FilteredController(controller, avoidance, rate)
        return with_one(SafeControlGroup(sensing, controller, members, layer.command, follows, accelerated))

    if set(alike) == {"fullstate", "acceleration"} and MixedReferenceCtrl.replaces(layer):
        everybody = sorted([*alike["fullstate"], *alike["acceleration"]])
        # made as that of drones that follow full states
        controller = make_controller(mission, everybody, masses, "fullstate", alike["acceleration"])
        return [group(controller, everybody, "fullstate", alike["acceleration"])]
    return [group(make_controller(mission, members, masses), members, follows) for follows, members in alike.items()]
