"""Base stations and the light on the deck: rates, geometry, visibility, noise.

docs/reference/estimators.md#5.11 and #13.4.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]

SENSORS = np.array([(-0.015, 0.0075, 0.0), (-0.015, -0.0075, 0.0), (0.015, 0.0075, 0.0), (0.015, -0.0075, 0.0)])
TILT = np.pi / 6
IDEAL = {"noise": 0.0, "calibration_error": 0.0, "position_error": 0.0, "attitude_error": 0.0, "mishap": {}}


def configure(make_config: Make, **changes: Any) -> Any:
    return changed(make_config("cf2").lighthouse, {**IDEAL, **changes})


def make(make_config: Make, seed: int = 1, world: int = 1, **changes: Any) -> Any:
    """Return an ideal system with the default stations, after changes."""
    lighthouse, config = ffi.new("cf_lighthouse_t *"), configure(make_config, **changes)
    status = lib.cf_lighthouse_init(lighthouse, config, dice(seed)[0], dice(seed + 100)[0], dice(world)[0])
    assert status == lib.CF_OK
    return lighthouse


def watch(lighthouse: Any, ticks: int, position: Any = (0.0, 0.0, 0.7), rotation: Any = None) -> list[Any]:
    """Return (tick, station, sweep, {sensor: angle}) of what hits a deck at rest."""
    flat = (np.eye(3) if rotation is None else rotation.as_matrix()).ravel()
    position, flat = ffi.new("float[3]", list(position)), ffi.new("float[9]", flat.tolist())
    sweeps = ffi.new("cf_sweep_t[2]")
    seen = []
    for tick in range(ticks):
        for k in range(lib.cf_lighthouse_step(lighthouse, position, flat, sweeps)):
            s = sweeps[k]
            angles = {i: s.angles[i] for i in range(4) if s.sensors >> i & 1}
            seen.append((tick, s.station, s.sweep, angles))
    return seen


def angle_of(station: Any, point: np.ndarray, tilt: float) -> float:
    """Return the sweep angle by the formula of docs/reference/estimators.md#5.11, in double precision."""
    rotation = np.array([[station.rotation[i][k] for k in range(3)] for i in range(3)])
    x, y, z = rotation.T @ (point - np.array(list(station.position)))
    return np.arctan2(y, x) + np.arcsin(z * np.tan(tilt) / np.hypot(x, y))


def test_each_station_and_plane_passes_about_50_times_per_second(make_config: Make) -> None:
    seen = watch(make(make_config), 10_000)
    for station in (0, 1):
        for sweep in (0, 1):
            ticks = [tick for tick, s, p, _ in seen if (s, p) == (station, sweep)]
            assert len(ticks) == pytest.approx(500, abs=2)
            assert set(np.diff(ticks)) <= {20, 21}


def test_the_second_plane_follows_a_third_of_a_turn_later(make_config: Make) -> None:
    seen = [(tick, sweep) for tick, station, sweep, _ in watch(make(make_config), 1000) if station == 0]
    first = [tick for tick, sweep in seen if sweep == 0]
    gaps = {tick - max(t for t in first if t < tick) for tick, sweep in seen if sweep == 1 and tick > first[0]}
    assert gaps <= {6, 7}


def test_channels_drift_against_each_other(make_config: Make) -> None:
    seen = watch(make(make_config), 10_000)
    start = {s: [tick for tick, station, p, _ in seen if (station, p) == (s, 0)] for s in (0, 1)}
    offset = np.array(start[1][:490]) - np.array(start[0][:490])
    assert offset[-1] - offset[0] == pytest.approx(490 * 0.042, abs=2)


@pytest.mark.parametrize(("rate", "sweeps"), [(0, 0), (1, 4), (30, 120), (100, 400)])
def test_rate_can_be_chosen(make_config: Make, rate: int, sweeps: int) -> None:
    assert len(watch(make(make_config, rate=rate), 1000)) == pytest.approx(sweeps, abs=4)


@pytest.mark.parametrize("position", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.7), (1.5, -1.0, 1.4), (-1.0, 0.2, 0.3)])
@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_ideal_angles_are_those_of_the_model(make_config: Make, position: Any, yaw: float) -> None:
    lighthouse = make(make_config)
    rotation = Rotation.from_euler("xyz", [0.1, -0.05, yaw])
    seen = watch(lighthouse, 25, position, rotation)
    assert len(seen) >= 4
    for _, station, sweep, angles in seen:
        assert set(angles) == {0, 1, 2, 3}
        for i, angle in angles.items():
            point = np.array(position) + rotation.apply(SENSORS[i])
            expected = angle_of(lighthouse.stations[station], point, (-TILT, TILT)[sweep])
            assert angle == pytest.approx(expected, abs=3e-6)


def test_sweep_angle_of_the_check_vector() -> None:
    """docs/reference/estimators.md#17.H: measured 0.5 with an innovation of 0.0480527282."""
    angle = lib.cf_sweep_angle(0.5 + 0.015 + 2.0, -0.3 + 0.0075 + 1.0, 1.2 - 2.0, -TILT)
    assert 0.5 - angle == pytest.approx(0.0480527282, abs=3e-7)


@given(
    st.tuples(*[st.floats(-5, 5)] * 3),
    st.tuples(*[st.floats(-5, 5)] * 3),
)
def test_a_station_that_looks_at_a_point_is_a_level_rotation(position: Any, target: Any) -> None:
    ahead = np.subtract(target, position)
    if np.hypot(*ahead[:2]) < 0.05:
        return
    out = ffi.new("float[3][3]")
    lib.cf_lighthouse_look_at(ffi.new("float[3]", position), ffi.new("float[3]", target), out)
    rotation = np.array([list(row) for row in out])
    assert rotation.T @ rotation == pytest.approx(np.eye(3), abs=1e-5)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-5)
    assert rotation[:, 0] == pytest.approx(ahead / np.linalg.norm(ahead), abs=1e-5)
    assert rotation[2, 1] == 0.0
    assert rotation[2, 2] >= 0.0


def test_a_station_under_the_ceiling_may_look_straight_down() -> None:
    out = ffi.new("float[3][3]")
    lib.cf_lighthouse_look_at(ffi.new("float[3]", [1, 2, 3]), ffi.new("float[3]", [1, 2, 0]), out)
    assert np.array([list(row) for row in out]) == pytest.approx(np.array([(0, 0, 1), (0, 1, 0), (-1, 0, 0)]))


# where a deck may be and how it may lie: which stations reach it
VISIBILITY = [
    ("middle of the room", (0.0, 0.0, 0.7), (0, 0, 0), {0, 1}),
    ("on the floor", (0.0, 0.0, 0.015), (0, 0, 0), {0, 1}),
    ("upside down", (0.0, 0.0, 0.7), (180, 0, 0), set()),
    ("above the stations", (0.0, 0.0, 2.6), (0, 0, 0), set()),
    ("light grazes the deck", (0.0, 0.0, 2.3), (0, 0, 0), set()),
    ("tilted to the first station", (0.0, 0.0, 0.7), (0, 0, 35), {0}),
    ("tilted to the second station", (0.0, 0.0, 0.7), (0, 0, -35), {1}),
    ("behind the first station", (-2.8, -2.8, 0.7), (0, 0, 0), set()),
    ("below the first station", (-2.48, -2.48, 0.5), (0, 0, 0), set()),
    ("too far from both", (9.0, -9.0, 0.7), (0, 0, 0), set()),
]


@pytest.mark.parametrize(("place", "position", "euler", "stations"), VISIBILITY, ids=[case[0] for case in VISIBILITY])
def test_light_reaches_what_it_can(make_config: Make, place: str, position: Any, euler: Any, stations: Any) -> None:
    roll, pitch, toward = euler
    # the last angle tilts about the horizontal axis that turns the deck to station 0, at (-2.5, -2.5)
    axis = np.array([1.0, -1.0, 0.0]) / 2**0.5
    tilt = Rotation.from_rotvec(np.radians(toward) * axis)
    rotation = Rotation.from_euler("xyz", [roll, pitch, 0], degrees=True) * tilt
    seen = watch(make(make_config), 50, position, rotation)
    assert {station for _, station, _, _ in seen} == stations


@pytest.mark.parametrize("azimuth", [-80.0, -74.0, 74.0, 80.0])
def test_field_of_view_is_75_degrees_to_each_side(make_config: Make, azimuth: float) -> None:
    station = {"position": [0.0, 0.0, 1.0], "target": [1.0, 0.0, 1.0]}
    lighthouse = make(make_config, stations=[station, station])
    place = (2 * np.cos(np.radians(azimuth)), 2 * np.sin(np.radians(azimuth)), 0.4)
    assert bool(watch(lighthouse, 50, place)) == (abs(azimuth) < 75)


@pytest.mark.parametrize(("elevation", "is_seen"), [(-60.0, False), (-54.0, True), (-10.0, True), (-4.0, False)])
def test_field_of_view_ends_55_degrees_down_and_where_light_grazes(
    make_config: Make, elevation: float, is_seen: bool
) -> None:
    station = {"position": [0.0, 0.0, 1.0], "target": [1.0, 0.0, 1.0]}
    lighthouse = make(make_config, stations=[station, station])
    place = (2 * np.cos(np.radians(elevation)), 0.0, 1.0 + 2 * np.sin(np.radians(elevation)))
    assert bool(watch(lighthouse, 50, place)) == is_seen


@pytest.mark.parametrize(("distance", "is_seen"), [(6.9, True), (7.1, False)])
def test_light_reaches_seven_meters(make_config: Make, distance: float, is_seen: bool) -> None:
    station = {"position": [0.0, 0.0, 2.0], "target": [1.0, 0.0, 2.0]}
    lighthouse = make(make_config, stations=[station, station])
    assert bool(watch(lighthouse, 50, ((distance**2 - 1.0) ** 0.5, 0.0, 1.0))) == is_seen


def test_lost_deck_sees_no_light(make_config: Make) -> None:
    lighthouse = make(make_config)
    lighthouse.is_lost = True
    assert watch(lighthouse, 100) == []
    lighthouse.is_lost = False
    assert len(watch(lighthouse, 100)) == pytest.approx(20, abs=2)


@pytest.mark.parametrize("noise", [0.0001, 0.0004])
def test_noise_is_white_with_the_asked_deviation(make_config: Make, noise: float) -> None:
    lighthouse = make(make_config, noise=noise)
    angles = [a[0] for _, station, sweep, a in watch(lighthouse, 60_000) if (station, sweep) == (0, 1)]
    error = np.array(angles) - angle_of(lighthouse.stations[0], np.array([0, 0, 0.7]) + SENSORS[0], TILT)
    assert error.std() == pytest.approx(noise, rel=0.05)
    assert abs(error.mean()) < 0.1 * noise
    assert abs(np.corrcoef(error[:-1], error[1:])[0, 1]) < 0.06


def test_sensors_have_noise_of_their_own(make_config: Make) -> None:
    angles = np.array([list(a.values()) for _, s, p, a in watch(make(make_config, noise=0.001), 20_000) if s + p == 0])
    correlation = np.corrcoef(angles.T) - np.eye(4)
    assert np.abs(correlation).max() < 0.15


def test_drop_outs_have_the_asked_frequency_and_leave_the_noise_alone(make_config: Make) -> None:
    everything = watch(make(make_config, noise=0.001), 10_000)
    some = watch(make(make_config, noise=0.001, mishap={"dropout": 0.2}), 10_000)
    every = {(t, s, p, i): a for t, s, p, angles in everything for i, a in angles.items()}
    rest = {(t, s, p, i): a for t, s, p, angles in some for i, a in angles.items()}
    assert len(rest) / len(every) == pytest.approx(0.8, abs=0.02)
    assert all(every[key] == angle for key, angle in rest.items())


def test_outliers_have_the_asked_frequency_and_size(make_config: Make) -> None:
    truth = {(s, p, i): a for _, s, p, angles in watch(make(make_config), 25) for i, a in angles.items()}
    seen = watch(make(make_config, mishap={"outlier": 0.05, "outlier_size": 0.4}), 10_000)
    error = np.array([abs(a - truth[s, p, i]) for _, s, p, angles in seen for i, a in angles.items()])
    wrong = error > 1e-4
    assert wrong.mean() == pytest.approx(0.05, abs=0.01)
    assert error[wrong].min() > 0.099
    assert error[wrong].max() < 0.401


def test_errors_of_the_stations_follow_their_deviations(make_config: Make) -> None:
    asked = {"position_error": 0.02, "attitude_error": 0.003, "calibration_error": 0.001}
    ideal = make(make_config)
    places, turns, phases, tilts = [], [], [], []
    for world in range(300):
        real = make(make_config, world=world, **asked)
        for i, station in enumerate(real.stations):
            there = Rotation.from_matrix(np.array([list(row) for row in station.rotation]))
            here = Rotation.from_matrix(np.array([list(row) for row in ideal.stations[i].rotation]))
            places.append(np.subtract(list(station.position), list(ideal.stations[i].position)))
            turns.append((here.inv() * there).as_rotvec())
            phases.append(list(station.phase))
            tilts.append(np.subtract(list(station.tilt), (-TILT, TILT)))
    for values, deviation in ((places, 0.02), (turns, 0.003), (phases, 0.001), (tilts, 0.001)):
        assert np.std(values, axis=0) == pytest.approx(deviation, rel=0.12)
        assert np.abs(np.mean(values, axis=0)).max() < 0.2 * deviation


def test_calibration_error_shifts_the_angles(make_config: Make) -> None:
    lighthouse = make(make_config, calibration_error=0.01)
    for _, s, p, angles in watch(lighthouse, 25):
        station = lighthouse.stations[s]
        expected = angle_of(station, np.array([0, 0, 0.7]) + SENSORS[0], station.tilt[p]) + station.phase[p]
        assert angles[0] == pytest.approx(expected, abs=3e-6)


def test_same_seed_gives_the_same_light(make_config: Make) -> None:
    options = {"noise": 0.001, "mishap": {"dropout": 0.1, "outlier": 0.1, "outlier_size": 0.1}}
    assert watch(make(make_config, seed=5, **options), 500) == watch(make(make_config, seed=5, **options), 500)
    assert watch(make(make_config, seed=5, **options), 500) != watch(make(make_config, seed=6, **options), 500)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1e30, -1e30])
def test_broken_motion_is_dark(make_config: Make, bad: float) -> None:
    assert watch(make(make_config), 60, (0.0, bad, 0.7)) == []


def station(position: Any, target: Any) -> dict[str, Any]:
    return {"position": list(position), "target": list(target)}


OK = station((0, 0, 2), (1, 0, 0))


@pytest.mark.parametrize(
    "changes",
    [
        {"rate": 101},
        {"noise": -0.1},
        {"noise": float("nan")},
        {"calibration_error": 0.2},
        {"calibration_error": float("nan")},
        {"position_error": float("inf")},
        {"attitude_error": float("nan")},
        {"mishap": {"dropout": float("nan")}},
        {"stations": [station((0, 0, 2), (0, 0, 2)), OK]},
        {"stations": [OK, station((0, 0, float("nan")), (0, 0, 0))]},
        {"stations": [OK, station((0, 0, 0), (0, 2000, 0))]},
    ],
)
def test_impossible_config_is_refused(make_config: Make, changes: dict[str, Any]) -> None:
    config = configure(make_config, **changes)
    one = dice(1)[0]
    assert lib.cf_lighthouse_init(ffi.new("cf_lighthouse_t *"), config, one, one, one) == (lib.CF_ERR_VALUE)
