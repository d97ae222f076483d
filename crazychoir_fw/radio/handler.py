"""`RadioHandler`: several drones behind one Crazyradio, or behind any other links of cflib."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import TracebackType
from typing import Any, ClassVar, TypeVar

from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.common.finite import positive
from crazychoir_fw.radio.agents import AgentId, Uris, agent_name, agents_of
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.parameters import ParameterValue
from crazychoir_fw.radio.threads import LOGGER, call, close_at_exit, forget, in_parallel, raise_together

_Handler = TypeVar("_Handler", bound="RadioHandler")
Agents = AgentId | Iterable[AgentId] | None
"""One agent, several, or None for all."""


class RadioHandler:
    """Connects to several drones, and logs; its subclasses also fly them.

    Example::

        with RadioHandlerVel(["udp://127.0.0.1:19850", "udp://127.0.0.1:19851"]) as swarm:
            swarm.takeoff(0.5)
            swarm.command("agent_0", 0.2, 0.0, 0.0)

    The same object flies simulated drones (``udp://``) and real ones (``radio://0/80/2M/E7E7E7E701``): whatever URI
    cflib knows.

    A drone of a swarm that is lost, stopped or refuses to fly stops no other one.

    Threads: all methods may be called from any thread. Callbacks come from threads of cflib and of the handler: they
    should return soon, and must not write parameters.
    """

    drone_class: ClassVar[type[RadioDrone]] = RadioDrone
    """What flies each drone."""
    defaults: ClassVar[Mapping[str, Any]] = {}
    """Options that this class has other defaults for."""
    limits: ClassVar[Mapping[str, float]] = {}
    """Largest values of a command, above 0, with their defaults: more options of this class."""

    def __init__(self, uris: Uris, agent_ids: Iterable[AgentId] | None = None, **options: Any) -> None:
        """Prepare; `connect`, or a ``with`` statement, connects.

        Args:
            uris: URIs in a list, or by agent.
            agent_ids: Agents of a list of URIs, in its order: names, or numbers (1 is ``agent_1``); 0, 1, … without.
            options: See `Options`.

        Raises:
            RangeError: If agents, URIs or a value of an option are none.
            UnknownNameError: If there is no such option, or no such agent.
        """
        limits = {name: options.pop(name, value) for name, value in self.limits.items()}
        for name, value in limits.items():
            positive(name, value)
        self.options = self._options(options)
        self.on_state: Callable[[str, Any, str], None] | None = None
        """Called with agent, `LinkState` and reason."""
        self.on_log: Callable[[str, dict[str, float | int], float], None] | None = None
        """Called with agent, values by ``group.name``, and the drone's time (s)."""
        self.on_odometry: Callable[[str, Any], None] | None = None
        """Called with agent and `Odometry`."""
        self.on_event: Callable[[str, str, str], None] | None = None
        """Called with agent, kind (``silence``, ``safety_area``, ``grounded``, ``logs``) and a text."""
        agents = agents_of(uris, agent_ids)
        own = {agent_name(agent): values for agent, values in self.options.agent_parameters.items()}
        for agent in own:
            if agent not in agents:
                raise UnknownNameError(f"agent_parameters: there is no agent '{agent}', allowed: {', '.join(agents)}")
        self._drones = {agent: self._make(agent, uri, own.get(agent, {})) for agent, uri in agents.items()}
        for drone in self:
            for name, value in limits.items():
                setattr(drone, name, value)
        self._lock = threading.Lock()
        self._is_closed = False

    def _make(self, agent: str, uri: str, parameters: Mapping[str, ParameterValue]) -> RadioDrone:
        return self.drone_class(agent, uri, self.options, self._tell, parameters)

    # ---------------------------------------------------------------- drones

    def __getitem__(self, agent_id: AgentId) -> RadioDrone:
        """Return one drone by its agent.

        Raises:
            UnknownNameError: If there is no such agent.
        """
        name = agent_name(agent_id)
        if name not in self._drones:
            raise UnknownNameError(f"there is no agent '{name}', allowed: {', '.join(self._drones)}")
        return self._drones[name]

    def __iter__(self) -> Iterator[RadioDrone]:
        return iter(self._drones.values())

    def __len__(self) -> int:
        return len(self._drones)

    def __contains__(self, agent_id: object) -> bool:
        return isinstance(agent_id, str | int) and agent_name(agent_id) in self._drones

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {list(self._drones.values())}>"

    @property
    def agent_ids(self) -> list[str]:
        """Names of all agents."""
        return list(self._drones)

    # ---------------------------------------------------------------- life

    def connect(self: _Handler, *, all_or_none: bool = True) -> _Handler:
        """Connect to all drones at once, write their parameters and start their logs.

        Args:
            all_or_none: Whether one that is not reached is an error, after which all links are closed. Otherwise it is
                only logged, and the others fly.

        Raises:
            RadioError: If drones are not reached; the text names each, its URI, and how far it got.
            CrazychoirError: If a drone cannot be set up as wanted: no such parameter or log variable.
        """
        self._is_closed = False
        close_at_exit(self)
        try:
            failures = in_parallel(self, lambda drone: drone.connect())
            hard = [error for _, error in failures if not isinstance(error, CrazychoirError)]
            if all_or_none or hard or len(failures) == len(self):
                raise_together(failures, len(self))
        except BaseException:
            self.close()
            raise
        for _, error in failures:
            LOGGER.warning("%s", error)
        return self

    def close(self) -> None:
        """Land or stop what flies, as `on_close` says, and close all links; takes about 1 s. May be called again."""
        with self._lock:
            if self._is_closed:
                return
            self._is_closed = True
        forget(self)
        for drone, error in in_parallel(self, lambda drone: drone.close()):
            LOGGER.error("%r was not closed well: %s", drone, error)

    def __enter__(self: _Handler) -> _Handler:
        return self.connect()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def tick(self, now: float | None = None) -> float:
        """Send what is due, for handlers with ``threaded=False``.

        Args:
            now: Not used: time is that of the option `clock`.

        Returns:
            When there is more to do (s).
        """
        return min(drone.tick(now) for drone in self)

    # ---------------------------------------------------------------- flight

    def command(self, agent_id: AgentId, *values: float, **named: float) -> bool:
        """Give a command to one drone; the classes beside this one say what it is.

        Returns:
            Whether the drone takes it; not before `takeoff`, after `stop`, or while it is not connected.

        Raises:
            UnknownNameError: If there is no such agent.
            RangeError: If a number is none, or leads out of a safety area that refuses.
            StateError: If this handler takes no commands, or the motors may not run.
        """
        return self[agent_id].command(*values, **named)

    def command_all(self, *values: float, **named: float) -> dict[str, bool]:
        """Give the same command to all drones; returns which took it."""
        return {drone.agent_id: drone.command(*values, **named) for drone in self}

    def cmd_vel(self, agent_id: AgentId, linear: Sequence[float], angular: Sequence[float]) -> bool:
        """Give a command in the vocabulary of a Twist, shape (3,) each."""
        return self[agent_id].cmd_vel(linear, angular)

    def takeoff(self, *args: float, agents: Agents = None, **named: float) -> None:
        """Take off, or unlock the thrust where set-points have one: see the drones of this handler.

        Raises:
            CrazychoirError: If some may not fly; the text says which and why. The others take off.
        """
        self._each(agents, lambda drone: drone.takeoff(*args, **named))

    def land(self, height: float = 0.0, duration: float = 2.0, *, agents: Agents = None) -> None:
        """Land by the planner on board; commands are ignored until `takeoff` or `resume`.

        Args:
            height: Height of the floor (m, world).
            duration: Time to get there (s), above 0.
            agents: Which; all without.
        """
        self._each(agents, lambda drone: drone.land(height, duration))

    def stop(self, agents: Agents = None) -> None:
        """Stop motors, and ignore commands until `resume`."""
        for drone in self._some(agents):
            drone.stop()

    def resume(self, agents: Agents = None) -> None:
        """Take commands again, after `stop`, `land` or a loss."""
        for drone in self._some(agents):
            drone.resume()

    def arm(self, armed: bool = True, agents: Agents = None) -> None:
        """Arm or disarm, for drones that need it; `takeoff` does it as well.

        Raises:
            RadioError: If some are not connected; the others get the request.
        """
        self._each(agents, lambda drone: drone.arm(armed))

    def recover(self, agents: Agents = None) -> None:
        """Tell drones that have crashed, and lie on their feet again, that they may fly.

        Raises:
            RadioError: If some are not connected; the others get the request.
        """
        self._each(agents, lambda drone: drone.recover())

    def emergency_stop(self, agents: Agents = None) -> None:
        """Stop motors until the drones are restarted; those out of reach as soon as they are reached."""
        for drone in self._some(agents):
            drone.emergency_stop()

    # ---------------------------------------------------------------- poses and parameters

    def external_pose(
        self, agent_id: AgentId, position: Sequence[float], quat_xyzw: Sequence[float] | None = None
    ) -> bool:
        """Forward a pose (m; quaternion xyzw, body to world) to one drone, at most `pose_hz` times per second."""
        return self[agent_id].external_pose(position, quat_xyzw)

    def set_parameters(self, values: Mapping[str, ParameterValue], agents: Agents = None) -> None:
        """Write parameters to drones at once, and wait until all have confirmed them. Not from a callback.

        Raises:
            UnknownNameError: If a drone has no such parameter.
            RangeError: If a value does not fit.
            RadioError: If a drone is not connected, or does not confirm.
        """

        def write(drone: RadioDrone) -> None:
            for name, value in values.items():
                drone.set_parameter(name, value)

        self._each(agents, write)

    # ---------------------------------------------------------------- parts

    def _options(self, given: Mapping[str, Any]) -> Options:
        known = set(Options.__dataclass_fields__)
        for name in given:
            if name not in known:
                raise UnknownNameError(f"there is no option '{name}', allowed: {', '.join(sorted(known))}")
        options = replace(Options(), **{**self.defaults, **given})
        if options.on_silence not in self.drone_class.silences:
            raise RangeError(
                f"on_silence is {options.on_silence!r}, allowed for {type(self).__name__}: "
                f"{', '.join(self.drone_class.silences)}"
            )
        return options

    def _some(self, agents: Agents) -> list[RadioDrone]:
        if agents is None:
            return list(self)
        if isinstance(agents, str | int):
            return [self[agents]]
        return [self[agent] for agent in agents]

    def _each(self, agents: Agents, do: Callable[[RadioDrone], None]) -> None:
        drones = self._some(agents)
        raise_together(in_parallel(drones, do), len(drones))

    def _tell(self, name: str, *arguments: object) -> None:
        call(getattr(self, name, None), *arguments)
