"""The flight of one drone: in which mode it is, what leads to the next one, and which packets that takes."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.liftoff import Liftoff
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.sender import Send, Sender
from crazychoir_fw.radio.supervisor import (
    CAN_BE_ARMED,
    CAN_FLY,
    IS_ARMED,
    IS_AUTO_ARMED,
    NEEDS_A_HAND,
    follows_planner,
    make_ready,
    supervisor_bits,
    why_grounded,
)

_LAND_S = 2.0  # where no duration is given
_LAND_EXTRA_S = 0.3  # the planner stops the motors a little after the end of its landing
_ARM_AGAIN_S = 1.0
_SETTLES_S = 0.15
_AGAIN_S = 0.1


class FlightState:
    """Modes change under the lock of the sender, from any thread; packets are only posted there.

    Args:
        sender: The way to the drone.
        options: Time-outs, what follows silence.
        first_mode: The mode before any flight.
        level: Sends a level attitude with a thrust, for drones that know theirs.
        tell: Called with kind and text of what happened, outside of the lock.
    """

    def __init__(
        self, sender: Sender, options: Options, first_mode: Mode, level: Send, tell: Callable[[str, str], None]
    ) -> None:
        self._sender = sender
        self._lock = sender.lock
        self._options = options
        self._clock = options.clock
        self._first_mode = first_mode
        self._level = level
        self._tell = tell
        self._events: deque[tuple[str, str]] = deque()
        self._asked_to_arm = -math.inf
        self._disarmed_at = -math.inf  # by time.monotonic
        self._armed_here = False
        self._is_leveling = False
        self._emergency_stop_due = math.inf
        self._liftoff = Liftoff(options.ready_timeout_s)
        self.mode = first_mode
        self.reason = ""
        """Why it is in this mode, where there is something to say."""
        self.mode_until = math.inf
        """When the mode ends by itself (s)."""
        self.is_active = False
        """Whether the drone may be in the air, because of us."""
        self.is_ready = False
        """Whether its motors may run, as far as is known."""
        self.stops = 0
        """How often it was stopped."""

    # ---------------------------------------------------------------- commands

    def give(self, send: Send) -> bool:
        """Take a set-point, if the drone takes commands now."""
        with self._lock:
            if self.mode is not Mode.READY or not self._sender.is_connected:
                return False
            self.is_active = True
            self._is_leveling = False
            self._sender.repeat(send, self._clock())
        self._sender.outbox.wake()
        return True

    def send_goal(self, send: Send) -> bool:
        """Have something sent once for the planner on board, if the drone takes commands now."""
        with self._lock:
            if self.mode is not Mode.READY:
                return False
            self.is_active = True
            self._liftoff.expect(lambda: self._sender.post(send), self._clock())
        self._sender.post(send)
        self._sender.outbox.wake()
        return True

    def unlock(self, stops: int) -> bool:
        """Take commands, without a take-off; see `take_off`."""
        with self._lock:
            if self._was_stopped_since(stops):
                return False
            self._sender.stream.clear()
            self._sender.has_streamed = True  # the zero thrust
            self._become(Mode.READY)
        self._sender.outbox.wake()
        return True

    def take_off(self, height: float, duration: float, stops: int) -> bool:
        """Have the planner on board climb.

        Args:
            height: Height (m, world).
            duration: Time to get there (s).
            stops: How often the drone had been stopped when the take-off was asked for.

        Returns:
            False when it was stopped since then, while it was made ready; then nothing happens.
        """

        def climb(cf: LinkedCrazyflie) -> None:
            # with the heading that it stands in
            cf.high_level_commander.takeoff(height, duration, yaw=None)

        def climb_again() -> None:
            if self.mode is Mode.TAKING_OFF:
                self.mode_until = self._clock() + duration
                self._sender.post(climb)

        with self._lock:
            if self._was_stopped_since(stops):
                return False
            self._sender.stream.clear()
            self.is_active = True
            self._become(Mode.TAKING_OFF, until=self._clock() + duration)
            self._liftoff.expect(climb_again, self._clock())
        self._sender.post(self._sender.release, climb)
        self._sender.outbox.wake()
        return True

    def _was_stopped_since(self, stops: int) -> bool:
        if self.stops == stops:
            return False
        if self._armed_here:  # after the stop
            self._armed_here = self.is_ready = False
            self._sender.post(self._disarm)
        return True

    def land(self, height: float = 0.0, duration: float = _LAND_S, reason: str = "") -> None:
        """Have the planner on board land at a height (m, world), in a time (s); the caller wakes the outbox."""
        with self._lock:
            if self.mode in (Mode.STOPPED, Mode.LANDING, Mode.LANDED) or not self.is_active:
                return
            self._sender.forget()
            self._become(Mode.LANDING, reason, self._clock() + duration + _LAND_EXTRA_S)

        def hand_over(cf: LinkedCrazyflie) -> None:
            # both in one go: between them the motors stand still
            self._sender.release_if_streamed(cf)
            cf.high_level_commander.land(height, duration, yaw=None)

        self._sender.post(hand_over)

    def level_out(self) -> None:
        """Sink with a level attitude for `level_s`, then stop the motors; the caller wakes the outbox."""
        with self._lock:
            if self.mode in (Mode.STOPPED, Mode.LANDED) or not self.is_active:
                return
            self._sender.forget()
            self._become(Mode.LANDING)
            self._begin_to_level(self._clock())

    def _begin_to_level(self, now: float) -> None:
        self._is_leveling = True
        self._sender.repeat(self._level, now, self._options.level_s)

    def stop_for_good(self) -> None:
        """Stop the motors until the drone is restarted; the caller wakes the outbox."""
        with self._lock:
            self._emergency_stop_due = self._clock()
            self.stop("emergency stop")

    def stop(self, reason: str = "") -> None:
        """Stop the motors, again and again until `resume`; the caller wakes the outbox."""
        with self._lock:
            self._sender.outbox.drop_posted()
            self._become(Mode.STOPPED, reason)
            self.stops += 1
            self.is_active = self.is_ready = False
            # so that it also reaches a drone that was out of reach, and no other set-point counts
            self._sender.repeat(_send_stop, self._clock(), math.inf)
            self._sender.post(self._send_last)

    def resume(self) -> None:
        """Take commands again, after a stop, a landing or a loss."""
        with self._lock:
            was = self.mode
            if was in (Mode.READY, Mode.TAKING_OFF):
                return
            self._become(self._first_mode)
            self._sender.stream.clear()
            if was is not Mode.LOST:
                self.is_active = False
                # the planner, at rest, keeps the watchdog on board quiet until the next command
                self._sender.post(self._sender.release)
            self.is_ready = False
        self._sender.outbox.wake()

    # ---------------------------------------------------------------- what happens by itself

    def go_on(self, now: float) -> None:
        """Do what time brings: the end of a mode, and silence; with the lock."""
        if now >= self._emergency_stop_due and self._sender.is_connected:
            self._emergency_stop_due = now + _AGAIN_S  # unless it gets through
            self._sender.post(self._send_emergency_stop)
        if now >= self._liftoff.due:
            self._liftoff.due = math.inf  # until it has looked
            self._sender.post(self._see_off)
        if now >= self.mode_until:
            self._end_mode()
        if self._sender.stream.is_stale(now):
            self._fall_silent(now)

    @property
    def due(self) -> float:
        """When time brings something next (s)."""
        return min(self.mode_until, self._liftoff.due)

    def lose(self, reason: str) -> None:
        """The link is lost."""
        with self._lock:
            policy = self._options.reconnect
            if self.mode is Mode.STOPPED:
                # the link may have been broken before the stop was through: it goes on when the drone is back
                self._sender.outbox.drop_posted()
            else:
                self._sender.forget()
            self.is_ready = False
            self._sender.has_streamed = False
            resumes = policy is not None and policy.resumes and self.mode is Mode.READY
            if not resumes and self.mode is not Mode.STOPPED:
                self._become(Mode.LOST, reason)

    def restart(self) -> None:
        """The drone has restarted, and knows nothing of what was sent before."""
        with self._lock:
            self._sender.forget()
            self.is_active = self.is_ready = self._armed_here = False
            self._emergency_stop_due = math.inf
            self._sender.has_streamed = False
            self._become(Mode.LOST, "restarted")

    def note(self, kind: str, text: str) -> None:
        """Remember what happened, for the next `emit`."""
        self._events.append((kind, text))

    def emit(self) -> None:
        """Tell what happened; without the lock."""
        while self._events:
            self._tell(*self._events.popleft())

    def _become(self, mode: Mode, reason: str = "", until: float = math.inf) -> None:
        self.mode, self.reason, self.mode_until = mode, reason, until
        self._is_leveling = False
        if mode not in (Mode.READY, Mode.TAKING_OFF):
            self._liftoff.forget()

    def _end_mode(self) -> None:
        if self.mode is Mode.TAKING_OFF:
            self._become(Mode.READY)
        elif self.mode is Mode.LANDING:
            self._become(Mode.LANDED, self.reason)
            self.is_active = False
            if self._armed_here:
                self._armed_here = self.is_ready = False
                self._sender.post(self._disarm)
        else:
            self.mode_until = math.inf

    def _fall_silent(self, now: float) -> None:
        """Handle the command timeout."""
        what = self._options.on_silence
        if self._is_leveling:
            self.stop("no command")
            return
        text = f"no command for {self._options.command_timeout_s:g} s: {what}"
        self.note("silence", text)
        if what == "hover":
            self._sender.repeat(_send_hover, now, math.inf)
        elif what == "level":
            self._begin_to_level(now)
        elif what == "land":
            self.land(reason=text)
        elif what == "stop":
            self.stop(text)
        else:
            self._sender.stream.clear()

    # ---------------------------------------------------------------- arming

    def make_ready(self, cf: LinkedCrazyflie, who: str) -> None:
        """Wait until the motors may run, arming the drone where it must be; see `supervisor.make_ready`."""
        options = self._options
        # the supervisor reports a disarm only after a delay
        time.sleep(max(0.0, self._disarmed_at + _SETTLES_S - time.monotonic()))
        armed = make_ready(cf, who, arms=options.arms, timeout_s=options.ready_timeout_s)
        with self._lock:
            self._armed_here |= armed
            self.is_ready = True

    def arm_in_passing(self) -> None:
        """Arm a drone that is commanded without a take-off, without keeping the caller waiting."""
        now = self._clock()
        with self._lock:
            if self.is_ready or not self._options.arms or now - self._asked_to_arm < _ARM_AGAIN_S:
                return
            self._asked_to_arm = now
        self._sender.post(self._arm_if_needed)
        self._sender.outbox.wake()

    def _see_off(self, cf: LinkedCrazyflie) -> None:
        """Check whether a drone takes off after the command, and retry the command if not."""
        bits = supervisor_bits(cf)
        with self._lock:
            if not self._liftoff.is_expected:  # it was stopped meanwhile
                return
            if bits is None:
                self._liftoff.look(None, False, self._clock())
                return
            if self._options.arms and bits & CAN_BE_ARMED and not bits & (IS_ARMED | IS_AUTO_ARMED):
                self._armed_here = True
                cf.supervisor.send_arming_request(True)
            if bits & NEEDS_A_HAND:
                self._liftoff.forget()  # else it would start in that hand
                goes_on = False
            else:
                goes_on = self._liftoff.look(follows_planner(bits), bool(bits & CAN_FLY), self._clock())
            if not goes_on:
                self.note("grounded", f"does not take off: {why_grounded(bits, self._options.arms)}")

    def do_not_take_off(self) -> None:
        """Forget a take-off that has not happened yet."""
        with self._lock:
            if self._liftoff.is_expected:
                self._liftoff.forget()

    def _arm_if_needed(self, cf: LinkedCrazyflie) -> None:
        bits = supervisor_bits(cf)
        if bits is None:
            return
        if bits & IS_ARMED:
            self.is_ready = True
        elif bits & CAN_BE_ARMED:
            self._armed_here = True
            cf.supervisor.send_arming_request(True)

    def _send_last(self, cf: LinkedCrazyflie) -> None:
        cf.commander.send_stop_setpoint()
        cf.high_level_commander.stop()
        if self._armed_here:
            self._armed_here = False
            self._disarm(cf)

    def _send_emergency_stop(self, cf: LinkedCrazyflie) -> None:
        cf.supervisor.send_emergency_stop()
        # one that has just landed does not look for it until it resets, which disarming begins
        cf.supervisor.send_arming_request(False)
        if cf.link is not None:  # else it was not sent
            self._emergency_stop_due = math.inf

    def _disarm(self, cf: LinkedCrazyflie) -> None:
        cf.supervisor.send_arming_request(False)
        self._disarmed_at = time.monotonic()


def _send_hover(cf: LinkedCrazyflie) -> None:
    cf.commander.send_velocity_world_setpoint(0.0, 0.0, 0.0, 0.0)


def _send_stop(cf: LinkedCrazyflie) -> None:
    cf.commander.send_stop_setpoint()
