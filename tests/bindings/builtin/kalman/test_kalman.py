"""The filter of the provider: boot, restart, dispatch, kept attitude, variables (estimators dossier 8 and 14)."""

import math
import struct

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

CORE, PERSISTENT = lib.CF_CORE, lib.CF_PERSISTENT


@pytest.fixture
def kalman():
    kalman = ffi.new("cf_kalman_t *")
    lib.cf_kalman_boot(kalman, 1000)
    return kalman


# dossier 14.1, without resetEstimation, and 14.4
PARAMETERS = [
    ("kalman.robustTdoa", lib.CF_TYPE_UINT8, CORE, 0),
    ("kalman.robustTwr", lib.CF_TYPE_UINT8, CORE, 0),
    ("kalman.pNAcc_xy", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.5),
    ("kalman.pNAcc_z", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 1.0),
    ("kalman.pNVel", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0),
    ("kalman.pNPos", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0),
    ("kalman.pNAtt", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0),
    ("kalman.mNBaro", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 2.0),
    ("kalman.mNGyro_rollpitch", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.1),
    ("kalman.mNGyro_yaw", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.1),
    ("kalman.initialX", lib.CF_TYPE_FLOAT, CORE, 0.0),
    ("kalman.initialY", lib.CF_TYPE_FLOAT, CORE, 0.0),
    ("kalman.initialZ", lib.CF_TYPE_FLOAT, CORE, 0.0),
    ("kalman.initialYaw", lib.CF_TYPE_FLOAT, CORE, 0.0),
    ("kalman.maxPos", lib.CF_TYPE_FLOAT, CORE, 100.0),
    ("kalman.maxVel", lib.CF_TYPE_FLOAT, CORE, 10.0),
    *((f"kalman.{n}", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0) for n in ("dragB_x", "dragB_y", "dragB_z")),
    *((f"kalman.{n}", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0) for n in ("cop_x", "cop_y", "cop_z")),
    *((f"flowdeck.flowdeckPos_{n}", lib.CF_TYPE_FLOAT, CORE | PERSISTENT, 0.0) for n in "xyz"),
]

# dossier 14.2, without the rates, and 14.3
LOGS = [
    *(f"kalman.state{n}" for n in ("X", "Y", "Z", "PX", "PY", "PZ", "D0", "D1", "D2")),
    *(f"kalman.var{n}" for n in ("X", "Y", "Z", "PX", "PY", "PZ", "D0", "D1", "D2")),
    *(f"kalman.q{n}" for n in range(4)),
    *(f"kalman_pred.{n}" for n in ("predNX", "predNY", "measNX", "measNY")),
]


def rows(table: ffi.CData) -> dict[str, ffi.CData]:
    """Return the rows of a table by their full names."""
    found = [table.rows[i] for i in range(table.count)]
    return {f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}": row for row in found}


def value(kalman: ffi.CData, row: ffi.CData) -> float:
    raw = ffi.buffer(kalman)[row.offset : row.offset + 4]
    return raw[0] if row.type == lib.CF_TYPE_UINT8 else struct.unpack("f", raw)[0]


@pytest.mark.parametrize(("name", "kind", "flags", "default"), PARAMETERS)
def test_parameter(kalman, name, kind, flags, default):
    row = rows(lib.cf_kalman_parameters())[name]
    assert (row.type, row.flags) == (kind, flags)
    assert value(kalman, row) == np.float32(default)


def test_parameters_are_in_the_order_of_the_firmware():
    assert list(rows(lib.cf_kalman_parameters())) == [name for name, *_ in PARAMETERS]


def test_logs_are_in_the_order_of_the_firmware():
    table = rows(lib.cf_kalman_logs())
    assert list(table) == LOGS
    assert {row.type for row in table.values()} == {lib.CF_TYPE_FLOAT}


def test_logs_show_state_variance_attitude_and_flow(kalman, helpers):
    kalman.core = helpers.random_core(0)[0]
    kalman.flow.predicted_x, kalman.flow.measured_y = 0.5, -0.25
    table = rows(lib.cf_kalman_logs())
    shown = [value(kalman, table[name]) for name in LOGS]
    expected = [*kalman.core.S, *helpers.array(kalman.core.P).diagonal(), *kalman.core.q, 0.5, 0.0, 0.0, -0.25]
    np.testing.assert_array_equal(np.array(shown, np.float32), np.array(expected, np.float32))


def test_boot_leaves_nothing_of_what_was_there(helpers):
    kalman = ffi.new("cf_kalman_t *")
    ffi.buffer(kalman)[:] = b"\xaa" * ffi.sizeof("cf_kalman_t")
    lib.cf_kalman_boot(kalman, 77)
    for table, expected in ((lib.cf_kalman_parameters(), PARAMETERS), (lib.cf_kalman_logs(), LOGS)):
        assert len(rows(table)) == len(expected)
        assert all(math.isfinite(v) and abs(v) <= 10000.0 for v in (value(kalman, row) for row in rows(table).values()))
    assert list(kalman.core.S) == [0.0] * 9
    assert list(kalman.core.q) == [1.0, 0.0, 0.0, 0.0]
    assert (kalman.core.lastPredictionMs, kalman.core.isUpdated, kalman.core.settled) == (77, False, 0)
    assert (kalman.attitude.roll, kalman.attitude.pitch, kalman.attitude.yaw) == (0.0, 0.0, 0.0)


def test_restart_keeps_the_parameters(kalman):
    kalman.params.initialX, kalman.params.procNoiseAcc_z, kalman.limits.max_velocity = 2.0, 0.75, 3.0
    kalman.core.S[3] = 9.0
    lib.cf_kalman_init(kalman, 2000)
    assert list(kalman.core.S) == [2.0] + [0.0] * 8
    assert (kalman.params.procNoiseAcc_z, kalman.limits.max_velocity) == (0.75, 3.0)
    assert kalman.core.lastPredictionMs == 2000


def measurement(kind: int, **data: dict) -> ffi.CData:
    return ffi.new("measurement_t *", {"type": kind, "data": data})


POSE = {"pos": [1, 2, 3], "quat": {"w": 1.0, "x": 0.1, "y": 0.0, "z": 0.0}, "stdDevPos": 0.01, "stdDevQuat": 0.01}
FLOW = {"dpixelx": 1.0, "dpixely": 2.0, "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
FUSED = {
    "Position": (
        measurement(lib.MeasurementTypePosition, position={"pos": [1, 2, 3], "stdDev": 0.01}),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithPosition(core, ffi.addressof(m.data, "position")),
    ),
    "Pose": (
        measurement(lib.MeasurementTypePose, pose=POSE),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithPose(core, ffi.addressof(m.data, "pose")),
    ),
    "TOF": (
        measurement(lib.MeasurementTypeTOF, tof={"distance": 1.0, "stdDev": 0.01}),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithTof(core, ffi.addressof(m.data, "tof")),
    ),
    "Flow": (
        measurement(lib.MeasurementTypeFlow, flow=FLOW),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithFlow(core, ffi.addressof(m.data, "flow"), gyro),
    ),
}


@pytest.mark.parametrize("name", FUSED)
def test_measurement_reaches_its_model(kalman, helpers, name):
    item, model = FUSED[name]
    twin, gyro = ffi.new("kalmanCoreData_t *", kalman.core), helpers.axis3f(10, -20, 30)
    lib.cf_kalman_update(kalman, item, gyro, 1000)
    model(twin, item, gyro)
    assert ffi.buffer(ffi.addressof(kalman, "core"))[:] == ffi.buffer(twin)[:]
    assert kalman.core.isUpdated


def test_flow_uses_the_place_of_the_deck_and_fills_the_log(kalman, helpers):
    item, _ = FUSED["Flow"]
    centered = ffi.new("cf_kalman_t *", kalman[0])
    kalman.flow_position.z = -0.05
    gyro = helpers.axis3f(100, 0, 0)
    lib.cf_kalman_update(kalman, item, gyro, 1000)
    lib.cf_kalman_update(centered, item, gyro, 1000)
    assert kalman.flow.predicted_y != centered.flow.predicted_y
    assert kalman.flow.measured_y == pytest.approx(0.2)


@pytest.mark.parametrize(
    "kind",
    [
        *(lib.MeasurementTypeTDOA, lib.MeasurementTypeDistance, lib.MeasurementTypeAbsoluteHeight),
        *(lib.MeasurementTypeYawError, lib.MeasurementTypeSweepAngle, lib.MeasurementTypeBarometer),
        *(lib.MeasurementTypeGyroscope, lib.MeasurementTypeAcceleration),
    ],
)
def test_other_measurements_change_nothing(kalman, helpers, kind):
    before = ffi.buffer(kalman)[:]
    lib.cf_kalman_update(kalman, measurement(kind), helpers.axis3f(0, 0, 0), 1000)
    assert ffi.buffer(kalman)[:] == before


@pytest.mark.parametrize("finalized", [False, True])
def test_the_kept_attitude_is_that_of_the_core(kalman, helpers, finalized):
    """Also between a prediction and finalize, where the quaternion has moved on."""
    zero, gyro = helpers.axis3f(0, 0, 1), helpers.axis3f(3, -2, 1)
    kept, fresh = ffi.new("state_t *"), ffi.new("state_t *")
    for now_ms in range(1010, 1200, 10):
        lib.cf_kalman_predict(kalman, zero, gyro, now_ms, True)
        if finalized:
            assert lib.cf_kalman_finalize(kalman)
        lib.cf_kalman_externalize(kalman, kept, zero)
        lib.kalmanCoreExternalizeState(ffi.addressof(kalman, "core"), fresh, zero)
        assert ffi.buffer(kept)[:] == ffi.buffer(fresh)[:]
    assert abs(kept.attitude.roll) > 1.0
    assert lib.cf_kalman_finalize(kalman) == (not finalized)


def test_bounds_come_from_the_parameters(kalman):
    kalman.core.S[0] = 50.0
    assert lib.cf_kalman_is_within_bounds(kalman)
    kalman.limits.max_position = 40.0
    assert not lib.cf_kalman_is_within_bounds(kalman)
    kalman.core.S[0] = math.nan
    assert lib.cf_kalman_is_within_bounds(kalman)
