"""What a host says of its drones to whoever watches a flight: `/drone_states` a few times a second, and `/events`.

Topics of the table say where drones are, and no more; which phase a drone is in, how its battery is, and what has
happened is known to the host alone. Both are `std_msgs/String` with JSON in it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.flight.access import Access, DroneState
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.ros.names import qos

STATES = "/drone_states"
EVENTS = "/events"
STATES_QOS = qos(1)
EVENTS_QOS = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes later hears what has happened before."""

_TELL_EVERY = 0.1  # [s], wall


@dataclass(frozen=True)
class ToldDrone:
    """What a host says of a drone."""

    phase: DronePhase
    presses: int = 0
    """How many buttons the host has carried out for it."""
    reference: NDArray[np.float64] | None = None
    """What it follows (m, world), shape (3,)."""
    failure: str = ""
    state: DroneState = field(default_factory=DroneState)


@dataclass(frozen=True)
class ToldStates:
    """What a host says of all drones at a time (s)."""

    mission: str
    backend: str
    time: float
    drones: Mapping[str, ToldDrone]


class StateTeller:
    """Lets a host say how its drones are; while nobody listens, it looks ten times a second whether somebody does."""

    def __init__(self, node: Any, experiment: Any, mission: Any, access: Access, presses: Callable[[int], int]) -> None:
        """Begin to tell.

        Args:
            node: Whose publishers are used; a timer on the clock of the wall is made there.
            experiment: The flight.
            mission: What it flies.
            access: What is known of its drones.
            presses: Returns how many buttons were carried out for a drone.
        """
        self._experiment = experiment
        self._about = {"mission": mission.name, "backend": mission.backend}
        self._access = access
        self._presses = presses
        self._told = 0
        self._states = node.create_publisher(String, STATES, STATES_QOS)
        self._events = node.create_publisher(String, EVENTS, EVENTS_QOS)
        node.create_timer(_TELL_EVERY, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _tell(self) -> None:
        happened = self._experiment.events
        for happening in happened[self._told :]:
            self._events.publish(String(data=json.dumps(happening.as_dict(), default=_plain)))
        self._told = len(happened)
        if self._states.get_subscription_count():
            drones = {agent.name: self._drone(agent) for agent in self._experiment.agents}
            told = {**self._about, "time": self._experiment.time, "drones": drones}
            self._states.publish(String(data=json.dumps(told, default=_plain)))

    def _drone(self, agent: Any) -> dict[str, Any]:
        state = self._access.state(agent.index)
        position = None if agent.reference is None else agent.reference.position
        return {
            "phase": agent.phase.value,
            "presses": self._presses(agent.index),
            "reference": None if position is None else [_finite(value) for value in position],
            "failure": agent.failure or "",
            "supervisor": state.supervisor,
            "battery_v": _finite(state.battery_v),
            "estimate_error_m": _finite(state.estimate_error_m),
            "link": state.link,
            "trouble": state.failure,
        }


def read_states(text: str) -> ToldStates:
    """Return what a host says.

    Raises:
        RangeError: If that are no states of drones.
    """
    try:
        fields = json.loads(text)
        drones = {str(name): _read_drone(one) for name, one in fields["drones"].items()}
        return ToldStates(str(fields["mission"]), str(fields["backend"]), _number(fields["time"]), drones)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise RangeError(f"{STATES}: {text[:40]!r} says nothing of drones") from None


def read_event(text: str) -> tuple[float, str, str | None, str | dict[str, Any]]:
    """Return time (s), kind, drone and details of something that happened.

    Raises:
        RangeError: If it is no event.
    """
    try:
        fields = json.loads(text)
        drone, details = fields["drone"], dict(fields["details"])
        if drone is not None and not isinstance(drone, str):
            raise TypeError
        told = details["reason"] if set(details) == {"reason"} else details
        return _number(fields["time"]), str(fields["kind"]), drone, told or ""
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise RangeError(f"{EVENTS}: {text[:40]!r} is no event") from None


def _read_drone(fields: Mapping[str, Any]) -> ToldDrone:
    reference = fields["reference"]
    if reference is not None:
        reference = np.array([_maybe(value) for value in reference])
        if reference.shape != (3,):
            raise ValueError
    state = DroneState(
        supervisor=str(fields["supervisor"]),
        battery_v=_maybe(fields["battery_v"]),
        estimate_error_m=_maybe(fields["estimate_error_m"]),
        link=str(fields["link"]),
        failure=str(fields["trouble"]),
    )
    return ToldDrone(DronePhase(fields["phase"]), int(fields["presses"]), reference, str(fields["failure"]), state)


def _number(value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError
    return number


def _maybe(value: Any) -> float:
    return float("nan") if value is None else _number(value)


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def _plain(value: Any) -> Any:
    """Return what JSON does not know as what it knows."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Sequence | set | frozenset):
        return list(value)
    return str(value)
