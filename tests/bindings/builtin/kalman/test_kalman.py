"""The filter of the provider: boot, restart, dispatch, kept attitude, variables.

docs/reference/estimators.md#8 and #14.
"""

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


# docs/reference/estimators.md#14.1 without resetEstimation, and #14.4
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

# docs/reference/estimators.md#14.2 without the rates, and #14.3
LOGS = [
    *(f"kalman.state{n}" for n in ("X", "Y", "Z", "PX", "PY", "PZ", "D0", "D1", "D2")),
    *(f"kalman.var{n}" for n in ("X", "Y", "Z", "PX", "PY", "PZ", "D0", "D1", "D2")),
    *(f"kalman.q{n}" for n in range(4)),
    *(f"kalman_pred.{n}" for n in ("predNX", "predNY", "measNX", "measNY")),
    "outlierf.lhWin",
    "tdoa.innovation",
]


def rows(table: ffi.CData) -> dict[str, ffi.CData]:
    """Return the rows of a table by their full names."""
    found = [table.rows[i] for i in range(table.count)]
    return {f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}": row for row in found}


def value(kalman: ffi.CData, row: ffi.CData) -> float:
    raw = ffi.buffer(kalman)[row.offset : row.offset + 4]
    if row.type == lib.CF_TYPE_UINT8:
        return raw[0]
    return struct.unpack("i" if row.type == lib.CF_TYPE_INT32 else "f", raw)[0]


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
    assert table.pop("outlierf.lhWin").type == lib.CF_TYPE_INT32
    assert {row.type for row in table.values()} == {lib.CF_TYPE_FLOAT}


def test_logs_show_what_the_filter_and_its_models_hold(kalman, helpers):
    kalman.core = helpers.random_core(0)[0]
    kalman.flow.predicted_x, kalman.flow.measured_y = 0.5, -0.25
    kalman.sweep_filter.openingWindowMs, kalman.tdoa_innovation = 32, 0.75
    table = rows(lib.cf_kalman_logs())
    shown = [value(kalman, table[name]) for name in LOGS]
    models = [0.5, 0.0, 0.0, -0.25, 32, 0.75]
    expected = [*kalman.core.S, *helpers.array(kalman.core.P).diagonal(), *kalman.core.q, *models]
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
    assert (kalman.tdoa_filter.integrator, kalman.tdoa_filter.isFilterOpen) == (0.0, True)
    assert (kalman.sweep_filter.openingTimeMs, kalman.sweep_filter.openingWindowMs) == (0, -16)
    assert [*kalman.robust_tdoa_error, *kalman.robust_distance_error] == [0.0] * 18
    assert (kalman.fuses_barometer, kalman.is_flying) == (False, False)


def test_restart_keeps_the_parameters(kalman):
    kalman.params.initialX, kalman.params.procNoiseAcc_z, kalman.limits.max_velocity = 2.0, 0.75, 3.0
    kalman.core.S[3] = 9.0
    lib.cf_kalman_init(kalman, 2000)
    assert list(kalman.core.S) == [2.0] + [0.0] * 8
    assert (kalman.params.procNoiseAcc_z, kalman.limits.max_velocity) == (0.75, 3.0)
    assert kalman.core.lastPredictionMs == 2000


def test_restart_opens_the_outlier_filters_and_leaves_the_robust_models_alone(kalman):
    kalman.tdoa_filter.isFilterOpen, kalman.tdoa_filter.integrator = False, 280.0
    kalman.sweep_filter.openingTimeMs, kalman.sweep_filter.openingWindowMs = 5000, 40
    kalman.robust_tdoa_error[0], kalman.robust_distance_error[8] = 0.25, 0.5
    lib.cf_kalman_init(kalman, 2000)
    assert (kalman.tdoa_filter.isFilterOpen, kalman.tdoa_filter.integrator) == (True, 0.0)
    # with time 0, whatever the time
    assert (kalman.sweep_filter.openingTimeMs, kalman.sweep_filter.openingWindowMs) == (0, -16)
    assert (kalman.robust_tdoa_error[0], kalman.robust_distance_error[8]) == (0.25, 0.5)


def measurement(kind: int, **data: dict) -> ffi.CData:
    return ffi.new("measurement_t *", {"type": kind, "data": data})


POSE = {"pos": [1, 2, 3], "quat": {"w": 1.0, "x": 0.1, "y": 0.0, "z": 0.0}, "stdDevPos": 0.01, "stdDevQuat": 0.01}
FLOW = {"dpixelx": 1.0, "dpixely": 2.0, "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
TDOA = {"anchorPositions": [{"x": 2.0, "y": 1.0}, {"x": -2.0, "z": 1.0}], "distanceDiff": 0.1, "stdDev": 0.15}


def outlier_filter(kind: str) -> ffi.CData:
    state = ffi.new(f"{kind} *")
    if kind == "OutlierFilterTdoaState_t":
        lib.outlierFilterTdoaReset(state)
    else:
        lib.outlierFilterLighthouseReset(state, 0)
    return state


def memory() -> ffi.CData:
    return ffi.new("float[9]")


# a measurement, and what its model does with the core
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
    "AbsoluteHeight": (
        measurement(lib.MeasurementTypeAbsoluteHeight, height={"height": 1.0, "stdDev": 0.01}),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithAbsoluteHeight(core, ffi.addressof(m.data, "height")),
    ),
    "YawError": (
        measurement(lib.MeasurementTypeYawError, yawError={"yawError": 0.1, "stdDev": 0.01}),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithYawError(core, ffi.addressof(m.data, "yawError")),
    ),
    "Distance": (
        measurement(lib.MeasurementTypeDistance, distance={"pos": [2, 1, 0], "distance": 2.0, "stdDev": 0.25}),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithDistance(core, ffi.addressof(m.data, "distance")),
    ),
    "TDOA": (
        measurement(lib.MeasurementTypeTDOA, tdoa=TDOA),
        lambda core, m, gyro: lib.kalmanCoreUpdateWithTdoa(
            core, ffi.addressof(m.data, "tdoa"), 1000, outlier_filter("OutlierFilterTdoaState_t")
        ),
    ),
}
ROBUST = {
    "Distance": lambda core, m: lib.kalmanCoreRobustUpdateWithDistance(
        core, ffi.addressof(m.data, "distance"), memory()
    ),
    "TDOA": lambda core, m: lib.kalmanCoreRobustUpdateWithTdoa(
        core, ffi.addressof(m.data, "tdoa"), outlier_filter("OutlierFilterTdoaState_t"), memory()
    ),
}


def assert_same_core(kalman: ffi.CData, twin: ffi.CData) -> None:
    assert ffi.buffer(ffi.addressof(kalman, "core"))[:] == ffi.buffer(twin)[:]
    assert kalman.core.isUpdated


@pytest.mark.parametrize("name", FUSED)
def test_measurement_reaches_its_model(kalman, helpers, name):
    item, model = FUSED[name]
    twin, gyro = ffi.new("kalmanCoreData_t *", kalman.core), helpers.axis3f(10, -20, 30)
    lib.cf_kalman_update(kalman, item, gyro, 1000)
    model(twin, item, gyro)
    assert_same_core(kalman, twin)


@pytest.mark.parametrize(("name", "parameter"), [("Distance", "robust_twr"), ("TDOA", "robust_tdoa")])
def test_parameter_chooses_the_robust_model(kalman, helpers, name, parameter):
    item, twin = FUSED[name][0], ffi.new("kalmanCoreData_t *", kalman.core)
    setattr(kalman, parameter, 1)
    lib.cf_kalman_update(kalman, item, helpers.axis3f(0, 0, 0), 1000)
    ROBUST[name](twin, item)
    assert_same_core(kalman, twin)
    used = {"robust_tdoa": kalman.robust_tdoa_error[0] != 0.0, "robust_twr": kalman.robust_distance_error[0] != 0.0}
    assert used == {"robust_tdoa": False, "robust_twr": False} | {parameter: True}


def test_tdoa_passes_its_filter_and_tells_its_innovation(kalman, helpers):
    """The first sample adds 30 ms to the filter's integrator, the second the time since the first.

    The robust model does not use the outlier filter.
    """
    item, _ = FUSED["TDOA"]
    for now_ms in (1000, 1010):
        kalman.core.S[0] = kalman.core.S[1] = kalman.core.S[2] = 0.0
        lib.cf_kalman_update(kalman, item, helpers.axis3f(0, 0, 0), now_ms)
        assert kalman.tdoa_innovation == pytest.approx(0.1, abs=1e-6)
    assert (kalman.tdoa_filter.integrator, kalman.tdoa_filter.latestUpdateMs) == (40.0, 1010)

    kalman.robust_tdoa = 1
    kalman.core.S[0] = 1.0
    lib.cf_kalman_update(kalman, item, helpers.axis3f(0, 0, 0), 1020)
    assert kalman.tdoa_innovation == pytest.approx(0.1, abs=1e-6)
    assert kalman.tdoa_filter.latestUpdateMs == 1010


POINTERS = ["sensorPos", "rotorPos", "rotorRot", "rotorRotInv", "calib", "calibrationMeasurementModel"]


@pytest.fixture
def sweep_angle():
    """Return a measurement and what it points at, to be kept."""
    identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    kept = {
        "sensorPos": ffi.new("vec3d *", [0.015, 0.0075, 0.0]),
        "rotorPos": ffi.new("vec3d *", [-2.0, -1.0, 2.0]),
        "rotorRot": ffi.new("mat3d *", identity),
        "rotorRotInv": ffi.new("mat3d *", identity),
        "calib": ffi.new("lighthouseCalibrationSweep_t *"),
    }
    item = measurement(lib.MeasurementTypeSweepAngle, sweepAngle={**kept, "t": 0.5, "stdDev": 0.001})
    model = ffi.addressof(lib, "lighthouseCalibrationMeasurementModelLh2")
    item.data.sweepAngle.calibrationMeasurementModel = model
    return item, kept


def test_sweep_angle_reaches_its_model_and_filter(kalman, helpers, sweep_angle):
    item, _ = sweep_angle
    twin, state = ffi.new("kalmanCoreData_t *", kalman.core), outlier_filter("OutlierFilterLhState_t")
    lib.cf_kalman_update(kalman, item, helpers.axis3f(0, 0, 0), 1000)
    lib.kalmanCoreUpdateWithSweepAngles(twin, ffi.addressof(item.data, "sweepAngle"), 1000, state)
    assert_same_core(kalman, twin)
    assert kalman.sweep_filter.openingTimeMs == state.openingTimeMs == 1000 - 16


@pytest.mark.parametrize("name", POINTERS)
def test_sweep_angle_without_one_of_its_pointers_changes_nothing(kalman, helpers, sweep_angle, name):
    item, _ = sweep_angle
    setattr(item.data.sweepAngle, name, ffi.NULL)
    before = ffi.buffer(kalman)[:]
    lib.cf_kalman_update(kalman, item, helpers.axis3f(0, 0, 0), 1000)
    assert ffi.buffer(kalman)[:] == before


@pytest.mark.parametrize("is_flying", [False, True])
def test_barometer_is_fused_when_asked_to(kalman, params, helpers, is_flying):
    """On the ground, as of the latest prediction, its height becomes the reference."""
    item, zero = measurement(lib.MeasurementTypeBarometer, barometer={"baro": {"asl": 50.0}}), helpers.axis3f(0, 0, 0)
    kalman.fuses_barometer = True
    kalman.core.baroReferenceHeight = 40.0
    lib.cf_kalman_predict(kalman, zero, zero, 1010, is_flying)
    twin = ffi.new("kalmanCoreData_t *", kalman.core)
    lib.cf_kalman_update(kalman, item, zero, 1010)
    lib.kalmanCoreUpdateWithBaro(twin, params, 50.0, is_flying)
    assert_same_core(kalman, twin)
    assert kalman.core.baroReferenceHeight == (40.0 if is_flying else 50.0)


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
    "kind", [lib.MeasurementTypeBarometer, lib.MeasurementTypeGyroscope, lib.MeasurementTypeAcceleration]
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
