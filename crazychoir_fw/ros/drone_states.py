"""State of all drones and events of a flight, published by its host: `/drone_states` at a fixed rate, and `/events`.

The topics of each drone carry its pose only; its phase, its battery and the events are known to the host alone. Both
topics are `std_msgs/String` with JSON.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, FiniteFloat, ValidationError
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.access import Access
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.event import Event
from crazychoir_fw.ros.names import qos

STATES = "/drone_states"
EVENTS = "/events"
STATES_QOS = qos(1)
EVENTS_QOS = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Transient local: a subscriber that joins late receives all past events."""

_TELL_EVERY = 0.05  # [s], wall


def _maybe(value: Any) -> float:
    """Return a number; null in JSON is NaN."""
    number = math.nan if value is None else float(value)
    if math.isinf(number):
        raise ValueError("must be finite")
    return number


Maybe = Annotated[float, BeforeValidator(_maybe)]
Vector = tuple[Maybe, Maybe, Maybe]


class ToldDrone(BaseModel):
    """State of a drone, as its host publishes it."""

    phase: DronePhase
    presses: int = 0
    """How many buttons the host has carried out for it."""
    position: Vector
    """Position (m, world)."""
    orientation: tuple[Maybe, Maybe, Maybe, Maybe]
    """Quaternion xyzw."""
    velocity: Vector
    """(m/s, world)."""
    reference: Vector | None = None
    """Position of its reference (m, world)."""
    failure: str = ""
    """Reason why its flight ended; empty without one."""
    supervisor: str = ""
    battery_v: Maybe = math.nan
    estimate_error_m: Maybe = math.nan
    link: str = ""
    trouble: str = ""
    """Fault of the drone itself; empty without one."""
    motors: Annotated[tuple[FiniteFloat, ...], Field(max_length=4)] = ()
    """Duty of each motor, 0 to 1; empty where it is not known."""


class ToldStates(BaseModel):
    """State of all drones at a time (s), as their host publishes it."""

    mission: str
    backend: str
    time: FiniteFloat
    drones: dict[str, ToldDrone]


class _ToldEvent(BaseModel):
    time: FiniteFloat
    kind: str
    drone: str | None
    details: dict[str, Any]


class StateTeller:
    """Publishes states and events of a host; states are composed only while `/drone_states` has a subscriber."""

    def __init__(self, node: Any, experiment: Any, mission: Any, access: Access, presses: Callable[[int], int]) -> None:
        """Make the publishers and start the timer.

        Args:
            node: Node that owns the publishers and a timer on the wall clock.
            experiment: The flight.
            mission: The mission flown.
            access: State and true pose of its drones.
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
        for event in happened[self._told :]:
            self._events.publish(String(data=json.dumps(event.as_dict(), default=_plain)))
        self._told = len(happened)
        if self._states.get_subscription_count():
            pose = self._access.true_pose()
            drones = {agent.name: self._drone(agent, pose) for agent in self._experiment.agents}
            told = ToldStates(**self._about, time=self._experiment.time, drones=drones)
            self._states.publish(String(data=told.model_dump_json()))

    def _drone(self, agent: Any, pose: Pose) -> ToldDrone:
        i, state = agent.index, self._access.state(agent.index)
        velocity = np.full(3, np.nan) if pose.velocity is None else pose.velocity[i]
        wanted = None if agent.reference is None else agent.reference.position
        return ToldDrone(
            phase=agent.phase,
            presses=self._presses(i),
            position=tuple(pose.position[i]),
            orientation=tuple(pose.orientation[i]),
            velocity=tuple(velocity),
            reference=None if wanted is None else tuple(wanted),
            failure=agent.failure or "",
            supervisor=state.supervisor,
            battery_v=state.battery_v,
            estimate_error_m=state.estimate_error_m,
            link=state.link,
            trouble=state.failure,
            motors=state.motors,
        )


def read_states(text: str) -> ToldStates:
    """Parse a message of `/drone_states`.

    Raises:
        RangeError: If the text does not hold states of drones.
    """
    try:
        return ToldStates.model_validate_json(text)
    except ValidationError:
        raise RangeError(f"{STATES}: {text[:40]!r} says nothing of drones") from None


def read_event(text: str) -> Event:
    """Parse a message of `/events`.

    Raises:
        RangeError: If it is no event.
    """
    try:
        told = _ToldEvent.model_validate_json(text)
    except ValidationError:
        raise RangeError(f"{EVENTS}: {text[:40]!r} is no event") from None
    details: str | Mapping[str, Any] = told.details["reason"] if set(told.details) == {"reason"} else told.details
    return Event(told.time, told.kind, told.drone, details or "")


def _plain(value: Any) -> Any:
    """Convert NumPy values and sets, and anything else, to types that JSON has."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return sorted(value) if isinstance(value, set | frozenset) else str(value)
