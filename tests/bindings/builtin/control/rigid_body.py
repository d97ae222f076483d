"""A rigid body on four motors, for tests that close the loop around one controller: true state, nothing else.

The plant of docs/reference/control-geometric.md#16: double precision, diagonal inertia of Lee, motor force = lag
of first order behind the duty, torques with the signs of the force-torque mixer, 1 kHz.
"""

import math
from collections.abc import Callable
from typing import Any

from crazychoir_fw._core import ffi, lib

GRAVITY = 9.81
INERTIA = (16.571710e-6, 16.655602e-6, 29.261652e-6)
DT = 1e-3
DEG = 180.0 / math.pi
CF2 = lib.CF_PLATFORM_CF2


class Mellinger:
    """The controller with its state, as the others below."""

    def __init__(self, platform: int = CF2) -> None:
        self.struct = ffi.new("controllerMellinger_t *")
        assert lib.cf_controller_mellinger_init(self.struct, platform) == lib.CF_OK

    def step(self, control: Any, setpoint: Any, sensors: Any, state: Any, step: int) -> None:
        lib.controllerMellinger(self.struct, control, setpoint, sensors, state, step)


class Lee:
    def __init__(self, platform: int = CF2) -> None:
        self.struct = ffi.new("controllerLee_t *")
        assert lib.cf_controller_lee_init(self.struct, platform) == lib.CF_OK

    def step(self, control: Any, setpoint: Any, sensors: Any, state: Any, step: int) -> None:
        lib.controllerLee(self.struct, control, setpoint, sensors, state, step)


class Brescianini:
    def __init__(self, platform: int = CF2) -> None:
        self.struct = ffi.new("controllerBrescianini_t *")
        assert lib.cf_controller_brescianini_boot(self.struct, platform) == lib.CF_OK

    def step(self, control: Any, setpoint: Any, sensors: Any, state: Any, step: int) -> None:
        lib.controllerBrescianini(self.struct, control, setpoint, sensors, state, step)


class Indi:
    def __init__(self, platform: int = CF2) -> None:
        self.struct = ffi.new("controllerINDI_t *")
        self._pid = ffi.new("cf_controller_pid_t *")
        assert lib.cf_controller_pid_init(self._pid, platform) == lib.CF_OK
        lib.cf_controller_indi_boot(self.struct)
        lib.controllerINDIInit(self.struct, self._pid)

    def step(self, control: Any, setpoint: Any, sensors: Any, state: Any, step: int) -> None:
        lib.controllerINDI(self.struct, self._pid, control, setpoint, sensors, state, step)


class RigidBody:
    """A vehicle at rest in mid-air, its motors at the force that carries it, with a controller on board."""

    def __init__(self, controller: Any, mass: float = 0.029, time_constant: float = 0.03, platform: int = CF2) -> None:
        self.controller, self.mass = controller, mass
        self._power = ffi.new("cf_power_distribution_t *")
        assert lib.cf_power_distribution_init(self._power, platform) == lib.CF_OK
        self.share = 1.0 - math.exp(-DT / time_constant) if time_constant > 0 else 1.0
        self.thrust_max = self._power.thrust.thrust_max
        self.arm = math.sqrt(0.5) * self._power.arm_length
        self.thrust_to_torque = self._power.thrust.thrust_to_torque

        self.position, self.velocity, self.rates = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        self.quat = (1.0, 0.0, 0.0, 0.0)  # w x y z
        self.forces = [mass * GRAVITY / 4] * 4
        self.steps = 0

        self._control, self._sensors, self._state = (
            ffi.new(f"{kind} *") for kind in ("control_t", "sensorData_t", "state_t")
        )
        self._uncapped, self._pwm = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_pwm_t *")
        self.setpoint = ffi.new("setpoint_t *", {"mode": {axis: lib.modeAbs for axis in ("x", "y", "z", "yaw")}})
        self.hold(self.position)

    def limit_thrust(self, newtons: float) -> None:
        """Set the force of one motor at full duty, for plant and mixer."""
        self.thrust_max = self._power.thrust.thrust_max = newtons

    def hold(self, position: tuple[float, float, float]) -> None:
        """Ask for a position, at rest and with a heading of 0."""
        self.setpoint.position = dict(zip("xyz", position, strict=True))

    def fly(self, seconds: float, command: Callable[[float], None] | None = None) -> list[tuple[float, float, float]]:
        """Return the positions every 10 ms; `command` is called before each with the time since the begin."""
        track = []
        for i in range(round(seconds * 1000)):
            if command is not None and i % 10 == 0:
                command(i * DT)
            self._step()
            if i % 10 == 9:
                track.append(self.position)
        return track

    def _step(self) -> None:
        self.steps += 1
        r = self._rotation()
        self._sense(r)
        self.controller.step(self._control, self.setpoint, self._sensors, self._state, self.steps)
        lib.cf_power_distribution_update(self._power, self._control, self._uncapped)
        lib.cf_power_distribution_cap(self._power, self._uncapped, self._pwm)
        scale = self.thrust_max / 65535.0
        forces = [f + self.share * (duty * scale - f) for f, duty in zip(self.forces, self._pwm.list, strict=True)]
        self.forces = forces
        self._move(r, forces)

    def _rotation(self) -> tuple[tuple[float, float, float], ...]:
        w, x, y, z = self.quat
        return (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )

    def _sense(self, r: tuple[tuple[float, float, float], ...]) -> None:
        state, gyro = self._state, self._sensors.gyro
        at, v, q = state.position, state.velocity, state.attitudeQuaternion
        at.x, at.y, at.z = self.position
        v.x, v.y, v.z = self.velocity
        q.w, q.x, q.y, q.z = self.quat
        state.attitude.roll = math.atan2(r[2][1], r[2][2]) * DEG
        state.attitude.pitch = math.asin(max(-1.0, min(1.0, r[2][0]))) * DEG  # legacy: positive lifts the nose
        state.attitude.yaw = math.atan2(r[1][0], r[0][0]) * DEG
        gyro.x, gyro.y, gyro.z = (rate * DEG for rate in self.rates)
        self._sensors.acc.z = sum(self.forces) / self.mass / GRAVITY

    def _move(self, r: tuple[tuple[float, float, float], ...], forces: list[float]) -> None:
        f1, f2, f3, f4 = forces
        jx, jy, jz = INERTIA
        p, q, s = self.rates
        tx = self.arm * (f3 + f4 - f1 - f2)
        ty = self.arm * (f2 + f3 - f1 - f4)
        tz = self.thrust_to_torque * (f2 + f4 - f1 - f3)
        p += DT * (tx - (jz - jy) * q * s) / jx
        q += DT * (ty - (jx - jz) * s * self.rates[0]) / jy
        s += DT * (tz - (jy - jx) * self.rates[0] * self.rates[1]) / jz
        self.rates = (p, q, s)

        lift = (f1 + f2 + f3 + f4) / self.mass
        vx, vy, vz = self.velocity
        vx, vy, vz = vx + DT * lift * r[0][2], vy + DT * lift * r[1][2], vz + DT * (lift * r[2][2] - GRAVITY)
        self.velocity = (vx, vy, vz)
        x, y, z = self.position
        self.position = (x + DT * vx, y + DT * vy, z + DT * vz)

        w, a, b, c = self.quat
        half = 0.5 * DT
        w, a, b, c = (
            w + half * (-a * p - b * q - c * s),
            a + half * (w * p + b * s - c * q),
            b + half * (w * q - a * s + c * p),
            c + half * (w * s + a * q - b * p),
        )
        norm = math.sqrt(w * w + a * a + b * b + c * c)
        self.quat = (w / norm, a / norm, b / norm, c / norm)
