"""Drones of two providers, asked the same questions."""

from typing import Any

import numpy as np
from flight_inputs import UP

from crazychoir_fw._core import ffi, lib

STEPS = 600  # of the loop, for what is compared step by step

C_TYPES = {
    lib.CF_TYPE_UINT8: "uint8_t *",
    lib.CF_TYPE_UINT16: "uint16_t *",
    lib.CF_TYPE_UINT32: "uint32_t *",
    lib.CF_TYPE_INT8: "int8_t *",
    lib.CF_TYPE_INT16: "int16_t *",
    lib.CF_TYPE_INT32: "int32_t *",
    lib.CF_TYPE_FLOAT: "float *",
}


class Drone:
    """One drone of a provider, whose functions are called by hand.

    Functions of the provider are methods: the block is passed for them.
    """

    def __init__(self, provider: int, platform: int = lib.CF_PLATFORM_CF2) -> None:
        config = ffi.new("cf_config_t *")
        assert lib.cf_config_default(config, platform) == lib.CF_OK
        config.provider = provider
        self.provider = provider
        self.known = {}
        self.memory = ffi.new("double[]", lib.cf_state_bytes(provider) // 8)
        self.cf = ffi.cast("cf_t *", self.memory)
        assert lib.cf_init(self.cf, config) == lib.CF_OK
        self.said_at_boot = len(self.console())

    def __getattr__(self, name: str) -> Any:
        function = getattr(lib.cf_provider(self.provider), name)
        return lambda *arguments: function(self.cf.provider_state, *arguments)

    @property
    def table(self) -> Any:
        """The provider's table, for this thread."""
        return lib.cf_provider(self.provider)

    def variables(self, which: str) -> dict[str, tuple[int, int, int]]:
        """Return type, flags and offset of every parameter (`parameters`) or log variable (`logs`) by its name."""
        if which in self.known:
            return self.known[which]
        tables = ffi.new("cf_variables_t[]", 2 * lib.CF_PROVIDER_MAX_TABLES)
        count = getattr(lib, f"cf_{which}")(self.provider, tables, len(tables))
        rows = [(table.base, table.rows[i]) for table in tables[0:count] for i in range(table.count)]
        self.known[which] = {
            f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}": (
                row.type,
                row.flags,
                base + row.offset,
            )
            for base, row in rows
        }
        return self.known[which]

    def variable(self, which: str, name: str) -> Any:
        """Return a pointer to a variable."""
        type_, _, offset = self.variables(which)[name]
        return ffi.cast(C_TYPES[type_], ffi.cast("char *", self.cf) + offset)

    said_at_boot = 0

    def console(self) -> str:
        """Return what was printed since the drone booted."""
        text = ffi.new("char[]", 4096)
        length = lib.cf_console_read(ffi.addressof(self.cf.onboard.console), 0, text, len(text), ffi.new("uint32_t *"))
        return ffi.buffer(text, length)[:].decode()[self.said_at_boot :]


def as_floats(value: Any) -> np.ndarray:
    """Return a C value that has only floats, and integers that are zero, as an array."""
    return np.frombuffer(ffi.buffer(value), dtype=np.float32).copy()


def same(one: Any, other: Any) -> bool:
    """Return whether two such values are equal bit by bit, but for the sign of zero and the bits of NaN."""
    return np.array_equal(as_floats(one), as_floats(other), equal_nan=True)


def all_of(pair, name, *arguments):
    """Ask all drones; they must agree."""
    answers = [getattr(drone, name)(*arguments) for drone in pair]
    assert len(set(answers)) == 1, name
    return answers[0]


def control_of(control):
    if control.controlMode == lib.controlModeLegacy:
        return [control.roll, control.pitch, control.yaw, control.thrust]
    return list(control.normalizedForces)


def motors_of(drone, control):
    """Return counts, compensated counts, duties and whether they were reduced."""
    uncapped = ffi.new("motors_thrust_uncapped_t *")
    compensated = ffi.new("motors_thrust_uncapped_t *")
    pwm = ffi.new("motors_thrust_pwm_t *")
    drone.power_distribution(control, uncapped)
    drone.battery_compensate(uncapped, 3.7, compensated)
    reduced = drone.power_cap(compensated, pwm)
    drone.motor_override(3.7, pwm)
    return [list(uncapped.list), list(compensated.list), list(pwm.list), reduced]


def filter_step(drone, now, inputs, acc, gyro):
    """Run one millisecond of the estimator's task; return the estimate."""
    average, turning = (
        ffi.new("Axis3f *", {"axis": (acc * 9.81).tolist()}),
        ffi.new("Axis3f *", {"axis": gyro.tolist()}),
    )
    felt, latest = ffi.new("Axis3f *", {"axis": acc.tolist()}), ffi.new("Axis3f *", {"axis": np.degrees(gyro).tolist()})
    if now % 10 == 0:
        drone.kalman_predict(average, turning, now, now > 300)
    drone.kalman_add_process_noise(now)
    for measurement in inputs:
        drone.kalman_update(measurement, latest, now)
    finished = drone.kalman_finalize()
    estimate = ffi.new("state_t *")
    drone.kalman_externalize(estimate, felt)
    return estimate, finished, drone.kalman_is_within_bounds()


def complementary_flight(drones, rng, steps=STEPS):
    """Fly the complementary estimator of several drones; yield their estimates after each step."""
    latest = ffi.new("cf_latest_samples_t *")
    estimates = [ffi.new("state_t *") for _ in drones]
    for drone in drones:
        drone.complementary_init()
    for step in range(1, steps):
        latest.gyro.axis = rng.normal(0, 20, 3).tolist()
        latest.acc.axis = (UP + rng.normal(0, 0.1, 3)).tolist()
        latest.baro.asl = 50 + rng.normal(0, 0.1)
        if step > steps / 2 and step % 25 == 0:
            latest.tof.timestamp, latest.tof.distance = step, 0.5
        for drone, estimate in zip(drones, estimates, strict=True):
            drone.complementary(latest, estimate, step, 1000 + step if step < steps / 2 else step)
        yield estimates
