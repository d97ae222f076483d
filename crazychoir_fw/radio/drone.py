"""One drone of a handler, as its user sees it: how it is flown, whatever its set-points are."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RadioError, RangeError, StateError
from crazychoir_fw.common.finite import finite
from crazychoir_fw.radio.connection import BOOT_S, can_switch, power_cycle
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.flight import FlightState
from crazychoir_fw.radio.leaving import take_leave
from crazychoir_fw.radio.link import DroneLink, LinkState
from crazychoir_fw.radio.logs import LogValue
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.parameters import ParameterValue, get_parameter, set_parameters
from crazychoir_fw.radio.pose_cache import PoseCache
from crazychoir_fw.radio.poses import Odometry, PoseThrottle, usable_pose
from crazychoir_fw.radio.sender import Send, Sender
from crazychoir_fw.radio.supervisor import IS_FLYING, set_up, supervisor_bits
from crazychoir_fw.radio.telemetry import Telemetry


class RadioDrone:
    """One drone that is flown over the radio.

    All methods may be called from any thread. Packets leave through one thread per drone, in the order of the calls;
    callbacks come from cflib's thread of the drone, from that thread, or from the one that reconnects.
    """

    presets: ClassVar[Mapping[str, ParameterValue]] = {}
    """Parameters that these set-points need."""
    needs_position: ClassVar[bool] = False
    """Whether these set-points need a position on board, and so a Kalman filter that knows where it is."""
    first_mode: ClassVar[Mode] = Mode.READY
    silences: ClassVar[tuple[str, ...]] = ("hover", "land", "stop", "repeat", "nothing")
    """What these set-points can be followed by when they stop coming."""

    def __init__(
        self,
        agent_id: str,
        uri: str,
        options: Options,
        tell: Callable[..., None],
        own_parameters: Mapping[str, ParameterValue] | None = None,
    ) -> None:
        """The handler makes these.

        Args:
            agent_id: Name of the agent.
            uri: Where the drone is.
            options: What was chosen.
            tell: Called with the name of a callback and its arguments.
            own_parameters: Parameters of this very drone.
        """
        self.agent_id = agent_id
        self.uri = uri
        self.dropped_poses = 0
        """External poses without a body in them, which were not sent."""
        self._options = options
        self._tell = tell
        self._own_parameters = {**options.parameters, **(own_parameters or {})}
        self._clock = options.clock
        self._pose: tuple[Any, Any] | None = None
        self._throttle = PoseThrottle(options.pose_hz)
        self._link = DroneLink(self._who, uri, options, self._set_up, self._link_changed)
        self._sender = Sender(agent_id, self._link, options, self._tick)
        self._flight = FlightState(self._sender, options, self.first_mode, self._send_level, self._happened)
        self._pose_cache = PoseCache(self._who, options, self._sender, self._flight)
        self._telemetry = Telemetry(self._who, options, self._logged, self._moved, self._happened)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._who} {self._link.state}, {self._flight.mode}>"

    # ---------------------------------------------------------------- what it is like

    @property
    def cf(self) -> LinkedCrazyflie:
        """Cflib's object, for all that is not here; another one after each loss.

        Raises:
            RadioError: If the drone is not connected.
        """
        cf = self._link.cf
        if cf is None:
            because = f": {self._link.reason}" if self._link.reason else ""
            raise RadioError(f"{self._who}: not connected, the link is {self._link.state}{because}")
        return cf

    @property
    def link_state(self) -> LinkState:
        """How it is connected."""
        return self._link.state

    @property
    def is_connected(self) -> bool:
        """Whether packets reach it, as far as is known."""
        return self._link.is_connected

    @property
    def losses(self) -> int:
        """How often its link broke."""
        return self._link.losses

    @property
    def mode(self) -> Mode:
        """What it does with commands."""
        return self._flight.mode

    @property
    def is_stopped(self) -> bool:
        """Whether `stop` was called, by a caller or automatically, and `resume` was not."""
        return self._flight.mode is Mode.STOPPED

    @property
    def reason(self) -> str:
        """Why it is in this mode, where there is something to say."""
        return self._flight.reason

    @property
    def position(self) -> NDArray[np.float64] | None:
        """Last known position (m, world), shape (3,): by odometry or by an external pose, whichever came last."""
        return self._pose_cache.position

    @property
    def latest(self) -> dict[str, LogValue]:
        """The last value of every log variable, by ``group.name``."""
        return self._telemetry.latest

    @property
    def odometry(self) -> Odometry | None:
        """The last odometry, where it is logged."""
        return self._telemetry.odometry

    @property
    def link_latency_s(self) -> float:
        """Time to the drone and back (s), which 95 of the last 100 pings kept."""
        return self.cf.link_statistics.latency.latency / 1000.0

    # ---------------------------------------------------------------- flight

    def command(self, *values: float) -> bool:
        """Give a command; the classes of the handlers say what it is.

        Raises:
            StateError: If this class knows no commands.
        """
        del values
        raise StateError(f"{self._who}: this handler takes no commands")

    def cmd_vel(self, linear: Sequence[float], angular: Sequence[float]) -> bool:
        """Give a command in the vocabulary of a Twist, shape (3,) each.

        Raises:
            StateError: If this class knows no such command.
        """
        del linear, angular
        raise StateError(f"{self._who}: this handler takes no such commands")

    def takeoff(self, height: float = 0.5, duration: float = 2.0) -> None:
        """Take off by the planner on board, arming before where it must be; commands are ignored until it is up.

        Args:
            height: Height (m, world).
            duration: Time to get there (s), above 0.

        Raises:
            RangeError: If a number is none, or leads out of the safety area.
            StateError: If the motors may not run, or `stop` is called meanwhile; the text says why.
            RadioError: If the drone is not connected.
        """
        height, duration = self._checked_climb("takeoff", height, duration)
        self._pose_cache.check_start(height)
        stops = self._flight.stops
        self.make_ready()
        self._check_not_stopped(self._flight.take_off(height, duration, stops))

    def land(self, height: float = 0.0, duration: float = 2.0) -> None:
        """Land by the planner on board, from wherever it is; commands are ignored until `takeoff` or `resume`.

        It needs a position on board. A drone that does not fly, or is stopped, stays as it is.

        Args:
            height: Height of the floor (m, world).
            duration: Time to get there (s), above 0.

        Raises:
            RangeError: If a number is none.
            RadioError: If the drone is not connected.
        """
        height, duration = self._checked_climb("land", height, duration)
        flight = self._flight
        if not flight.is_active and flight.mode not in (Mode.STOPPED, Mode.LANDED) and self.is_flying:
            flight.is_active = True  # an earlier program left it in the air
        flight.land(height, duration)
        self._sender.outbox.wake()
        flight.emit()

    def stop(self, reason: str = "") -> None:
        """Stop the motors, and ignore commands until `resume`. A drone that was armed here is disarmed."""
        self._flight.stop(reason)
        self._sender.outbox.wake()
        self._flight.emit()

    def resume(self) -> None:
        """Take commands again, after `stop`, `land` or a loss; handlers that need `takeoff` first need it again."""
        self._flight.resume()

    def arm(self, armed: bool = True) -> None:
        """Arm or disarm, for drones that need it; `takeoff` does it as well.

        A drone out of reach is not armed later, when it comes back unexpectedly.

        Raises:
            RadioError: If the drone is not connected.
        """
        if not armed:
            self._flight.do_not_take_off()
        self._send_now(lambda cf: cf.supervisor.send_arming_request(armed))

    def recover(self) -> None:
        """Tell a drone that has crashed, and lies on its feet again, that it may fly.

        Raises:
            RadioError: If the drone is not connected.
        """
        self._send_now(lambda cf: cf.supervisor.send_crash_recovery_request())

    def reboot(self) -> None:
        """Switch a drone that stands off and on, and connect again; over ``radio://`` only. Takes about 10 s.

        Not from a callback. It takes commands again after `takeoff` or `resume`.

        Raises:
            StateError: If it flies, or this link cannot switch its power.
            RadioError: If its radio chip does not answer, or the drone does not come back.
        """
        if not can_switch(self.uri):
            raise StateError(f"{self._who}: its power can be switched over radio:// only")
        if self._link.is_connected and self.is_flying:
            raise StateError(f"{self._who}: it flies; it is rebooted on the floor")
        self._link.close()
        self._flight.restart()
        power_cycle(self._who, self.uri)
        time.sleep(BOOT_S)
        self.connect()

    def emergency_stop(self) -> None:
        """Stop the motors until the drone is restarted; nothing else brings it back.

        A drone out of reach gets the request as soon as it is reached again, even after calls of other methods.
        """
        self._flight.stop_for_good()
        self._sender.outbox.wake()

    def make_ready(self) -> None:
        """Wait until the motors may run, arming the drone where it must be.

        Raises:
            StateError: If they may not; the text says why.
            RadioError: If the drone is not connected.
        """
        self._flight.make_ready(self.cf, self._who)

    @property
    def is_flying(self) -> bool | None:
        """Whether it flies, by its supervisor; None when that does not say. Blocks up to 0.2 s."""
        bits = supervisor_bits(self.cf)
        return None if bits is None else bool(bits & IS_FLYING)

    # ---------------------------------------------------------------- poses and parameters

    def external_pose(self, position: Sequence[float], quat_xyzw: Sequence[float] | None = None) -> bool:
        """Forward a pose from outside to the estimator on board, at most `pose_hz` times per second.

        Samples without a body in them (not finite, or a quaternion of zeros) are dropped.

        Args:
            position: Position (m, world), shape (3,).
            quat_xyzw: Attitude, body to world, shape (4,); None forwards the position only.

        Returns:
            Whether it is sent.

        Raises:
            RangeError: If one has another shape.
        """
        pose = usable_pose(position, quat_xyzw)
        if pose is None:
            self.dropped_poses += 1
            return False
        now = self._clock()
        self._pose_cache.note(np.array(pose[0]), now)
        if not (self._options.forwards_poses and self._link.is_connected):
            return False
        with self._sender.lock:
            if not self._throttle.passes(now):
                return False
            self._pose = pose
        self._sender.outbox.wake()
        return True

    def set_parameter(self, name: str, value: ParameterValue) -> None:
        """Write a parameter, and wait until the drone has confirmed it. Not from a callback.

        Raises:
            UnknownNameError: If the drone has no such parameter.
            RangeError: If it can only be read, or the value does not fit.
            RadioError: If the drone is not connected, or does not confirm.
        """
        set_parameters(self.cf, self._who, {name: value}, self._options.confirm_timeout_s)

    def get_parameter(self, name: str) -> float | int:
        """Return the value of a parameter, as last received.

        Raises:
            UnknownNameError: If the drone has no such parameter.
            RadioError: If the drone is not connected.
        """
        return get_parameter(self.cf, self._who, name)

    # ---------------------------------------------------------------- life, for the handler

    def connect(self) -> None:
        """Connect; the handler calls this."""
        # cflib sets no parameter before it has read all of them
        self._sender.outbox.begin()
        self._link.connect(with_parameters=bool(self._presets() or self._own_parameters))

    def tick(self, now: float | None = None) -> float:
        """Send what is due, where no thread does, and return when to call again (s).

        Args:
            now: Ignored but for its type: time is that of the `clock` of the options.
        """
        del now
        return self._sender.outbox.run_once()

    def close(self) -> None:
        """Land or stop it, as `on_close` says, and close the link; the handler calls this."""
        if self._link.is_connected:
            with contextlib.suppress(RadioError):  # the link broke meanwhile
                tick = None if self._options.threaded else self.tick
                action, knows_position = self._options.on_close, self.needs_position or self._pose_cache.is_fresh
                take_leave(self._flight, self._sender, action, lambda: self.is_flying, knows_position, tick)
        self._sender.outbox.end()
        self._link.close()

    # ---------------------------------------------------------------- parts

    @property
    def _who(self) -> str:
        return f"{self.agent_id} ({self.uri})"

    def _call(self, name: str) -> str:
        return f"{self._who}: {name}"

    def _send_now(self, send: Send) -> None:
        """Send once, before any set-point; without a link there is an error instead of silence."""
        _ = self.cf
        self._sender.post(send)
        self._sender.outbox.wake()

    def _checked_climb(self, call: str, height: float, duration: float) -> tuple[float, float]:
        height, duration = finite(self._call(call), height=height, duration=duration)
        if not duration > 0.0:
            raise RangeError(f"{self._call(call)}: duration is {duration}, allowed: a number above 0 s")
        return height, duration

    def _check_not_stopped(self, is_taken: bool) -> None:
        if not is_taken:
            raise StateError(f"{self._call('takeoff')}: it was stopped meanwhile")

    def _presets(self) -> Mapping[str, ParameterValue]:
        return self.presets if self._options.presets else {}

    def _set_up(self, cf: LinkedCrazyflie, is_first: bool) -> None:
        options = self._options
        resets = self.needs_position and options.reset_estimator and options.presets
        own, timeout = self._own_parameters, options.confirm_timeout_s
        set_up(cf, self._who, self._presets(), own, timeout, resets_estimator=resets)
        self._sender.has_streamed = False
        self._telemetry.begin(cf)

    def _link_changed(self, state: LinkState, reason: str) -> None:
        if state is LinkState.LOST:
            self._flight.lose(reason)
        self._tell("on_state", self.agent_id, state, reason)

    def _logged(self, values: dict[str, float | int], time_s: float) -> None:
        self._tell("on_log", self.agent_id, values, time_s)

    def _moved(self, odometry: Odometry) -> None:
        self._pose_cache.note(odometry.position, odometry.received_s)
        self._tell("on_odometry", self.agent_id, odometry)

    def _happened(self, kind: str, text: str) -> None:
        self._tell("on_event", self.agent_id, kind, text)

    def _tick(self, now: float) -> float:
        with self._sender.lock:
            self._flight.go_on(now)
            send_set_point = self._sender.take_set_point(now)
            pose, self._pose = self._pose, None
        if pose is not None:
            self._sender.send(lambda cf: _send_pose(cf, *pose))
        if send_set_point is not None:
            send_set_point()
        self._flight.emit()
        look_again = self._telemetry.look(now) if self._link.is_connected else math.inf
        with self._sender.lock:
            return min(self._sender.next_set_point(), self._flight.due, look_again)

    def _send_level(self, cf: LinkedCrazyflie) -> None:
        """Send a level attitude with a thrust; only classes that know the thrust of a drone have one."""
        raise NotImplementedError


def _send_pose(cf: LinkedCrazyflie, position: Sequence[float], quat_xyzw: Sequence[float] | None) -> None:
    if quat_xyzw is None:
        cf.extpos.send_extpos(*position)
    else:
        cf.extpos.send_extpose(*position, *quat_xyzw)
