"""The driver of the lighthouse deck: sweeps, crossed beams and the yaw error.

docs/reference/estimators.md#5.5, #5.11, #13.4.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from queued import take
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

SENSORS = np.array([list(lib.cf_lighthouse_sensor_position(i)[0]) for i in range(4)])
TILTS = (lib.cf_lighthouse_tilt(0), lib.cf_lighthouse_tilt(1))
STATIONS = [((-2.5, -2.5, 2.5), (0.0, 0.0, 0.7)), ((2.5, 2.5, 2.5), (0.0, 0.0, 0.7))]
REAL_CALIBRATION = [
    {"phase": 0.02, "tilt": -0.048, "gibmag": 0.007, "gibphase": 1.9},
    {"phase": -0.005, "tilt": 0.046, "gibmag": -0.004, "gibphase": 0.4},
]


def floats(values: Any) -> Any:
    return ffi.new("float[]", np.ravel(values).tolist())


class Deck:
    """A driver that knows its base stations, with an estimator that believes in a pose."""

    def __init__(self, position: Any = (0.2, -0.4, 0.9), euler: Any = (0.0, 0.0, 0.0)) -> None:
        self.deck = ffi.new("cf_lighthouse_deck_t *")
        self.estimator = ffi.new("cf_estimator_t *")
        lib.cf_lighthouse_deck_init(self.deck)
        for data, (origin, target) in zip(self.stations, STATIONS, strict=True):
            data.origin = origin
            lib.cf_lighthouse_look_at(floats(origin), floats(target), data.rotation)
            data.has_geometry = True
            data.calibration.valid = True
        self.position = np.array(position)
        self.rotation = Rotation.from_euler("xyz", euler)
        self.believe(position, self.rotation)

    @property
    def stations(self) -> Any:
        return self.estimator.stations.list

    def believe(self, position: Any, rotation: Rotation) -> None:
        state = self.estimator.estimate
        state.position.x, state.position.y, state.position.z = position
        q = state.attitudeQuaternion
        q.x, q.y, q.z, q.w = rotation.as_quat()

    def angle(self, station: int, sensor: int, sweep: int) -> float:
        """Return the angle of the model of the filter, at the true pose."""
        data = self.stations[station]
        there = np.array([list(row) for row in data.rotation])
        point = self.position + self.rotation.apply(SENSORS[sensor])
        x, y, z = there.T @ (point - np.array(list(data.origin)))
        calibration = ffi.addressof(data.calibration.sweep, sweep)
        return lib.lighthouseCalibrationMeasurementModelLh2(x, y, z, TILTS[sweep], calibration)

    def sweep(self, station: int, sweep: int, tick: int, sensors: Any = (0, 1, 2, 3), noise: float = 0.0) -> list[Any]:
        message = ffi.new("cf_sweep_t *", {"station": station, "sweep": sweep})
        for i in sensors:
            message.sensors |= 1 << i
            message.angles[i] = self.angle(station, i, sweep) + noise
        lib.cf_lighthouse_deck_sweep(self.deck, self.estimator, message, tick)
        return take(self.estimator)

    def turn(self, station: int, tick: int, **options: Any) -> list[Any]:
        """Let both planes of a station pass."""
        return self.sweep(station, 0, tick, **options) + self.sweep(station, 1, tick + 7, **options)


def of_type(measurements: list[Any], kind: int) -> list[Any]:
    return [m.data for m in measurements if m.type == kind]


# ------------------------------------------------------------------------------------------- sweeps


def test_raw_sweeps_are_enqueued_with_ids_alone_a_sensor_at_a_time() -> None:
    deck = Deck()
    sweeps = [data.sweepAngle for data in of_type(deck.turn(1, tick=33), lib.MeasurementTypeSweepAngle)]
    assert [(s.baseStationId, s.sensorId, s.sweepId) for s in sweeps] == [(1, i, p) for i in range(4) for p in (0, 1)]
    for s in sweeps:
        assert s.measuredSweepAngle == pytest.approx(deck.angle(1, s.sensorId, s.sweepId), abs=1e-7)
        assert (s.timestamp, s.t, s.stdDev) == (40, TILTS[s.sweepId], pytest.approx(0.001))
        assert s.sensorPos == s.rotorPos == s.rotorRot == s.rotorRotInv == s.calib == ffi.NULL


def test_a_sensor_must_have_seen_both_planes() -> None:
    deck = Deck()
    deck.sweep(0, 0, tick=10, sensors=(0, 2, 3))
    sweeps = of_type(deck.sweep(0, 1, tick=17, sensors=(1, 2)), lib.MeasurementTypeSweepAngle)
    assert [(data.sweepAngle.sensorId, data.sweepAngle.sweepId) for data in sweeps] == [(2, 0), (2, 1)]


def test_resolved_sweep_has_no_innovation_at_the_true_pose() -> None:
    """What the filter computes from the pointers is what was measured, with a real calibration as well."""
    deck = Deck(euler=(0.1, -0.2, 2.0))
    for data in deck.stations:
        data.calibration.sweep = REAL_CALIBRATION
    measurements = [m for m in deck.turn(0, 10) + deck.turn(1, 20) if m.type == lib.MeasurementTypeSweepAngle]
    assert len(measurements) == 16
    for measurement in measurements:
        resolved = ffi.new("cf_resolved_sweep_t *")
        stations = ffi.addressof(deck.estimator, "stations")
        s = lib.cf_lighthouse_resolve(resolved, measurement, stations).data.sweepAngle
        back = np.array([list(row) for row in s.rotorRotInv[0]])
        there = np.array([list(row) for row in s.rotorRot[0]])
        assert np.array_equal(back.T, there)
        arm = deck.rotation.apply(list(s.sensorPos[0]))
        x, y, z = back @ (deck.position + arm - np.array(list(s.rotorPos[0])))
        predicted = s.calibrationMeasurementModel(x, y, z, s.t, s.calib)
        assert s.measuredSweepAngle - predicted == pytest.approx(0.0, abs=2e-6)


@pytest.mark.parametrize("ids", [{"baseStationId": 2}, {"sensorId": 4}, {"sweepId": 2}, {"baseStationId": 255}])
def test_sweep_with_an_unknown_id_keeps_null_pointers(ids: dict[str, int]) -> None:
    deck = Deck()
    measurement = ffi.new("measurement_t *", {"type": lib.MeasurementTypeSweepAngle, "data": {"sweepAngle": ids}})
    resolved = ffi.new("cf_resolved_sweep_t *")
    stations = ffi.addressof(deck.estimator, "stations")
    assert lib.cf_lighthouse_resolve(resolved, measurement, stations).data.sweepAngle.sensorPos == ffi.NULL


def test_other_measurements_are_not_touched() -> None:
    deck = Deck()
    measurement = ffi.new("measurement_t *", {"type": lib.MeasurementTypeTOF})
    resolved = ffi.new("cf_resolved_sweep_t *")
    assert lib.cf_lighthouse_resolve(resolved, measurement, ffi.addressof(deck.estimator, "stations")) == measurement


@pytest.mark.parametrize("missing", ["geometry", "calibration"])
def test_station_without_data_is_not_used(missing: str) -> None:
    deck = Deck()
    if missing == "geometry":
        deck.stations[0].has_geometry = False
    else:
        deck.stations[0].calibration.valid = False
    assert deck.turn(0, 10) == []
    assert deck.turn(1, 10) != []


@pytest.mark.parametrize("sensor", [-1, 4])
def test_there_are_four_sensors(sensor: int) -> None:
    assert lib.cf_lighthouse_sensor_position(sensor) == ffi.NULL


# ---------------------------------------------------------------------------------------- yaw error


YAW_DELTAS = [((0, 2, 2), 0.0), ((0, -2, -2), np.pi), ((0, 2, -2), -np.pi / 2)]


@pytest.mark.parametrize(("spv", "expected"), YAW_DELTAS)
def test_yaw_delta_of_the_reference(spv: Any, expected: float) -> None:
    """docs/reference/estimators.md#5.5: n = (1, 0, 0), ipv = (0, 1, 1)."""
    delta = ffi.new("float *")
    assert lib.cf_lighthouse_yaw_delta(floats((1, 0, 0)), floats((0, 1, 1)), floats(spv), delta)
    assert delta[0] == pytest.approx(expected, abs=1e-3)


def test_too_short_a_diagonal_gives_no_yaw() -> None:
    up, ahead, delta = floats((0, 0, 1)), floats((1, 0, 0)), ffi.new("float *")
    for length in (0.0, 9e-5, float("nan")):
        assert not lib.cf_lighthouse_yaw_delta(up, floats((length, 0, 0)), ahead, delta)


@pytest.mark.parametrize("method", [lib.CF_LIGHTHOUSE_CROSSING_BEAMS, lib.CF_LIGHTHOUSE_RAW_SWEEPS])
@pytest.mark.parametrize("station", [0, 1])
@pytest.mark.parametrize("error", [-0.3, -0.02, 0.0, 0.05, 0.4])
def test_yaw_error_is_estimate_minus_truth(method: int, station: int, error: float) -> None:
    deck = Deck(euler=(0.05, -0.08, 0.7))
    deck.deck.method = method
    deck.believe(deck.position, deck.rotation * Rotation.from_euler("z", error))
    (data,) = of_type(deck.turn(station, 10), lib.MeasurementTypeYawError)
    assert data.yawError.yawError == pytest.approx(error, abs=2e-3)
    assert (data.yawError.timestamp, data.yawError.stdDev) == (17, pytest.approx(0.01))


@pytest.mark.parametrize("sensors", [(0, 1, 2), (1, 2, 3), (0, 3), ()])
def test_yaw_needs_all_four_sensors(sensors: Any) -> None:
    assert of_type(Deck().turn(0, 10, sensors=sensors), lib.MeasurementTypeYawError) == []


def test_yaw_needs_both_planes_of_one_turn() -> None:
    deck = Deck()
    deck.sweep(0, 0, tick=10)
    assert of_type(deck.sweep(0, 1, tick=30), lib.MeasurementTypeYawError) == []


def test_at_most_one_yaw_error_per_loop() -> None:
    deck = Deck()
    for station in (0, 1):
        deck.sweep(station, 0, tick=10)
    both = deck.sweep(0, 1, tick=17) + deck.sweep(1, 1, tick=17)
    assert len(of_type(both, lib.MeasurementTypeYawError)) == 1


def test_light_along_the_deck_gives_no_yaw() -> None:
    deck = Deck()
    # believes to stand on edge, facing so that the ray runs within the plane of the deck
    ray = deck.position - np.array(STATIONS[0][0])
    ray /= np.linalg.norm(ray)
    normal = np.cross(ray, (0, 0, 1))
    rotation, _ = Rotation.align_vectors([normal], [(0, 0, 1)])
    deck.believe(deck.position, rotation)
    assert of_type(deck.turn(0, 10), lib.MeasurementTypeYawError) == []


# ----------------------------------------------------------------------------------- crossing beams


@given(
    st.tuples(st.floats(-1.8, 1.8), st.floats(-1.8, 1.8), st.floats(0.0, 1.6)),
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-3.0, 3.0)),
)
def test_crossing_beams_recover_the_position(position: Any, euler: Any) -> None:
    deck = Deck(position, euler)
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    deck.turn(0, 10)
    (data,) = of_type(deck.turn(1, 20), lib.MeasurementTypePosition)
    assert [data.position.x, data.position.y, data.position.z] == pytest.approx(position, abs=2e-4)
    assert data.position.stdDev == pytest.approx(0.01)
    assert data.position.source == lib.MeasurementSourceLighthouse


def test_crossing_beams_take_off_a_real_calibration() -> None:
    deck = Deck()
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    for data in deck.stations:
        data.calibration.sweep = REAL_CALIBRATION
    deck.turn(0, 10)
    (data,) = of_type(deck.turn(1, 20), lib.MeasurementTypePosition)
    assert [data.position.x, data.position.y, data.position.z] == pytest.approx(list(deck.position), abs=2e-4)


def test_crossing_beams_make_no_raw_sweeps() -> None:
    deck = Deck()
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    kinds = {m.type for m in deck.turn(0, 10) + deck.turn(1, 20)}
    assert kinds == {lib.MeasurementTypePosition, lib.MeasurementTypeYawError}


def test_one_common_sensor_is_enough_to_cross_beams() -> None:
    deck = Deck(euler=(0.1, 0.1, 1.0))
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    deck.turn(0, 10, sensors=(0, 2))
    (data,) = of_type(deck.turn(1, 20, sensors=(2, 3)), lib.MeasurementTypePosition)
    assert [data.position.x, data.position.y, data.position.z] == pytest.approx(list(deck.position), abs=2e-4)


def test_one_reflection_does_not_move_crossed_beams() -> None:
    deck = Deck()
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    for sweep, sensor in ((0, 1), (1, 3)):
        deck.turn(0, 10)
        deck.sweep(1, 0, tick=15)
        deck.deck.turns[1].angles[sensor][0] += 0.1
        deck.deck.turns[0].angles[sensor][sweep] += 0.1
        (data,) = of_type(deck.sweep(1, 1, tick=22), lib.MeasurementTypePosition)
        assert [data.position.x, data.position.y, data.position.z] == pytest.approx(list(deck.position), abs=0.02)


@pytest.mark.parametrize(("height", "is_crossing"), [(0.049, True), (0.051, False), (float("nan"), False)])
def test_rays_that_miss_each_other_do_not_cross(height: float, is_crossing: bool) -> None:
    middle = ffi.new("float[3]")
    x, y = floats((1, 0, 0)), floats((0, 1, 0))
    assert lib.cf_lighthouse_cross(floats((-2, 0, 0)), x, floats((0, 3, height)), y, middle) == is_crossing


@pytest.mark.parametrize(
    ("first", "second", "sensors"),
    [(10, 100, (0, 1)), (10, 20, ())],
    ids=["the other turn is too old", "nothing in common"],
)
def test_beams_that_do_not_belong_together_are_not_crossed(first: int, second: int, sensors: Any) -> None:
    deck = Deck()
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    deck.turn(0, first, sensors=(0, 1))
    assert of_type(deck.turn(1, second, sensors=sensors), lib.MeasurementTypePosition) == []


def test_parallel_beams_are_not_crossed() -> None:
    deck = Deck()
    deck.deck.method = lib.CF_LIGHTHOUSE_CROSSING_BEAMS
    deck.stations[1] = deck.stations[0]
    deck.turn(0, 10)
    assert of_type(deck.turn(1, 20), lib.MeasurementTypePosition) == []


@given(st.tuples(*[st.floats(-5, 5)] * 3), st.tuples(*[st.floats(-1, 1)] * 3), st.tuples(*[st.floats(-1, 1)] * 3))
def test_rays_through_a_point_cross_there(point: Any, d0: Any, d1: Any) -> None:
    d0, d1 = np.array(d0), np.array(d1)
    assume(min(np.linalg.norm(d0), np.linalg.norm(d1)) > 0.05)
    middle = ffi.new("float[3]")
    start, end = floats(point - 2 * d0), floats(point + 3 * d1)
    is_crossing = lib.cf_lighthouse_cross(start, floats(d0), end, floats(d1), middle)
    sine = np.linalg.norm(np.cross(d0, d1)) / (np.linalg.norm(d0) * np.linalg.norm(d1))
    if sine > 0.1:
        assert is_crossing
        assert list(middle) == pytest.approx(point, abs=2e-3)
    elif sine < 1e-3:
        assert not is_crossing


# ---------------------------------------------------------------------------------------------- log


def counted(deck: Deck) -> tuple[int, ...]:
    lib.cf_lighthouse_deck_count(deck.deck, ffi.addressof(deck.estimator, "stations"))
    d = deck.deck
    return d.available, d.geometries_valid, d.calibrations_valid, d.calibrations_confirmed, d.received, d.active


def test_log_counts_what_was_received_within_a_second() -> None:
    deck = Deck()
    assert counted(deck) == (3, 3, 3, 0, 0, 0)
    assert deck.deck.status == 0
    deck.turn(1, 10)
    assert counted(deck) == (3, 3, 3, 2, 2, 2)
    assert deck.deck.status == 2
    assert counted(deck) == (3, 3, 3, 0, 0, 0)


def test_log_says_that_data_is_missing() -> None:
    deck = Deck()
    deck.stations[0].has_geometry = False
    deck.stations[1].calibration.valid = False
    deck.turn(0, 10)
    assert counted(deck) == (3, 2, 1, 1, 1, 0)
    assert deck.deck.status == 1
