"""One drone of a handler: how it is flown, whatever its set-points are."""

from __future__ import annotations

import contextlib
import enum
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.errors import RadioError, RangeError, StateError
from crazychoir_fw.finite import finite
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.link import DroneLink, LinkState
from crazychoir_fw.radio.logs import DroneClock, LogBlock, LogValue, check_count, log_blocks, start_logs
from crazychoir_fw.radio.odometry import Odometry, odometry_reader
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.outbox import Outbox
from crazychoir_fw.radio.parameters import ParameterValue, get_parameter, set_parameters
from crazychoir_fw.radio.poses import PoseGate, usable_pose
from crazychoir_fw.radio.set_points import SetPointStream
from crazychoir_fw.radio.supervisor import CAN_BE_ARMED, IS_ARMED, IS_FLYING, make_ready, supervisor_bits

_DEFAULT_LOG = {"stabilizer.roll": 5.0, "stabilizer.pitch": 5.0, "stabilizer.yaw": 5.0}
_SAFETY_HZ = 10.0  # odometry for the safety area, when nobody else wants some
_FRESH_S = 1.0  # an older position says nothing about the safety area
_RESET_S = 0.1  # between both writes of a reset of the estimator
_LAND_EXTRA_S = 0.3  # the planner stops the motors a little after the end of its landing
_ARM_AGAIN_S = 1.0
_SETTLES_S = 0.15
_LAST_WORDS_S = 0.1  # cflib closes a radio link without waiting for what is still to be sent
_RESET = "kalman.resetEstimation"


class Mode(str, enum.Enum):
    """What a drone does with commands."""

    LOCKED = "locked"
    """It takes none before `takeoff`."""
    READY = "ready"
    """It takes commands."""
    TAKING_OFF = "taking off"
    """The planner on board flies; commands are ignored until it is up."""
    LANDING = "landing"
    """The planner on board flies; commands are ignored."""
    LANDED = "landed"
    """Commands are ignored until `takeoff` or `resume`."""
    STOPPED = "stopped"
    """Motors off; commands are ignored until `resume`."""
    LOST = "lost"
    """The link was lost; commands are ignored until `resume` or `takeoff`."""

    def __str__(self) -> str:
        return self.value


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
        self.latest: dict[str, LogValue] = {}
        """The last value of every log variable, by ``group.name``."""
        self.odometry: Odometry | None = None
        """The last odometry, where it is logged."""
        self.dropped_poses = 0
        """External poses without a body in them, which were not sent."""
        self._options = options
        self._tell = tell
        self._own_parameters = dict(own_parameters or {})
        self._clock = options.clock
        self._lock = threading.RLock()
        self._mode = self.first_mode
        self._mode_until = math.inf
        self._reason = ""
        self._is_active = False  # whether it may be in the air, because of us
        self._has_streamed = False  # whether our set-points hold the commander on board
        self._is_ready = False
        self._armed_here = False
        self._asked_to_arm = -math.inf
        self._disarmed_at = -math.inf  # by time.monotonic
        self._is_leveling = False
        self._is_outside = False
        self._position: tuple[float, NDArray[np.float64]] | None = None
        self._pose: tuple[Any, Any] | None = None
        self._gate = PoseGate(options.pose_hz)
        self._drone_clock = DroneClock()
        self._events: deque[tuple[str, str]] = deque()
        timeout = math.inf if options.on_silence == "repeat" else options.command_timeout_s
        self._stream = SetPointStream(options.keep_alive_hz, options.max_rate_hz, timeout)
        self._outbox = Outbox(f"radio-{agent_id}", self._tick, self._clock, options.threaded)
        self._link = DroneLink(self._who, uri, options, self._set_up, self._link_changed)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._who} {self._link.state}, {self._mode}>"

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
        return self._mode

    @property
    def is_stopped(self) -> bool:
        """Whether `stop` was called, by whomever, and `resume` was not."""
        return self._mode is Mode.STOPPED

    @property
    def reason(self) -> str:
        """Why it is in this mode, where there is something to say."""
        return self._reason

    @property
    def position(self) -> NDArray[np.float64] | None:
        """Last known position (m, world), shape (3,): by odometry or by an external pose, whichever came last."""
        known = self._position
        return known[1].copy() if known is not None else None

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
            StateError: If the motors may not run; the text says why.
            RadioError: If the drone is not connected.
        """
        height, duration = self._checked_climb("takeoff", height, duration)
        self._check_start(height)
        self.make_ready()
        self._take_off(height, duration)

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
        if not self._is_active and self._mode not in (Mode.STOPPED, Mode.LANDED) and self.is_flying:
            self._is_active = True  # an earlier program left it in the air
        self._land(height, duration, "")
        self._outbox.wake()
        self._emit()

    def stop(self, reason: str = "") -> None:
        """Stop the motors, and ignore commands until `resume`. A drone that was armed here is disarmed."""
        with self._lock:
            self._stop(reason)
        self._outbox.wake()
        self._emit()

    def resume(self) -> None:
        """Take commands again, after `stop`, `land` or a loss; handlers that need `takeoff` first need it again."""
        with self._lock:
            was = self._mode
            if was in (Mode.READY, Mode.TAKING_OFF):
                return
            self._become(self.first_mode)
            self._stream.clear()
            if was is not Mode.LOST:
                self._is_active = False
                # the planner, at rest, keeps the watchdog on board quiet until the next command
                self._outbox.post(self._release)
            self._is_ready = False
        self._outbox.wake()

    def arm(self, armed: bool = True) -> None:
        """Arm or disarm, for drones that need it; `takeoff` does it as well."""
        self._outbox.post(lambda: self._on_air(lambda cf: cf.supervisor.send_arming_request(armed)))
        self._outbox.wake()

    def recover(self) -> None:
        """Tell a drone that has crashed, and lies on its feet again, that it may fly."""
        self._outbox.post(lambda: self._on_air(lambda cf: cf.supervisor.send_crash_recovery_request()))
        self._outbox.wake()

    def emergency_stop(self) -> None:
        """Stop the motors until the drone is restarted; nothing else brings it back."""
        with self._lock:
            self._stop("emergency stop")
            self._outbox.post(lambda: self._on_air(lambda cf: cf.supervisor.send_emergency_stop()))
        self._outbox.wake()

    def make_ready(self) -> None:
        """Wait until the motors may run, arming the drone where it must be.

        Raises:
            StateError: If they may not; the text says why.
            RadioError: If the drone is not connected.
        """
        options = self._options
        # what was asked for a moment ago is not yet what the supervisor says
        time.sleep(max(0.0, self._disarmed_at + _SETTLES_S - time.monotonic()))
        armed = make_ready(self.cf, self._who, arms=options.arms, timeout_s=options.ready_timeout_s)
        with self._lock:
            self._armed_here |= armed
            self._is_ready = True

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
        self._is_at(np.array(pose[0]), now)
        if not (self._options.forwards_poses and self._link.is_connected):
            return False
        with self._lock:
            if not self._gate.passes(now):
                return False
            self._pose = pose
        self._outbox.wake()
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
        """Return the value of a parameter, as last heard of.

        Raises:
            UnknownNameError: If the drone has no such parameter.
            RadioError: If the drone is not connected.
        """
        return get_parameter(self.cf, self._who, name)

    # ---------------------------------------------------------------- life, for the handler

    def connect(self) -> None:
        """Connect; the handler calls this."""
        # cflib sets no parameter before it has read all of them
        self._outbox.begin()
        self._link.connect(with_parameters=bool(self._parameters()))

    def tick(self, now: float | None = None) -> float:
        """Send what is due, where no thread does, and return when to call again (s).

        Args:
            now: Ignored but for its type: time is that of the `clock` of the options.
        """
        del now
        return self._outbox.run_once()

    def close(self) -> None:
        """Land or stop it, as `on_close` says, and close the link; the handler calls this."""
        if self._link.is_connected:
            with contextlib.suppress(RadioError):  # the link broke meanwhile
                self._finish()
        self._outbox.end()
        self._link.close()

    def _finish(self) -> None:
        action = self._options.on_close
        flies = self._is_active and self._mode in (Mode.READY, Mode.TAKING_OFF, Mode.LOST, Mode.LANDING)
        if flies and self.is_flying is False:
            flies = False
        if action == "leave" and flies:
            return
        if flies and action == "land":
            if self._mode is not Mode.LANDING:
                self.land()
            self._wait_for_landing()
        elif flies:
            self.stop("closed")
            self._outbox.flush(_LAST_WORDS_S)
            time.sleep(_LAST_WORDS_S)
        with self._lock:
            self._stream.clear()
        # for the next program: without it the last set-point here would keep the planner on board from flying
        self._outbox.post(self._release)
        self._outbox.flush(_LAST_WORDS_S)
        time.sleep(_LAST_WORDS_S)

    def _wait_for_landing(self) -> None:
        began = time.monotonic()
        while self._mode is Mode.LANDING and self._link.is_connected and time.monotonic() - began < 10.0:
            if not self._options.threaded:
                self.tick()
            time.sleep(0.05)

    # ---------------------------------------------------------------- parts

    @property
    def _who(self) -> str:
        return f"{self.agent_id} ({self.uri})"

    def _call(self, name: str) -> str:
        return f"{self._who}: {name}"

    def _parameters(self) -> dict[str, ParameterValue]:
        own = {**self._options.parameters, **self._own_parameters}
        return {**(self.presets if self._options.presets else {}), **own}

    def _set_up(self, cf: LinkedCrazyflie, is_first: bool) -> None:
        options = self._options
        bits = supervisor_bits(cf)
        is_flying = bits is not None and bool(bits & IS_FLYING)
        own = {**options.parameters, **self._own_parameters}
        if options.presets:
            preset = {name: value for name, value in self.presets.items() if name not in own}
            set_parameters(cf, self._who, preset, options.confirm_timeout_s, optional=True)
        set_parameters(cf, self._who, own, options.confirm_timeout_s)
        if not is_flying:
            if self.needs_position and options.reset_estimator and options.presets:
                for value in (1, 0):
                    set_parameters(cf, self._who, {_RESET: value}, options.confirm_timeout_s, optional=True)
                    time.sleep(_RESET_S)
            # whatever program was connected before: its last set-point no longer keeps the planner from flying
            cf.commander.send_notify_setpoint_stop()
        with self._lock:
            self._drone_clock = DroneClock()
            self._has_streamed = False
        if options.logger:
            self._start_logs(cf)

    def _start_logs(self, cf: LinkedCrazyflie) -> None:
        options = self._options
        wanted = _DEFAULT_LOG if options.log is None else options.log
        blocks = log_blocks(self._who, wanted, cf.log.toc)
        odometry_hz = options.odometry_hz
        if options.safety_area is not None:
            odometry_hz = max(odometry_hz, _SAFETY_HZ)
        extra: list[LogBlock] = []
        names, read = odometry_reader(cf.log.toc)
        if odometry_hz > 0.0:
            extra = log_blocks(self._who, dict.fromkeys(names, odometry_hz), cf.log.toc)
        check_count(self._who, [*blocks, *extra])
        start_logs(cf, self._who, blocks, self._logged, options.confirm_timeout_s)
        start_logs(
            cf, self._who, extra, lambda stamp, values: self._moved(stamp, values, read), options.confirm_timeout_s
        )

    def _logged(self, stamp_ms: int, values: dict[str, float | int]) -> float:
        time_s, received_s = self._drone_clock.seconds(stamp_ms), self._clock()
        self.latest.update({name: LogValue(value, time_s, received_s) for name, value in values.items()})
        self._tell("on_log", self.agent_id, values, time_s)
        return time_s

    def _moved(
        self,
        stamp_ms: int,
        values: dict[str, float | int],
        read: Callable[[Mapping[str, float], float, float], Odometry],
    ) -> None:
        odometry = read(values, self._drone_clock.seconds(stamp_ms), self._clock())
        self.odometry = odometry
        self._is_at(odometry.position, odometry.received_s)
        self._tell("on_odometry", self.agent_id, odometry)

    def _link_changed(self, state: LinkState, reason: str) -> None:
        if state is LinkState.LOST:
            with self._lock:
                policy = self._options.reconnect
                self._outbox.drop_posted()
                self._stream.clear()
                self._is_ready = False
                self._has_streamed = False
                resumes = policy is not None and policy.resumes and self._mode is Mode.READY
                if not resumes and self._mode is not Mode.STOPPED:
                    self._become(Mode.LOST, reason)
        self._tell("on_state", self.agent_id, state, reason)

    # ---------------------------------------------------------------- set-points

    def _give(self, send: Callable[[LinkedCrazyflie], None]) -> bool:
        """Take a set-point, if the drone takes commands now."""
        with self._lock:
            if self._mode is not Mode.READY or not self._link.is_connected:
                return False
            self._is_active = True
            self._is_leveling = False
            self._stream.give(lambda: self._stream_out(send), self._clock())
        self._outbox.wake()
        return True

    def _stream_out(self, send: Callable[[LinkedCrazyflie], None]) -> None:
        self._has_streamed = True
        self._on_air(send)

    def _on_air(self, send: Callable[[LinkedCrazyflie], None]) -> None:
        cf = self._link.cf
        if cf is not None:
            send(cf)

    def _tick(self, now: float) -> float:
        with self._lock:
            if now >= self._mode_until:
                self._mode_ends()
            if self._stream.is_stale(now):
                self._fall_silent(now)
            send = self._stream.take(now) if self._link.is_connected else None
            pose, self._pose = self._pose, None
        if pose is not None:
            self._on_air(lambda cf: _send_pose(cf, *pose))
        if send is not None:
            send()
        self._emit()
        with self._lock:
            due = self._stream.due() if self._link.is_connected else math.inf
            return min(due, self._mode_until)

    def _fall_silent(self, now: float) -> None:
        """Nobody commands any more."""
        what = self._options.on_silence
        if self._is_leveling:
            self._stop("no command")
            return
        text = f"no command for {self._options.command_timeout_s:g} s: {what}"
        self._events.append(("silence", text))
        if what == "hover":
            self._stream.give(lambda: self._stream_out(_send_hover), now, math.inf)
        elif what == "level":
            self._is_leveling = True
            self._stream.give(lambda: self._stream_out(self._send_level), now, self._options.level_s)
        elif what == "land":
            self._land(0.0, 2.0, text)
        elif what == "stop":
            self._stop(text)
        else:
            self._stream.clear()

    def _send_level(self, cf: LinkedCrazyflie) -> None:
        """Send a level attitude with a thrust; only classes that know the thrust of a drone have one."""
        raise NotImplementedError

    def _arm_in_passing(self) -> None:
        """Arm a drone that is commanded without a take-off, without keeping the caller waiting."""
        now = self._clock()
        with self._lock:
            if self._is_ready or not self._options.arms or now - self._asked_to_arm < _ARM_AGAIN_S:
                return
            self._asked_to_arm = now
        self._outbox.post(lambda: self._on_air(self._arm_if_needed))
        self._outbox.wake()

    def _arm_if_needed(self, cf: LinkedCrazyflie) -> None:
        bits = supervisor_bits(cf)
        if bits is None:
            return
        if bits & IS_ARMED:
            self._is_ready = True
        elif bits & CAN_BE_ARMED:
            self._armed_here = True
            cf.supervisor.send_arming_request(True)

    # ---------------------------------------------------------------- modes

    def _become(self, mode: Mode, reason: str = "", until: float = math.inf) -> None:
        self._mode, self._reason, self._mode_until = mode, reason, until
        self._is_leveling = False

    def _mode_ends(self) -> None:
        if self._mode is Mode.TAKING_OFF:
            self._become(Mode.READY)
        elif self._mode is Mode.LANDING:
            self._become(Mode.LANDED, self._reason)
            self._is_active = False
            if self._armed_here:
                self._armed_here = self._is_ready = False
                self._outbox.post(lambda: self._on_air(self._disarm))
        else:
            self._mode_until = math.inf

    def _take_off(self, height: float, duration: float) -> None:
        with self._lock:
            self._stream.clear()
            self._is_active = True
            self._become(Mode.TAKING_OFF, until=self._clock() + duration)
        self._outbox.post(
            self._release,
            # with the heading that it stands in
            lambda: self._on_air(lambda cf: cf.high_level_commander.takeoff(height, duration, yaw=None)),
        )
        self._outbox.wake()

    def _land(self, height: float, duration: float, reason: str) -> None:
        with self._lock:
            if self._mode in (Mode.STOPPED, Mode.LANDING, Mode.LANDED) or not self._is_active:
                return
            self._outbox.drop_posted()
            self._stream.clear()
            self._become(Mode.LANDING, reason, self._clock() + duration + _LAND_EXTRA_S)
        # both in one go: between them the motors stand still
        self._outbox.post(lambda: self._hand_over(height, duration))

    def _hand_over(self, height: float, duration: float) -> None:
        self._release_if_streamed()
        self._on_air(lambda cf: cf.high_level_commander.land(height, duration, yaw=None))

    def _release(self) -> None:
        self._has_streamed = False
        self._on_air(lambda cf: cf.commander.send_notify_setpoint_stop())

    def _release_if_streamed(self) -> None:
        if self._has_streamed:
            self._release()

    def _stop(self, reason: str) -> None:
        self._outbox.drop_posted()
        self._become(Mode.STOPPED, reason)
        self._is_active = False
        self._is_ready = False
        # again and again, so that it also reaches a drone that was out of reach, and nobody else's set-point counts
        self._stream.give(lambda: self._stream_out(_send_stop), self._clock(), math.inf)
        self._outbox.post(lambda: self._on_air(self._send_last))

    def _send_last(self, cf: LinkedCrazyflie) -> None:
        cf.commander.send_stop_setpoint()
        cf.high_level_commander.stop()
        if self._armed_here:
            self._armed_here = False
            self._disarm(cf)

    def _disarm(self, cf: LinkedCrazyflie) -> None:
        cf.supervisor.send_arming_request(False)
        self._disarmed_at = time.monotonic()

    # ---------------------------------------------------------------- safety area

    def _is_at(self, position: NDArray[np.float64], now: float) -> None:
        """Remember where it is, and act when that is outside."""
        self._position = (now, position)
        area = self._options.safety_area
        was_outside, self._is_outside = self._is_outside, area is not None and not area.contains(position, area.margin)
        if area is None or not self._is_outside:
            return
        with self._lock:
            if not self._is_active or self._mode not in (Mode.READY, Mode.TAKING_OFF):
                return
            where = ", ".join(f"{value:.2f}" for value in position)
            text = f"at ({where}), outside of the safety area {area}"
            if area.breach == "stop":
                self._stop(text)
            elif area.breach == "land":
                self._land(0.0, 2.0, text)
            elif was_outside:  # reported when it left
                return
            self._events.append(("safety_area", text))
        self._outbox.wake()
        self._emit()

    def _inside(self, velocity: Sequence[float]) -> Sequence[float]:
        """Bend a velocity (m/s, world) at the border of the safety area; without knowing where, stand still."""
        area, known = self._options.safety_area, self._position
        if area is None or known is None:
            return velocity
        if self._clock() - known[0] > _FRESH_S:
            return (0.0, 0.0, 0.0)
        return area.velocity(known[1], velocity)

    def _check_start(self, height: float) -> None:
        area, known = self._options.safety_area, self._position
        if area is None:
            return
        x, y, z = known[1].tolist() if known is not None else (None, None, None)
        if known is not None and not area.contains((x, y, max(z, area.low[2])), area.margin):
            raise RangeError(f"{self._who}: takeoff: ({x:.2f}, {y:.2f}) is outside of the safety area {area}")
        if not area.low[2] <= height <= area.high[2]:
            raise RangeError(f"{self._who}: takeoff: height {height:g} m is outside of the safety area {area}")

    def _checked_climb(self, call: str, height: float, duration: float) -> tuple[float, float]:
        height, duration = finite(self._call(call), height=height, duration=duration)
        if not duration > 0.0:
            raise RangeError(f"{self._call(call)}: duration is {duration}, allowed: a number above 0 s")
        return height, duration

    def _emit(self) -> None:
        """Tell what happened, outside of the lock."""
        while self._events:
            kind, text = self._events.popleft()
            self._tell("on_event", self.agent_id, kind, text)


def _send_hover(cf: LinkedCrazyflie) -> None:
    cf.commander.send_velocity_world_setpoint(0.0, 0.0, 0.0, 0.0)


def _send_stop(cf: LinkedCrazyflie) -> None:
    cf.commander.send_stop_setpoint()


def _send_pose(cf: LinkedCrazyflie, position: Sequence[float], quat_xyzw: Sequence[float] | None) -> None:
    if quat_xyzw is None:
        cf.extpos.send_extpos(*position)
    else:
        cf.extpos.send_extpose(*position, *quat_xyzw)
