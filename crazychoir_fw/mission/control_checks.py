"""What of the layers that plan, control and keep apart can only be judged when all of a mission is known."""

from __future__ import annotations

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.guidance.law import arguments_of
from crazychoir_fw.mission.layers import ControlLayer, SafetyLayer
from crazychoir_fw.mission.layers.control import SENDERS
from crazychoir_fw.mission.registry import our_laws
from crazychoir_fw.mission.schema import LayeredMission


def check_control(mission: LayeredMission) -> None:
    """Refuse drones that something plans for and nothing controls, and senders that do not fit."""
    for drone in mission.fleet:
        control, planning = mission.layers.control_of(drone.id), mission.layers.planning_of(drone.id)
        path = mission.layers.path_of(drone.id, "control")
        if control is None and planning is not None:
            raise MissionError(f"{path} is missing: what is planned here must be controlled here")
        if control is None:
            continue
        commands = control.law(f"{path}.class").commands
        if control.command not in commands:
            senders = " or ".join(sender for sender, kind in SENDERS.items() if kind in commands)
            raise MissionError(f"{path}.sender is '{control.sender}', but must be {senders} with a {control.kind}")
        if drone.motor_ctrl is not None:
            raise MissionError(f"{drone.id} has a motor_ctrl, but layers fly it already")


def check_safety(mission: LayeredMission) -> None:
    """Refuse filters that do not fit what they filter."""
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
    _check_filter(safety, control)
    if safety.sensing_distance <= safety.distance + safety.margin:
        raise MissionError(
            f"layers.safety.sensing_distance is {safety.sensing_distance:g}, but must be above distance and margin, "
            f"{safety.distance + safety.margin:g} m"
        )
    if safety.sees == "truth" and mission.backend == "hardware":
        raise MissionError("layers.safety.sees is 'truth', but nobody knows the truth of real drones; use odometry")


def _check_filter(safety: SafetyLayer, control: ControlLayer) -> None:
    """Refuse a filter that does not fit the controller, and numbers that it does not take."""
    law, taken = safety.law(), arguments_of(safety.law())
    if control.law().filtered != law.filters:
        needed = [name for name, one in our_laws("control").items() if one.filtered == law.filters]  # type: ignore[attr-defined]
        raise MissionError(
            f"layers.safety.filter is {safety.filter}, which filters the commands of a {' or '.join(needed)}, but "
            f"layers.control.class is {control.kind}"
        )
    for key in safety.of_filter:
        if key not in taken:
            owners = [name for name, one in our_laws("safety").items() if key in arguments_of(one)]
            if not owners:
                raise MissionError(f"layers.safety.options has no key '{key}', but only {', '.join(taken)}")
            raise MissionError(
                f"layers.safety.{key} is for the filter {' or '.join(owners)}, but filter is {safety.filter}"
            )
    if safety.rate is not None and law.filters != "velocity":
        raise MissionError(f"layers.safety.rate is for filters of velocities, but filter is {safety.filter}")
