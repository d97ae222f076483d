"""`HardwareBackend`: drones over the radio, in the time of the clock on the wall; real ones, or a served simulation."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.flight.backend import Indices, WallPace, one_of
from crazychoir_fw.flight.plain_recorder import PlainRecorder

if TYPE_CHECKING:
    from crazychoir_fw.radio import RadioHandler
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.log_stream import LogStream

Array = NDArray[np.float64]

STALE_S = 0.5
"""Age (s) at which the pose of a drone counts as unknown: it gets no commands then, and its handler takes over."""

SUPERVISOR = "supervisor.info"
_BATTERY = "pm.vbat"
_WATCHED = {SUPERVISOR: 10.0, _BATTERY: 1.0}  # [Hz]
_ENDS = {1 << 5: "tumbled", 1 << 6: "locked up", 1 << 7: "crashed"}
"""Bits of the supervisor that end a flight."""

_HANDLERS = {
    "fpqr": "RadioHandlerFPQR",
    "frpy": "RadioHandlerFRPY",
    "vel": "RadioHandlerVel",
    "xyz": "RadioHandlerXYZ",
}


def _is_news(record: logging.LogRecord) -> bool:
    """Whether cflib logs what the handler does not tell: links that fail are sentences of it, without a traceback."""
    return not str(record.msg).startswith(("Got link error callback", "Couldn't load link driver"))


class HardwareBackend:
    """One radio handler flies all drones; poses are the estimates that the drones log."""

    is_real_time = True

    def __init__(
        self,
        uris: Mapping[str, str],
        kind: str,
        *,
        masses: ArrayLike = 0.029,
        odometry_hz: float = 100.0,
        sleep: Callable[[float], None] = time.sleep,
        connects: bool = True,
        **options: Any,
    ) -> None:
        """Connect to the drones.

        Args:
            uris: Where the drones are, by name.
            kind: What they are commanded by: ``fpqr``, ``frpy``, ``vel`` or ``xyz``.
            masses: What they weigh (kg), a number or shape (N,).
            odometry_hz: Rate at which they log their poses (Hz).
            sleep: Lets time go on (s); a test that steps a served world puts its own here, with `clock`.
            connects: False leaves it to the caller to connect `handler`.
            options: Of the handler, see `crazychoir_fw.radio.Options`; ``thrust`` too.

        Raises:
            RangeError: If the kind is none of these, or an option is out of range.
            RadioError: If drones are not reached.
        """
        from crazychoir_fw import radio

        if kind not in _HANDLERS:
            raise RangeError(f"kind is {kind!r}, allowed: {', '.join(_HANDLERS)}")
        logging.getLogger("cflib.crazyflie").addFilter(_is_news)
        self.names = list(uris)
        self.masses = np.broadcast_to(np.asarray(masses, float), (len(self.names),)).copy()
        self.kind = kind
        options.setdefault("log", dict(_WATCHED))
        self.handler: RadioHandler = getattr(radio, _HANDLERS[kind])(dict(uris), odometry_hz=odometry_hz, **options)
        self._drones = list(self.handler)
        self._clock = self.handler.options.clock
        self._sleep = sleep
        self._start = self._clock()
        self.pace = WallPace(self._clock, sleep)
        """What rounds wait for."""
        self._recorder = PlainRecorder(self.names)
        self._refusals: dict[int, str] = {}
        self.before_flight: Callable[..., None] = lambda **_: None
        self.radio_parts: list[tuple[list[int], Any]] = []  # numbers of drones in the mission, and their commander
        """Called before the first phase of a mission; what it raises keeps the drones on the floor."""
        self.when_closed: list[Callable[[], object]] = []
        """Called when the drones are let go."""
        if connects:
            self.handler.connect()
            self._start = self._clock()
            self.pace.begin_anew()

    @property
    def time(self) -> float:
        """See `Backend`."""
        return self._clock() - self._start

    def poses(self) -> Pose:
        """See `Backend`."""
        count, now = len(self._drones), self._clock()
        position, velocity, angular = np.full((count, 3), np.nan), np.zeros((count, 3)), np.zeros((count, 3))
        orientation = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
        for i, drone in enumerate(self._drones):
            seen = drone.odometry
            if seen is not None and now - seen.received_s < STALE_S:
                position[i], orientation[i] = seen.position, seen.quat_xyzw
                velocity[i], angular[i] = seen.velocity, seen.body_rates
        return Pose(position, orientation, velocity, angular, now - self._start)

    def wait_for_poses(self, timeout_s: float = 5.0) -> None:
        """Wait until all drones have said where they are.

        Raises:
            RadioError: If some have not in time; the text names them.
        """
        from crazychoir_fw.common.errors import RadioError

        silent = self._silent_after(timeout_s, range(len(self.names)))
        if silent:
            names = ", ".join(self.names[i] for i in silent)
            raise RadioError(f"{names}: no pose within {timeout_s:g} s; is there a positioning system?")
        self.pace.begin_anew()

    def simulated_names(self) -> list[str | None]:
        """Return the name that each drone of a served simulation says, None for those that are real."""
        from crazychoir_fw.radio.identity import simulated_name

        return [simulated_name(drone.cf) for drone in self._drones]

    def batteries(self, timeout_s: float = 2.0) -> Array:
        """Return the voltages of the batteries (V), shape (N,), NaN where a drone does not say in time."""
        self.wait_until(lambda: all(_BATTERY in drone.latest for drone in self._drones), timeout_s)
        seen = [drone.latest.get(_BATTERY) for drone in self._drones]
        return np.array([np.nan if one is None else one.value for one in seen], float)

    def grounded(self) -> list[str | None]:
        """Return why the supervisor of each drone keeps its motors off until a person helps, or None."""
        from crazychoir_fw.radio.supervisor import NEEDS_A_HAND, supervisor_bits, why_grounded

        bits = [supervisor_bits(drone.cf) for drone in self._drones]
        return [None if one is None or not one & NEEDS_A_HAND else why_grounded(one, True) for one in bits]

    def _silent_after(self, timeout_s: float, indices: Indices) -> list[int]:
        """Wait until some drones have said where they are; returns those that have not in time."""
        silent: list[int] = []

        def are_heard() -> bool:
            unknown = np.isnan(self.poses().position[:, 0])
            silent[:] = [int(i) for i in indices if unknown[i]]
            return not silent

        self.wait_until(are_heard, timeout_s)
        return silent

    def wait_until(self, holds: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until something holds; returns whether it did in time."""
        deadline = self._clock() + timeout_s
        while not holds():
            if self._clock() >= deadline:
                return False
            self._sleep(0.02)
        return True

    def pose_of(self, index: int) -> Pose:
        """See `Backend`."""
        return one_of(self.poses(), index)

    def true_positions(self) -> Array:
        """See `Backend`: what the drones believe."""
        return self.poses().position

    def unlock(self, indices: Indices) -> list[int]:
        """See `Backend`; takes some seconds with drones that have just started."""
        from crazychoir_fw.radio.threads import in_parallel

        def make_ready(drone: Any) -> None:
            drone.resume()
            if self.kind in ("fpqr", "frpy"):
                drone.takeoff()
            else:
                drone.make_ready()

        chosen = {self._drones[i].agent_id: int(i) for i in indices}
        for i in chosen.values():  # another attempt
            self._refusals.pop(i, None)
        refused = in_parallel([self._drones[i] for i in indices], make_ready)
        for drone, error in refused:
            if not isinstance(error, CrazychoirError):
                raise error
            self._refusals[chosen[drone.agent_id]] = str(error)
        # a machine that has other work may not have come to read all that they say
        self._silent_after(STALE_S, indices)
        self.pace.begin_anew()
        return [chosen[drone.agent_id] for drone, _ in refused]

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """See `Backend`.

        Raises:
            RangeError: If the kind is another than that of the handler, or a number is not finite.
        """
        if kind != self.kind:
            raise RangeError(f"kind is {kind!r}, allowed: {self.kind}, which the handler was made for")
        for k, i in enumerate(indices):
            self._drones[i].cmd_vel(twist.linear[k], twist.angular[k])

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """See `Backend`."""
        self._drones[index].command(*(float(v) for v in point.position), float(point.time_s))  # type: ignore[call-arg]

    def land(self, index: int, floor: float, seconds: float) -> None:
        """See `Backend`: by the planner on board, whatever the drone was commanded by."""
        self._drones[index].land(floor, seconds)

    def advance(self, seconds: float) -> None:
        """See `Backend`."""
        self.pace.wait(seconds)

    def stop(self, indices: Indices) -> None:
        """See `Backend`."""
        for i in indices:
            self._drones[i].stop()

    def failures(self) -> dict[int, str]:
        """See `Backend`."""
        found = dict(self._refusals)
        for i, drone in enumerate(self._drones):
            if not drone.is_connected:
                found.setdefault(i, f"{self.names[i]}: the link was lost")
                continue
            seen = drone.latest.get(SUPERVISOR)
            if seen is not None and self._clock() - seen.received_s < STALE_S:
                for bit, what in _ENDS.items():
                    if int(seen.value) & bit:
                        found.setdefault(i, f"{self.names[i]}: {what} at {self.time:.2f} s")
        return found

    def record(self, extra: dict[str, Array]) -> None:
        """See `Backend`."""
        self._recorder.sample(self.time, self.poses(), None, extra)

    def write_to(self, stream: LogStream, metadata: dict[str, Any]) -> None:
        """See `Backend`."""
        self._recorder.write_to(stream, metadata)

    def flush(self) -> None:
        """See `Backend`."""
        self._recorder.flush()

    def log(self, metadata: dict[str, Any]) -> FlightLog:
        """See `Backend`."""
        return self._recorder.finish(metadata)

    def close(self) -> None:
        """See `Backend`: those that fly land or stop, as the option `on_close` says."""
        self.handler.close()
        for call in self.when_closed:
            call()
