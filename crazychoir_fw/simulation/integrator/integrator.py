"""`CrazyflieIntegrator`: the light alternative to the simulated vehicle (docs/reference/crazychoir.md#11)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.attitude import angle_rates, legacy_rates, quaternion_xyzw, rotation, wrapped
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.onboard.core import platform_names
from crazychoir_fw.simulation.integrator.loops import GRAVITY, AttitudeLoop, GoToLoop, Loop, VelocityLoop
from crazychoir_fw.simulation.integrator.platforms import platform_drag, platform_mass
from crazychoir_fw.simulation.integrator.stepping import Odometry, RandomForce, euler, rk4

Array = NDArray[np.float64]

DEFAULT_MASS = 0.038
"""Mass of the vehicle where neither a mass nor a platform is given (kg): that of the original."""

_LEGACY_GRAVITY = 9.80665  # m/s^2, by which the numbers of the original come out
_STATES = 9
_ROOM = 3.0  # [m], in which drones without a start position begin


class CrazyflieIntegrator:
    """Integrates (x, y, z, roll, pitch, yaw, vx, vy, vz) under thrust (N) and body rates (rad/s).

    Body rates are reached at once: there is no inertia, no motor and no firmware. The method is the explicit
    Runge-Kutta method of degree 4, with the input held over a step. One drone has arrays of shape (k,), N drones have
    (N, k). A subclass may override `derivative`, and name further states in `extra_states`.

    World x, y level, z up; roll, pitch, yaw extrinsic x-y-z, right-handed, in [-pi, pi).
    """

    extra_states: int = 0
    """Number of states behind the nine that a subclass adds; they start at zero."""

    def __init__(
        self,
        integration_freq: int = 100,
        odom_freq: int | None = None,
        *,
        init_pos: ArrayLike | None = None,
        init_rpy: ArrayLike = (0.0, 0.0, 0.0),
        init_vel: ArrayLike = (0.0, 0.0, 0.0),
        agent_id: int = 0,
        mass: ArrayLike | None = None,
        platform: str | None = None,
        drag: ArrayLike | str | None = None,
        wind: ArrayLike = (0.0, 0.0, 0.0),
        disturbance: RandomForce | None = None,
        floor: float | None = None,
        gravity: float | None = None,
        legacy: bool = False,
    ) -> None:
        """Place the drones.

        Args:
            integration_freq: Steps per second.
            odom_freq: Odometry messages per second, at most `integration_freq`; None is one per step.
            init_pos: Start (m, world), shape (3,) for one drone or (N, 3). None draws x and y in [0, 3] from
                `agent_id`, at height 0.
            init_rpy: Roll, pitch, yaw at the start (rad), shape (3,) or (N, 3).
            init_vel: Velocity at the start (m/s, world), shape (3,) or (N, 3).
            agent_id: Seed of the start, where it is drawn.
            mass: Mass (kg), a number or shape (N,); None is that of the platform, else 0.038 kg.
            platform: ``cf2`` or ``cf21bl``, whose mass and, with drag "rotor", drag are taken.
            drag: Rotor drag: coefficients along body x, y, z (N s/m), shape (3,), "rotor" for those of the platform
                (cf2 where none is named), None for none.
            wind: Velocity of the air (m/s, world), shape (3,); acts through drag.
            disturbance: Random force.
            floor: Height of the floor (m), on which drones rest; None is none.
            gravity: Acceleration of gravity (m/s^2); None is 9.81, and 9.80665 with `legacy`.
            legacy: Reproduce the original: forward Euler, body rates taken for Euler rates, its published rates.

        Raises:
            RangeError: If a value is outside its range; the message names it.
            UnknownNameError: If there is no such platform.
        """
        self.integration_freq = _frequency("integration_freq", integration_freq, None)
        self.odom_freq = integration_freq if odom_freq is None else _frequency("odom_freq", odom_freq, integration_freq)
        position = _start(init_pos, agent_id)
        self.shape = position.shape[:-1]
        """() for one drone, (N,) for many."""
        self._take_vehicle(platform, mass, drag)
        self.wind = self._each("wind", wind, 3)
        self.floor = floor
        self.legacy = legacy
        if gravity is None:
            gravity = _LEGACY_GRAVITY if legacy else GRAVITY
        self.gravity = float(_numbers("gravity", gravity))
        self._disturbance = disturbance
        self._force = np.zeros((*self.shape, 3))

        self.state = np.zeros((*self.shape, _STATES + self.extra_states))
        """The state, shape (9 + extra,) or (N, 9 + extra). May be written between steps."""
        self.state[..., 0:3] = position
        self.state[..., 3:6] = wrapped(self._each("init_rpy", init_rpy, 3))
        self.state[..., 6:9] = self._each("init_vel", init_vel, 3)
        self.input = np.zeros((*self.shape, 4))
        """Thrust (N) and body rates p, q, r (rad/s), shape (4,) or (N, 4); hover at first."""
        self.input[..., 0] = self.mass * self.gravity
        self._loop: Loop | None = None
        self._steps = 0
        self.odometry_listeners: list[Callable[[Odometry], None]] = []
        """Called with every odometry message."""

    def _take_vehicle(self, platform: str | None, mass: ArrayLike | None, drag: ArrayLike | str | None) -> None:
        if platform is not None and platform not in platform_names():
            raise UnknownNameError(f"platform is '{platform}', allowed: {', '.join(platform_names())}")
        default_mass = DEFAULT_MASS if platform is None else platform_mass(platform)
        self.mass = self._each("mass", default_mass if mass is None else mass)
        if not np.all(self.mass > 0.0):
            raise RangeError(f"mass is {mass}, allowed: above 0 kg")
        if isinstance(drag, str) and drag != "rotor":
            raise UnknownNameError(f"drag is '{drag}', allowed: rotor, three numbers or None")
        coefficients = platform_drag(platform or "cf2") if isinstance(drag, str) else drag
        self.drag = None if coefficients is None else self._each("drag", coefficients, 3)

    # ---------------------------------------------------------------- to be overridden

    def derivative(self, time: float, state: Array, command: Array, force: Array) -> Array:
        """Return the derivative of the state.

        Args:
            time: Time (s).
            state: State, shape (..., 9 + extra).
            command: Thrust (N) and body rates (rad/s), held over the step, shape (..., 4).
            force: Disturbing force (N, world), held over the step, shape (..., 3).
        """
        del time
        rpy, velocity = state[..., 3:6], state[..., 6:9]
        R = rotation(rpy)
        push = command[..., 0:1] * R[..., :, 2] + force
        if self.drag is not None:
            air = np.swapaxes(R, -1, -2) @ (velocity - self.wind)[..., None]
            push = push - (R @ (self.drag[..., None] * air))[..., 0]
        change = np.zeros_like(state)
        change[..., 0:3] = velocity
        change[..., 3:6] = command[..., 1:4] if self.legacy else angle_rates(rpy, command[..., 1:4])
        change[..., 6:9] = push / self.mass[..., None]
        change[..., 8] -= self.gravity
        return change

    # ---------------------------------------------------------------- commands, held until the next one

    def command(self, f: ArrayLike, p: ArrayLike, q: ArrayLike, r: ArrayLike) -> None:
        """Set thrust (N) and body rates (rad/s), each a number or shape (N,).

        Raises:
            RangeError: If one is not finite or of another shape, as of every command here.
        """
        values = [self._each(name, value) for name, value in zip("fpqr", (f, p, q, r), strict=True)]
        self.input = np.stack(values, axis=-1)
        self._loop = None

    def cmd_vel(self, linear: ArrayLike, angular: ArrayLike) -> None:
        """The same as a Twist: thrust (N) in linear z, body rates (rad/s) in angular; shape (3,) or (N, 3)."""
        linear, angular = self._each("linear", linear, 3), self._each("angular", angular, 3)
        self.command(linear[..., 2], *np.moveaxis(angular, -1, 0))

    def command_attitude(self, f: ArrayLike, roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> None:
        """Hold thrust (N) and roll, pitch, yaw (rad), each a number or shape (N,)."""
        named = {"roll": roll, "pitch": pitch, "yaw": yaw}
        angles = [self._each(name, value) for name, value in named.items()]
        self._loop = AttitudeLoop(self._each("f", f), np.stack(angles, axis=-1))

    def command_velocity(self, velocity: ArrayLike, yaw_rate: ArrayLike = 0.0) -> None:
        """Follow a velocity (m/s, world), shape (3,) or (N, 3), at a yaw rate (rad/s)."""
        self._loop = VelocityLoop(self._each("velocity", velocity, 3), self._each("yaw_rate", yaw_rate))

    def command_position(self, position: ArrayLike, duration: float, yaw: ArrayLike = 0.0) -> None:
        """Fly to a point (m, world), shape (3,) or (N, 3), within a duration (s), to a yaw (rad), and stay."""
        if not (math.isfinite(duration) and duration > 0.0):
            raise RangeError(f"duration is {duration}, allowed: above 0 s")
        self._loop = GoToLoop(
            begin=self.time,
            duration=float(duration),
            start=self.state[..., 0:3].copy(),
            start_velocity=self.state[..., 6:9].copy(),
            start_yaw=self.state[..., 5].copy(),
            goal=self._each("position", position, 3),
            goal_yaw=self._each("yaw", yaw),
        )

    # ---------------------------------------------------------------- time

    @property
    def time(self) -> float:
        """Time (s)."""
        return self._steps / self.integration_freq

    @property
    def dt(self) -> float:
        """Length of a step (s)."""
        return 1.0 / self.integration_freq

    def step(self, count: int = 1) -> None:
        """Integrate so many steps, and tell odometry listeners on the way.

        Raises:
            RangeError: If the state is no longer finite; the message names the first drone.
        """
        for _ in range(count):
            self._advance()
            before = (self._steps - 1) * self.odom_freq // self.integration_freq
            if self.odometry_listeners and self._steps * self.odom_freq // self.integration_freq > before:
                message = self.odometry
                for listener in list(self.odometry_listeners):
                    listener(message)

    def run(self, seconds: float) -> None:
        """Integrate seconds, rounded to whole steps."""
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise RangeError(f"run({seconds}): allowed: 0 s or more")
        self.step(round(seconds * self.integration_freq))

    def _advance(self) -> None:
        if self._loop is not None:
            self.input = self._loop(self.time, self.state, self.mass, self.gravity)
        if self._disturbance is not None:
            count = max(1, math.prod(self.shape))
            self._force = self._disturbance.step(count, self.dt).reshape(*self.shape, 3)
        command, force = self.input, self._force
        method = euler if self.legacy else rk4
        state = method(lambda t, x: self.derivative(t, x, command, force), self.time, self.state, self.dt)
        if not np.all(np.isfinite(state)):
            first = int(np.argmin(np.isfinite(state).all(axis=-1).ravel()))
            raise RangeError(f"drone {first}: the state is no longer finite after {self.time:.3f} s")
        state[..., 3:6] = wrapped(state[..., 3:6])
        if self.floor is not None:
            self._rest_on_floor(state)
        self.state = state
        self._steps += 1

    def _rest_on_floor(self, state: Array) -> None:
        """Stop level and still what has come down to the floor; it takes off when it is pushed up."""
        below = (state[..., 2] <= self.floor) & (state[..., 8] <= 0.0)
        state[below, 2] = self.floor
        state[below, 3:5] = 0.0
        state[below, 6:9] = 0.0

    # ---------------------------------------------------------------- outputs

    @property
    def rates(self) -> Array:
        """Angular velocity (rad/s, body), shape (..., 3)."""
        commanded = self.input[..., 1:4]
        return legacy_rates(self.state[..., 3:6], commanded) if self.legacy else commanded.copy()

    @property
    def odometry(self) -> Odometry:
        """Pose and twist now."""
        state = self.state
        return Odometry(
            self.time, state[..., 0:3].copy(), quaternion_xyzw(state[..., 3:6]), state[..., 6:9].copy(), self.rates
        )

    def _each(self, name: str, value: ArrayLike, length: int | None = None) -> Array:
        """Return a value for each drone: one for all, or one of each."""
        numbers = _numbers(name, value)
        shape = self.shape if length is None else (*self.shape, length)
        allowed = [() if length is None else (length,), shape]
        if numbers.shape not in allowed:
            raise RangeError(
                f"{name} has shape {numbers.shape}, allowed: {' or '.join(map(str, dict.fromkeys(allowed)))}"
            )
        return np.broadcast_to(numbers, shape).copy()


def _start(init_pos: ArrayLike | None, agent_id: int) -> Array:
    """Return where the drones begin (m, world), shape (3,) or (N, 3)."""
    if init_pos is None:
        x, y = np.random.default_rng(agent_id).uniform(0.0, _ROOM, 2)
        init_pos = (x, y, 0.0)
    position = _numbers("init_pos", init_pos)
    if position.ndim not in (1, 2) or position.shape[-1] != 3:
        raise RangeError(f"init_pos has shape {position.shape}, allowed: (3,) or (N, 3)")
    return position


def _numbers(name: str, value: ArrayLike) -> Array:
    try:
        numbers = np.asarray(value, float)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if np.all(np.isfinite(numbers)):
        return numbers
    bad = np.argwhere(~np.isfinite(np.atleast_1d(numbers)))[0]
    where = f" of drone {bad[0]}" if np.ndim(numbers) and len(bad) else ""
    raise RangeError(f"{name}{where} is {str(value)[:60]}, allowed: finite numbers")


def _frequency(name: str, value: int, highest: int | None) -> int:
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (is_whole and 1 <= value <= (highest or 1_000_000)):
        raise RangeError(f"{name} is {value!r}, allowed: a whole number of Hz, 1 to {highest or 1_000_000}")
    return int(value)
