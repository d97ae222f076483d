"""Filters, decks and the estimator task with numbers that break things."""

import math

import numpy as np
import pytest
from extremes import EXTREMES, FEW, many
from onboard.test_estimator import Provider

from crazychoir_fw._core import ffi, lib

ROUNDS = 2000
DIM = lib.KC_STATE_DIM
MEASUREMENTS = {
    "tdoa": ("tdoaMeasurement_t", lib.MeasurementTypeTDOA),
    "position": ("positionMeasurement_t", lib.MeasurementTypePosition),
    "pose": ("poseMeasurement_t", lib.MeasurementTypePose),
    "distance": ("distanceMeasurement_t", lib.MeasurementTypeDistance),
    "tof": ("tofMeasurement_t", lib.MeasurementTypeTOF),
    "height": ("heightMeasurement_t", lib.MeasurementTypeAbsoluteHeight),
    "flow": ("flowMeasurement_t", lib.MeasurementTypeFlow),
    "yawError": ("yawErrorMeasurement_t", lib.MeasurementTypeYawError),
    "sweepAngle": ("sweepAngleMeasurement_t", lib.MeasurementTypeSweepAngle),
    "gyroscope": ("gyroscopeMeasurement_t", lib.MeasurementTypeGyroscope),
    "acceleration": ("accelerationMeasurement_t", lib.MeasurementTypeAcceleration),
    "barometer": ("barometerMeasurement_t", lib.MeasurementTypeBarometer),
}


def measurements(count, seed):
    """Return measurements of every type in turn."""
    array, kinds = ffi.new("measurement_t[]", count), list(MEASUREMENTS.items())
    for place, (member, (kind, number)) in enumerate(kinds):
        for i, value in zip(range(place, count, len(kinds)), many(kind, count, seed + place), strict=False):
            array[i].type = number
            setattr(array[i].data, member, value)
    return array


def assert_bounded(core):
    """Raise unless the covariance is symmetric, and every entry is a number that a filter may hold."""
    P = np.frombuffer(ffi.buffer(core.P), np.float32).reshape(DIM, DIM)
    assert P.diagonal().min() >= 1e-6
    assert P.max() <= 100  # NaN fails as well
    assert (P == P.T).all()


def new_kalman(now=0, **switches):
    kalman = ffi.new("cf_kalman_t *")
    lib.cf_kalman_boot(kalman, now)
    for name, value in switches.items():
        setattr(kalman, name, value)
    return kalman


def test_table_of_sines_takes_every_float():
    for x in np.arange(0, 2**32 - 65521, 65521, np.uint32).view(np.float32).tolist():
        s, c = lib.cf_fast_sin(x), lib.cf_fast_cos(x)
        assert max(abs(s), abs(c)) <= 1 if math.isfinite(x) else math.isnan(s) and math.isnan(c)


def test_each_measurement_leaves_a_bounded_covariance():
    gyro = ffi.new("Axis3f *", {"x": 1, "y": 2, "z": 3})
    many_of_them = measurements(ROUNDS * 2, 1)
    for i in range(ROUNDS * 2):
        kalman = new_kalman(fuses_barometer=True, robust_tdoa=i % 2, robust_twr=i % 3 == 0)
        lib.cf_kalman_add_process_noise(kalman, 1)
        lib.cf_kalman_update(kalman, many_of_them + i, gyro, 1)
        assert_bounded(kalman.core)
        lib.cf_kalman_finalize(kalman)
        assert_bounded(kalman.core)


def test_nan_in_the_covariance_becomes_the_largest_variance():
    for i in range(DIM):
        for j in range(DIM):
            kalman = new_kalman()
            kalman.core.P[i][j] = math.nan
            lib.cf_kalman_add_process_noise(kalman, 1)
            assert kalman.core.P[i][j] == kalman.core.P[j][i] == 100
            assert_bounded(kalman.core)


def test_lost_parameters_and_samples():
    rng = np.random.default_rng(2)
    samples, values, estimate = many("Axis3f", 2 * ROUNDS, 2), many("float", ROUNDS, 3), ffi.new("state_t *")
    for i in range(ROUNDS):
        times = [int(t) for t in rng.integers(0, 2**32, 4)]
        kalman = new_kalman(times[0])
        count = ffi.sizeof(kalman.params) // 4
        ffi.cast("float *", ffi.addressof(kalman.params))[int(rng.integers(count))] = values[i]
        lib.cf_kalman_init(kalman, times[1])
        lib.cf_kalman_predict(kalman, samples + 2 * i, samples + 2 * i + 1, times[2], i % 2)
        lib.cf_kalman_add_process_noise(kalman, times[3])
        assert lib.cf_kalman_finalize(kalman)
        assert_bounded(kalman.core)
        lib.cf_kalman_externalize(kalman, estimate, samples + 2 * i)


def lost_core(values, i):
    """Return a filter after its first millisecond; every second one has lost its state and part of its covariance."""
    core, params = ffi.new("kalmanCoreData_t *"), ffi.new("kalmanCoreParams_t *")
    lib.kalmanCoreDefaultParams(params)
    lib.kalmanCoreInit(core, params, 0)
    lib.kalmanCoreAddProcessNoise(core, params, 1)
    if i % 2:
        core.S = list(values[0:DIM])
        core.P[i % DIM][i // 9 % DIM] = values[DIM]
        core.baroReferenceHeight = params.measNoiseBaro = values[DIM + 1]
    return core, params


def test_models_take_anything():
    kinds = ("heightMeasurement_t", "yawErrorMeasurement_t", "distanceMeasurement_t", "tdoaMeasurement_t")
    height, yaw, distance, tdoa = (many(kind, ROUNDS, seed) for seed, kind in enumerate(kinds))
    values, tdoa_filter = many("float", 128 * ROUNDS, 7), ffi.new("OutlierFilterTdoaState_t *")
    for i in range(ROUNDS):
        floats = values + 128 * i
        core, params = lost_core(floats, i)
        lib.outlierFilterTdoaReset(tdoa_filter)
        for update, *arguments in (
            (lib.kalmanCoreUpdateWithBaro, params, floats[20], i % 2),
            (lib.kalmanCoreUpdateWithAbsoluteHeight, height + i),
            (lib.kalmanCoreUpdateWithYawError, yaw + i),
            (lib.kalmanCoreUpdateWithDistance, distance + i),
            (lib.kalmanCoreUpdateWithTdoa, tdoa + i, 10 * i, tdoa_filter),
            (lib.kalmanCoreRobustUpdateWithDistance, distance + i, floats + 21),
            (lib.kalmanCoreRobustUpdateWithTdoa, tdoa + i, tdoa_filter, floats + 30),
            (lib.kalmanCoreUpdateWithPKE, floats, floats + 9, ffi.cast("float(*)[9]", floats + 40), floats[20]),
        ):
            update(core, *arguments)
            assert_bounded(core)
        assert core.isUpdated
        assert 0 <= tdoa_filter.integrator <= 300


def test_sweeps_take_anything():
    sweeps, calibrations = many("sweepAngleMeasurement_t", ROUNDS, 1), many("lighthouseCalibrationSweep_t", ROUNDS, 2)
    values, lh_filter = many("float", 64 * ROUNDS, 3), ffi.new("OutlierFilterLhState_t *")
    for i in range(ROUNDS):
        floats, sweep = values + 64 * i, sweeps[i]
        sweep.sensorPos, sweep.rotorPos = (ffi.cast("vec3d *", floats + at) for at in (12, 15))
        sweep.rotorRot, sweep.rotorRotInv = (ffi.cast("mat3d *", floats + at) for at in (18, 27))
        sweep.calib = calibrations + i
        sweep.calibrationMeasurementModel = lib.lighthouseCalibrationMeasurementModelLh2
        lib.outlierFilterLighthouseReset(lh_filter, i)
        core, _ = lost_core(floats, i)
        core.isUpdated = False
        lib.kalmanCoreUpdateWithSweepAngles(core, sweeps + i, 3 * i, lh_filter)
        if core.isUpdated or i % 2 == 0:
            assert_bounded(core)
        assert -16 <= lh_filter.openingWindowMs <= 40


def test_sweeps_survive_the_wrap_of_the_clock():
    lh_filter = ffi.new("OutlierFilterLhState_t *")
    lib.outlierFilterLighthouseReset(lh_filter, 0)
    assert lib.outlierFilterLighthouseValidateSweep(lh_filter, 1, 1, 3)
    assert lh_filter.openingTimeMs == 2**32 - 1 - 12
    assert lib.outlierFilterLighthouseValidateSweep(lh_filter, 1, 0, 2**32 - 1)


def updated(kalman, **measurement):
    """Fuse one measurement at the next millisecond."""
    ((member, value),) = measurement.items()
    lib.cf_kalman_add_process_noise(kalman, 1)
    one = ffi.new("measurement_t *", {"type": MEASUREMENTS[member][1], "data": {member: value}})
    lib.cf_kalman_update(kalman, one, ffi.new("Axis3f *"), 1)
    return np.array(list(kalman.core.S))


def test_what_a_distance_that_is_no_number_spoils():
    """A lost innovation spoils the state and spares the covariance, as in every scalar update."""
    lost, good = ({"x": 2, "distance": distance, "stdDev": 0.25} for distance in (math.nan, 2))
    kalman = new_kalman()
    assert np.isnan(updated(kalman, distance=lost)[[lib.KC_STATE_X, lib.KC_STATE_D2]]).all()
    assert kalman.core.P[lib.KC_STATE_X][lib.KC_STATE_X] < 1
    # the robust models remember: as in the firmware only a boot helps
    kalman = new_kalman(robust_twr=1)
    assert math.isnan(updated(kalman, distance=lost)[lib.KC_STATE_X])
    lib.cf_kalman_init(kalman, 0)
    assert math.isnan(updated(kalman, distance=good)[lib.KC_STATE_X])
    assert np.isfinite(updated(new_kalman(robust_twr=1), distance=good)).all()


def test_differences_that_are_no_numbers_are_impossible_ones():
    anchors = [{"x": 2}, {"y": 2}]
    kalman = new_kalman()
    assert np.isfinite(updated(kalman, tdoa={"anchorPositions": anchors, "distanceDiff": math.nan})).all()
    assert not kalman.core.isUpdated


@pytest.mark.parametrize("missing", ["sensorPos", "rotorPos", "rotorRot", "rotorRotInv", "calib", "model"])
def test_a_sweep_without_one_of_its_pointers_is_ignored(missing):
    vector, matrix = ffi.new("vec3d *"), ffi.new("mat3d *", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    sweep = {"sensorPos": vector, "rotorPos": vector, "rotorRot": matrix, "rotorRotInv": matrix, "stdDev": 0.001}
    sweep["calib"] = ffi.new("lighthouseCalibrationSweep_t *")
    sweep["calibrationMeasurementModel"] = lib.lighthouseCalibrationMeasurementModelLh2
    del sweep["calibrationMeasurementModel" if missing == "model" else missing]
    one = ffi.new("measurement_t *", {"type": lib.MeasurementTypeSweepAngle, "data": {"sweepAngle": sweep}})
    kalman = new_kalman()
    before = bytes(ffi.buffer(kalman))
    lib.cf_kalman_update(kalman, one, ffi.new("Axis3f *"), 1)
    assert bytes(ffi.buffer(kalman)) == before


def test_the_task_survives_floods_and_a_reset_brings_back_what_was_lost():
    provider, estimator = Provider(), ffi.new("cf_estimator_t *")
    lib.cf_estimator_init(estimator, provider.table, provider.state, lib.StateEstimatorTypeKalman, 1000)
    flood = measurements(4000, 5)
    for now in range(1001, 1401):
        for i in range(now * 7 % 40):
            accepted = lib.cf_estimator_enqueue(estimator, flood + (now * 37 + i) % 4000)
            assert accepted == (i < lib.CF_ESTIMATOR_QUEUE_SIZE)
        lib.cf_estimator_run(estimator, provider.table, provider.state, now, now % 3 == 0)
        assert estimator.queue_count == 0
        assert_bounded(provider.kalman.core)
    estimator.resetEstimation = 1
    lib.cf_estimator_run(estimator, provider.table, provider.state, 1401, False)
    assert np.isfinite(list(provider.kalman.core.S)).all()
    estimate = ffi.new("state_t *")
    lib.cf_estimator_get(estimator, estimate)
    assert math.isfinite(estimate.position.x) and math.isfinite(estimate.attitude.yaw)


def test_the_clock_may_wrap():
    kalman = new_kalman(2**32 - 2)
    lib.cf_kalman_predict(kalman, ffi.new("Axis3f *", {"z": 9.81}), ffi.new("Axis3f *"), 8, False)
    lib.cf_kalman_add_process_noise(kalman, 8)
    assert kalman.core.lastPredictionMs == 8
    assert abs(kalman.core.S[lib.KC_STATE_PZ]) < 1e-6


# ---- the complementary estimator and its front end


@pytest.mark.parametrize("kind", [lib.CF_SENSFUSION6_MAHONY, lib.CF_SENSFUSION6_MADGWICK])
def test_complementary_estimator(kind):
    samples = many("cf_latest_samples_t", 3000, 7)
    for run in range(50):
        complementary, estimate = ffi.new("cf_complementary_t *"), ffi.new("state_t *", {"position": {"x": 1}})
        lib.cf_complementary_boot(complementary, kind)
        lib.cf_complementary_init(complementary)
        for step in range(60):
            latest = samples + 60 * run + step
            latest.tof.timestamp = step if step % 3 == 0 else 0
            lib.cf_complementary_update(complementary, latest, estimate, step + 1, 2**32 - 30 + step & 0xFFFFFFFF)
        assert estimate.position.x == 0


def test_violent_samples_give_numbers():
    complementary, estimate = ffi.new("cf_complementary_t *"), ffi.new("state_t *")
    lib.cf_complementary_boot(complementary, lib.CF_SENSFUSION6_MAHONY)
    lib.cf_complementary_init(complementary)
    axes = {"gyro": {"x": 2000, "y": -2000, "z": 2000}, "acc": {"x": 24, "y": -24, "z": 24}, "baro": {"asl": 9000}}
    latest = ffi.new("cf_latest_samples_t *", axes)
    for step in range(1, 20001):
        lib.cf_complementary_update(complementary, latest, estimate, step, 2000 + step)
        if step % 100 == 0:
            attitude = estimate.attitude
            numbers = [attitude.roll, attitude.pitch, attitude.yaw, estimate.position.z, estimate.velocity.z]
            assert np.isfinite(numbers).all()


def test_compression_of_states_and_setpoints():
    states, setpoints, gyro = many("state_t", ROUNDS, 1), many("setpoint_t", ROUNDS, 2), many("Axis3f", ROUNDS, 3)
    q = ffi.new("float[4]")
    for i in range(ROUNDS):
        state = lib.cf_compress_state(states + i, gyro + i)
        setpoints[i].acceleration.x = states[i].position.x
        assert lib.cf_compress_setpoint(setpoints + i).ax == state.x  # the same conversion gives the same number
        lib.quatdecompress(state.quat, q)
        largest = state.quat >> 30
        assert all(abs(q[k]) <= 0.70711 for k in range(4) if k != largest)
        assert math.isnan(q[largest]) or 0 <= q[largest] <= 1


@pytest.mark.parametrize("number", EXTREMES)
def test_front_end_of_the_sensors(number):
    sensors = ffi.new("cf_sensors_t *")
    gyro, acc = (ffi.new("Axis3i16 *", {"x": x, "y": -1 - x, "z": -1}) for x in (-32768, 32767))
    lib.cf_sensors_init(sensors)
    lib.cf_sensors_set_trim(sensors, number, number)
    for tick in range(1, 5):
        lib.cf_sensors_update(sensors, gyro, acc, tick)
        lib.cf_sensors_update_baro(sensors, number, number)
    assert math.isfinite(sensors.data.gyro.x)
    sampler = ffi.new("Axis3fSubSampler_t *")
    lib.axis3fSubSamplerInit(sampler, 2)
    lib.axis3fSubSamplerAccumulate(sampler, ffi.new("Axis3f *", {"x": number}))
    lib.axis3fSubSamplerFinalize(sampler)
    lib.axis3fSubSamplerAccumulate(sampler, ffi.new("Axis3f *", {"z": 3}))
    assert lib.axis3fSubSamplerFinalize(sampler).z == 6


# ---- decks


@pytest.mark.parametrize("method", [lib.CF_LIGHTHOUSE_CROSSING_BEAMS, lib.CF_LIGHTHOUSE_RAW_SWEEPS])
@pytest.mark.parametrize("odd", FEW)
def test_lighthouse_deck_near_the_wrap_of_the_clock(method, odd):
    for place in range(5):
        estimator, deck = ffi.new("cf_estimator_t *"), ffi.new("cf_lighthouse_deck_t *")
        lib.cf_lighthouse_deck_init(deck)
        deck.method = method
        estimator.estimate.attitudeQuaternion.w = odd if place == 0 else 1
        estimator.estimate.position.x = odd if place == 1 else 1
        for i, station in enumerate(estimator.stations.list):
            lib.cf_lighthouse_look_at([0, i, 2], [2, 0, 0], station.rotation)
            station.has_geometry = station.calibration.valid = True
        first, second = estimator.stations.list[0], estimator.stations.list[1]
        for k, spoiled in enumerate((first.origin, second.rotation[0])):
            spoiled[1 + k] = odd if place == k else spoiled[1 + k]
        near, far = first.calibration.sweep, second.calibration.sweep
        for k, (calibration, name) in enumerate(((near[0], "tilt"), (far[1], "phase"), (near[1], "gibmag"))):
            setattr(calibration, name, odd if place == 2 + k else 0)
        for tick in range(-60, 60):
            sensors = sum(1 << i for i in range(4) if (tick + i) % 5)
            angles = [odd if i == tick % 4 else 0.1 * i for i in range(4)]
            fields = {"station": tick % 2, "sweep": tick // 7 % 2, "sensors": sensors, "angles": angles}
            sweep = ffi.new("cf_sweep_t *", fields)
            lib.cf_lighthouse_deck_sweep(deck, estimator, sweep, tick & 0xFFFFFFFF)
            for i in range(estimator.queue_count):
                resolved = ffi.new("cf_resolved_sweep_t *")
                assert lib.cf_lighthouse_resolve(resolved, estimator.queue + i, ffi.addressof(estimator.stations))
            estimator.queue_count = 0
        lib.cf_lighthouse_deck_count(deck, ffi.addressof(estimator.stations))


@pytest.mark.parametrize(("member", "known"), [("sensorId", 4), ("baseStationId", 2), ("sweepId", 2)])
def test_every_id_of_a_sweep(member, known):
    stations, resolved = ffi.new("cf_base_stations_t *"), ffi.new("cf_resolved_sweep_t *")
    for number in range(256):
        sweep = {"type": lib.MeasurementTypeSweepAngle, "data": {"sweepAngle": {member: number}}}
        result = lib.cf_lighthouse_resolve(resolved, ffi.new("measurement_t *", sweep), stations)
        assert (result.data.sweepAngle.rotorRotInv != ffi.NULL) == (number < known)


def test_every_register_of_flow_deck_and_rangers():
    estimator, driver, ranger = (
        ffi.new(f"{kind} *") for kind in ("cf_estimator_t", "cf_flow_driver_t", "cf_ranger_driver_t")
    )
    lib.cf_flow_driver_init(driver, 2**32 - 1)
    for value in range(-32768, 32768, 71):
        for adaptive in (0, 1):
            shape = {"delta_x": value, "delta_y": -1 - value, "shutter": value + 32768}
            shape |= {"motion": value & 255, "squal": value & 255}
            driver.adaptive = adaptive
            lib.cf_flow_driver_read(driver, estimator, ffi.new("cf_flow_reading_t *", shape), value & 0xFFFFFFFF)
            assert estimator.queue_count <= 1 and driver.std >= 0
            estimator.queue_count = 0
        for direction in range(lib.CF_RANGE_COUNT):
            lib.cf_ranger_driver_read(ranger, estimator, direction, value + 32768, 3)
            assert ranger.ranges[direction] == value + 32768
        assert estimator.queue_count == (value + 32768 < 5000)
        estimator.queue_count = 0


def test_every_ranging():
    estimator, deck = ffi.new("cf_estimator_t *"), ffi.new("cf_loco_deck_t *")
    lib.cf_loco_deck_init(deck)
    deck.is_planar = True
    for odd in EXTREMES:
        deck.height = odd
        for anchor in range(lib.CF_LOCO_ANCHORS):
            for mode in range(lib.CF_LOCO_TWR, lib.CF_LOCO_TDOA3 + 1):
                previous = lib.CF_LOCO_ANCHORS - 1 - anchor
                facts = {"mode": mode, "anchor": anchor, "previous": previous, "distance": odd}
                lib.cf_loco_deck_ranging(deck, estimator, ffi.new("cf_ranging_t *", facts), anchor)
                assert estimator.queue_count == 2
                estimator.queue_count = 0
    lib.cf_loco_deck_count(deck)
    assert deck.state == 255
