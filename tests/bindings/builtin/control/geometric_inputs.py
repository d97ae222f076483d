"""Setpoints, states and sensor data for the tests of the controllers that work with quaternions."""

import math
import struct
from collections.abc import Iterable
from typing import Any

from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity
MODE_NAMES = ("x", "y", "z", "roll", "pitch", "yaw", "quat")

IDENTITY = (0.0, 0.0, 0.0, 1.0)
# rpy2quat(0.1, -0.2, 0.5), which docs/reference/control-geometric.md#13.1 calls qa
QA = (0.0728518292, -0.0843056813, 0.250694811, 0.961632609)
QA_YAW = lib.degrees(0.5)
ZERO = (0.0, 0.0, 0.0, 0.0)

# what upstream's tests fly: level, at height 0, with all-zero quaternions (docs/reference/control-geometric.md#12)
UPSTREAM_MODES = (VELOCITY, VELOCITY, ABS, DISABLE, DISABLE, VELOCITY, DISABLE)
POSITION_MODES = (ABS, ABS, ABS, DISABLE, DISABLE, ABS, DISABLE)
MANUAL_MODES = (DISABLE, DISABLE, DISABLE, ABS, ABS, ABS, DISABLE)
QUAT_MODES = (ABS, ABS, ABS, DISABLE, DISABLE, DISABLE, ABS)
YAW_RATE_MODES = (ABS, ABS, ABS, DISABLE, DISABLE, VELOCITY, DISABLE)


def xyz(values: Iterable[float]) -> dict[str, float]:
    """Return the members of a vector."""
    return dict(zip("xyz", values, strict=True))


def rpy(values: Iterable[float]) -> dict[str, float]:
    """Return the members of an attitude."""
    return dict(zip(("roll", "pitch", "yaw"), values, strict=True))


def xyzw(values: Iterable[float]) -> dict[str, float]:
    """Return the members of a quaternion."""
    return dict(zip("xyzw", values, strict=True))


def make_setpoint(
    modes: Iterable[int] = POSITION_MODES,
    position: Iterable[float] = (0, 0, 0),
    velocity: Iterable[float] = (0, 0, 0),
    acceleration: Iterable[float] = (0, 0, 0),
    jerk: Iterable[float] = (0, 0, 0),
    attitude: Iterable[float] = (0, 0, 0),
    rate: Iterable[float] = (0, 0, 0),
    quat: Iterable[float] = IDENTITY,
    thrust: float = 0.0,
) -> Any:
    """Return a setpoint: modes as x, y, z, roll, pitch, yaw, quat; angles in deg, rates in deg/s."""
    fields = {
        "mode": dict(zip(MODE_NAMES, modes, strict=True)),
        "position": xyz(position),
        "velocity": xyz(velocity),
        "acceleration": xyz(acceleration),
        "jerk": xyz(jerk),
        "attitude": rpy(attitude),
        "attitudeRate": rpy(rate),
        "attitudeQuaternion": xyzw(quat),
        "thrust": thrust,
    }
    return ffi.new("setpoint_t *", fields)


def make_state(
    position: Iterable[float] = (0, 0, 0),
    velocity: Iterable[float] = (0, 0, 0),
    quat: Iterable[float] = IDENTITY,
    yaw: float = 0.0,
) -> Any:
    """Return a state; `yaw` (deg) is the one of the Euler angles, which is not derived from the quaternion."""
    fields = {
        "position": xyz(position),
        "velocity": xyz(velocity),
        "attitudeQuaternion": xyzw(quat),
        "attitude": rpy((0, 0, yaw)),
    }
    return ffi.new("state_t *", fields)


def make_sensors(gyro: Iterable[float] = (0, 0, 0)) -> Any:
    """Return sensor data at rest but for the gyro (deg/s)."""
    return ffi.new("sensorData_t *", {"gyro": {"axis": tuple(gyro)}, "acc": {"axis": (0, 0, 1)}})


def unit_xyz(v: Any) -> tuple[float, float, float]:
    """Return a C vector as a tuple."""
    return (v.x, v.y, v.z)


def float32(value: float) -> float:
    """Return a number as C sees it."""
    return struct.unpack("f", struct.pack("f", value))[0]


# ---- tables of variables ----


def variable_names(table: Any) -> list[str]:
    """Return the names of a table in order."""
    rows = [table.rows[i] for i in range(table.count)]
    return [f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}" for row in rows]


def variable(table: Any, owner: Any, name: str) -> float:
    """Return the value that the row with this name points to in `owner`."""
    row = next(row for row in (table.rows[i] for i in range(table.count)) if ffi.string(row.name) == name.encode())
    assert row.type == lib.CF_TYPE_FLOAT
    return ffi.cast("float *", ffi.cast("char *", owner) + row.offset)[0]


# ---- anything that may happen in flight ----


def _vectors(most: float, size: int = 3) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[st.floats(-most, most, width=32)] * size)


def _unit(values: tuple[float, ...]) -> tuple[float, ...]:
    norm = math.hypot(*values)
    return tuple(value / norm for value in values) if norm > 1e-3 else IDENTITY


_quaternions = _vectors(1, 4).map(_unit)

setpoints = st.builds(
    make_setpoint,
    modes=st.tuples(*[st.integers(0, 2)] * len(MODE_NAMES)),
    position=_vectors(1000),
    velocity=_vectors(100),
    acceleration=_vectors(100),
    jerk=_vectors(1000),
    attitude=_vectors(720),
    rate=_vectors(5000),
    quat=_quaternions,
    thrust=st.floats(0, 65535, width=32),
)
states = st.builds(
    make_state, position=_vectors(1000), velocity=_vectors(100), quat=_quaternions, yaw=st.floats(-180, 180, width=32)
)
sensors = st.builds(make_sensors, gyro=_vectors(2000))
platforms = st.sampled_from([lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL])


# ---- the provider ----


class Provider:
    """The built-in provider with a state block and the control that its controllers write."""

    def __init__(self, platform: int = lib.CF_PLATFORM_CF2) -> None:
        self.table = lib.cf_provider(0)
        self.block = ffi.new("uint64_t[]", lib.CF_PROVIDER_STATE_BYTES // 8)
        self.control = ffi.new("control_t *")
        assert self.table.init(self.block, platform, 0) == lib.CF_OK

    def select(self, controller: int) -> int:
        """Select a controller and return the status."""
        return self.table.controller_init(self.block, controller)

    @property
    def selected(self) -> int:
        """Number of the active controller."""
        return self.table.controller_type(self.block)

    def name(self, controller: int) -> str | None:
        """Return the name of a controller, None when it is not there."""
        text = self.table.controller_name(controller)
        return None if text == ffi.NULL else ffi.string(text).decode()

    def fly(self, setpoint: Any, sensors: Any, state: Any, step: int) -> Any:
        """Run the active controller for one step and return its control."""
        self.table.controller(self.block, self.control, setpoint, sensors, state, step)
        return self.control

    def motors(self, supply_voltage: float = 4.0) -> list[int]:
        """Return the four duties that the present control becomes."""
        uncapped = ffi.new("motors_thrust_uncapped_t *")
        compensated = ffi.new("motors_thrust_uncapped_t *")
        pwm = ffi.new("motors_thrust_pwm_t *")
        self.table.power_distribution(self.block, self.control, uncapped)
        self.table.battery_compensate(self.block, uncapped, supply_voltage, compensated)
        self.table.power_cap(self.block, compensated, pwm)
        return list(pwm.list)

    def parameter(self, name: str) -> Any:
        """Return a pointer to the float behind a parameter of the block."""
        tables = ffi.new("cf_variables_t[]", lib.CF_PROVIDER_MAX_TABLES)
        count = self.table.parameters(tables, lib.CF_PROVIDER_MAX_TABLES)
        for table in tables[0:count]:
            for i, found in enumerate(variable_names(table)):
                if found == name:
                    address = ffi.cast("char *", self.block) + table.base + table.rows[i].offset
                    return ffi.cast("float *", address)
        raise KeyError(name)
