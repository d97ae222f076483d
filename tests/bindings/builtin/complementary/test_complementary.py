"""The complementary estimator: rates, what it writes, variables.

docs/reference/estimators.md#10.1, #14.3 and #14.4.
"""

from __future__ import annotations

from typing import Any

import pytest

from crazychoir_fw._core import ffi, lib

MARK = -77.0


class Estimator:
    """A complementary estimator, fresh from boot, whose estimate is full of marks."""

    def __init__(self) -> None:
        self.struct = ffi.new("cf_complementary_t *")
        ffi.buffer(self.struct)[:] = b"\xaa" * ffi.sizeof("cf_complementary_t")
        lib.cf_complementary_boot(self.struct, lib.CF_SENSFUSION6_MAHONY)
        lib.cf_complementary_init(self.struct)
        self.latest = ffi.new("cf_latest_samples_t *")
        self.latest.acc.z = 1.0
        self.estimate = ffi.new("state_t *")
        for part in ("attitude", "attitudeQuaternion", "position", "velocity", "acc"):
            for name in dir(getattr(self.estimate, part)):
                if name != "timestamp":
                    setattr(getattr(self.estimate, part), name, MARK)

    def run(self, step: int) -> Any:
        lib.cf_complementary_update(self.struct, self.latest, self.estimate, step, 1500 + step)
        return self.estimate


def test_attitude_is_found_at_250_hz_and_height_at_100_hz():
    estimator = Estimator()
    attitude, height = [], []
    for step in range(1, 101):
        estimator.estimate.attitude.yaw = MARK
        estimator.estimate.position.z = MARK
        estimate = estimator.run(step)
        attitude += [step] if estimate.attitude.yaw != MARK else []
        height += [step] if estimate.position.z != MARK else []
    assert attitude == list(range(4, 101, 4))
    assert height == list(range(10, 101, 10))


def test_horizontal_velocity_and_acceleration_are_never_written():
    estimator = Estimator()
    for step in range(1, 101):
        estimate = estimator.run(step)
    assert [estimate.velocity.x, estimate.velocity.y, estimate.acc.x, estimate.acc.y] == [MARK] * 4
    assert [estimate.position.x, estimate.position.y] == [0.0, 0.0]
    assert [estimate.position.z, estimate.velocity.z] == [0.0, 0.0]


def test_estimate_holds_attitude_and_vertical_acceleration():
    estimator = Estimator()
    estimator.run(4)
    estimator.latest.gyro.x = 10.0
    estimator.latest.acc.z = 1.5
    estimate = estimator.run(8)
    fusion = estimator.struct.attitude
    q = estimate.attitudeQuaternion
    assert [q.x, q.y, q.z, q.w] == [fusion.qx, fusion.qy, fusion.qz, fusion.qw]
    assert estimate.attitude.roll == pytest.approx(0.04, rel=0.01)
    assert estimate.acc.z == pytest.approx(0.5 * fusion.gravZ, rel=1e-4)
    assert estimator.struct.altitude.velocityZ == pytest.approx((estimate.acc.z - 0.04) * 0.004 * 9.81 * 0.995)


def test_height_comes_from_the_latest_barometer_and_range():
    estimator = Estimator()
    estimator.latest.baro.asl = 50.0
    assert estimator.run(10).position.z == 50.0
    estimator.latest.tof.timestamp = 1500
    estimator.latest.tof.distance = 40.0
    assert estimator.run(20).position.z == pytest.approx(49.0)


FLOAT, UINT8 = lib.CF_TYPE_FLOAT, lib.CF_TYPE_UINT8
CORE, PERSISTENT = lib.CF_CORE, lib.CF_PERSISTENT

SENSFUSION_PARAMETERS = [
    ("sensfusion6.kp", FLOAT, CORE | PERSISTENT, 0.8),
    ("sensfusion6.ki", FLOAT, CORE | PERSISTENT, 0.002),
    ("sensfusion6.baseZacc", FLOAT, 0, 1.0),
]
SENSFUSION_LOGS = [
    ("sensfusion6.qw", FLOAT, 0, 1.0),
    *[(f"sensfusion6.{name}", FLOAT, 0, 0.0) for name in ("qx", "qy", "qz", "gravityX", "gravityY", "gravityZ")],
    ("sensfusion6.accZbase", FLOAT, 0, 1.0),
    ("sensfusion6.isInit", UINT8, 0, 0),
    ("sensfusion6.isCalibrated", UINT8, 0, 0),
]
ALTITUDE_PARAMETERS = [
    ("posEstAlt.estAlphaAsl", FLOAT, CORE | PERSISTENT, 0.9),
    ("posEstAlt.estAlphaZr", FLOAT, CORE | PERSISTENT, 0.9),
    ("posEstAlt.velFactor", FLOAT, PERSISTENT, 1.0),
    ("posEstAlt.velZAlpha", FLOAT, PERSISTENT, 0.995),
    ("posEstAlt.vAccDeadband", FLOAT, CORE | PERSISTENT, 0.04),
]
ALTITUDE_LOGS = [(f"posEstAlt.{name}", FLOAT, 0, 0.0) for name in ("estimatedZ", "estVZ", "velocityZ")]


@pytest.mark.parametrize(
    ("table", "part", "rows"),
    [
        (lib.cf_sensfusion6_parameters, "attitude", SENSFUSION_PARAMETERS),
        (lib.cf_sensfusion6_logs, "attitude", SENSFUSION_LOGS),
        (lib.cf_altitude_parameters, "altitude", ALTITUDE_PARAMETERS),
        (lib.cf_altitude_logs, "altitude", ALTITUDE_LOGS),
    ],
)
def test_variables_have_names_types_flags_and_defaults_of_the_firmware(table, part, rows):
    complementary = ffi.new("cf_complementary_t *")
    lib.cf_complementary_boot(complementary, lib.CF_SENSFUSION6_MAHONY)
    start = ffi.cast("char *", ffi.addressof(complementary, part))
    found = []
    for row in list(table().rows[0 : table().count]):
        kind = "float *" if row.type == FLOAT else "uint8_t *"
        value = ffi.cast(kind, start + row.offset)[0]
        name = f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}"
        found.append((name, row.type, row.flags, pytest.approx(value, rel=1e-6)))
    assert found == rows
