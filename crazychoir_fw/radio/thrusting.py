"""What set-points with a thrust share: newtons to counts, the lock of the thrust, and leveling out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import three
from crazychoir_fw.onboard.thrust import ThrustCalibration, ThrustWord, platform_weight
from crazychoir_fw.radio.agents import AgentId, Uris, agent_name, agents_of
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.handler import RadioHandler
from crazychoir_fw.radio.modes import Mode

_MIN_RAW = 1000  # the drone reads less as 0
_MAX_RAW = 60000  # and more as this
_MANUAL_MIN, _MANUAL_MAX = 10001, 60000  # 0 and 100 % of cflib's manual set-point
_SINKING = 0.95  # of the weight, where nothing on board knows the height


@dataclass(frozen=True)
class ThrustChoice:
    """The thrust of one drone."""

    calibration: ThrustCalibration
    weight: float | None
    """Weight (N), where it is known."""

    def raw(self, newtons: float) -> int:
        """Return the thrust of a packet, 0 or within [1000, 60000], for a thrust of all rotors (N)."""
        counts = int(self.calibration.counts(newtons) + 0.5)
        return min(counts, _MAX_RAW) if counts >= _MIN_RAW else 0


def thrust_choices(
    thrust: ThrustWord | Mapping[AgentId, ThrustWord],
    weight: float | Mapping[AgentId, float] | None,
    agents: Mapping[str, str],
) -> dict[str, ThrustChoice]:
    """Return the thrust of every agent.

    Raises:
        RangeError: If a word is none, or a weight is not above 0.
        UnknownNameError: If there is no such platform.
    """
    choices = {}
    for agent in agents:
        word = _of(thrust, agent, "cf2")
        heavy = _of(weight, agent, None)
        if heavy is None and isinstance(word, str):
            heavy = platform_weight(word)
        if heavy is not None and not heavy > 0.0:
            raise RangeError(f"{agent}: weight is {heavy!r}, allowed: a number above 0 (N)")
        choices[agent] = ThrustChoice(ThrustCalibration(word), heavy)
    return choices


def _of(value: Any, agent: str, default: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    return {agent_name(key): item for key, item in value.items()}.get(agent, default)


class ThrustDrone(RadioDrone):
    """A drone whose set-points have a thrust. It takes none before `takeoff`."""

    first_mode = Mode.LOCKED
    silences: ClassVar[tuple[str, ...]] = (*RadioDrone.silences, "level")
    thrust: ThrustChoice
    """How its thrust is calibrated; the handler sets it."""

    def takeoff(self, height: float | None = None, duration: float = 2.0) -> None:
        """Unlock the thrust, so that commands are taken; before that none is.

        Args:
            height: With a height (m, world), the planner on board climbs there first, which needs a position on
                board; commands are ignored until it is up. Without, the first command takes off.
            duration: Time to get there (s), above 0.

        Raises:
            RangeError: If a number is none, or leads out of the safety area.
            StateError: If the motors may not run, or `stop` is called meanwhile; the text says why.
            RadioError: If the drone is not connected.
        """
        if height is not None:
            height, duration = self._checked_climb("takeoff", height, duration)
            self._pose_cache.check_start(height)
        stops = self._flight.stops
        self.make_ready()
        # the drone ignores thrust until it has seen a thrust of zero
        self._sender.post(_send_zero)
        if height is not None:
            self._check_not_stopped(self._flight.take_off(height, duration, stops))
        else:
            self._check_not_stopped(self._flight.unlock(stops))

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> bool:
        """The same as a Twist: thrust (N) in linear z, the other three in angular."""
        _, _, f = three(self._call("cmd_vel"), "linear", linear)
        return self.command(f, *three(self._call("cmd_vel"), "angular", angular))

    def _send_level(self, cf: LinkedCrazyflie) -> None:
        counts = self.thrust.raw(_SINKING * (self.thrust.weight or 0.0))
        percent = 100.0 * (counts - _MANUAL_MIN) / (_MANUAL_MAX - _MANUAL_MIN)
        cf.commander.send_setpoint_manual(0.0, 0.0, 0.0, min(max(percent, 0.0), 100.0), False)


def _send_zero(cf: LinkedCrazyflie) -> None:
    cf.commander.send_setpoint(0.0, 0.0, 0.0, 0)


class ThrustHandler(RadioHandler):
    """What handlers have in common whose set-points have a thrust."""

    def __init__(
        self,
        uris: Uris,
        agent_ids: Iterable[AgentId] | None = None,
        *,
        thrust: ThrustWord | Mapping[AgentId, ThrustWord] = "cf2",
        weight: float | Mapping[AgentId, float] | None = None,
        **options: Any,
    ) -> None:
        """Prepare; `connect`, or a ``with`` statement, connects.

        Args:
            uris: URIs in a list, or by agent.
            agent_ids: Agents of a list of URIs.
            thrust: Calibration of the thrust, or one for each agent: see `ThrustCalibration`.
            weight: Weight (N), or one for each agent, for leveling out; that of the platform without.
            options: Limits of the class, and `Options`.

        Raises:
            RangeError: If a value is out of its range.
            UnknownNameError: If there is no such platform, agent or option.
        """
        agents = agents_of(uris, agent_ids)
        choices = thrust_choices(thrust, weight, agents)
        super().__init__(agents, **options)
        _check_weights(choices, self.options.on_silence)
        for drone in self:
            drone.thrust = choices[drone.agent_id]


def _check_weights(choices: Mapping[str, ThrustChoice], on_silence: str) -> None:
    """Refuse drones that are to level out with an unknown weight.

    Raises:
        RangeError: If there is one.
    """
    for agent, choice in choices.items():
        if on_silence == "level" and choice.weight is None:
            raise RangeError(f"{agent}: on_silence 'level' needs its weight (N), where thrust is not a platform")
