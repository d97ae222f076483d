"""Motion capture: rate, latency, noise, loss."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]


def make_mocap(make_config: Make, seed: int = 1, **changes: Any) -> Any:
    config = changed(make_config("cf2").mocap, changes)
    random, mocap = dice(seed), ffi.new("cf_mocap_t *")
    assert lib.cf_mocap_init(mocap, config, random[0], lib.cf_random_split(random)) == lib.CF_OK
    return mocap


def watch(mocap: Any, ticks: int, quat: Any = (1.0, 0.0, 0.0, 0.0), start: int = 0) -> list[tuple[int, Any]]:
    """Move along x by 1 m per tick; return the arrival ticks and poses."""
    pose = ffi.new("poseMeasurement_t *")
    quat = ffi.new("float[4]", list(quat))
    arrived = []
    for tick in range(start, start + ticks):
        if lib.cf_mocap_step(mocap, ffi.new("float[3]", [tick, -1.0, 0.5]), quat, pose):
            arrived.append((tick, ffi.new("poseMeasurement_t *", pose[0])))
    return arrived


@pytest.mark.parametrize(
    ("rate", "latency"), [(100, 8), (100, 0), (200, 5), (1000, 0), (1000, 31), (300, 12), (30, 100), (1, 3), (100, 310)]
)
def test_rate_and_latency_are_exact(make_config: Make, rate: int, latency: int) -> None:
    mocap = make_mocap(make_config, rate=rate, latency_ms=latency, position_noise=0.0)
    arrived = watch(mocap, 2000 + latency)
    sampled = [
        t for t in range(2000 + latency) if ((t + 1) * rate + 1000 - rate) // 1000 > (t * rate + 1000 - rate) // 1000
    ]
    assert [tick for tick, _ in arrived] == [t + latency for t in sampled if t < 2000]
    assert [pose.x for _, pose in arrived] == [float(t) for t in sampled if t < 2000]
    assert len([t for t in sampled if t < 2000]) == 2 * rate


def test_default_arrives_every_ten_milliseconds_eight_late(make_config: Make) -> None:
    assert [tick for tick, _ in watch(make_mocap(make_config), 40)] == [8, 18, 28, 38]


def test_rate_zero_is_off(make_config: Make) -> None:
    assert watch(make_mocap(make_config, rate=0), 3000) == []


def test_filter_is_told_the_deviations_of_the_client(make_config: Make) -> None:
    _, pose = watch(make_mocap(make_config), 10)[0]
    assert pose.stdDevPos == pytest.approx(0.003)
    assert pose.stdDevQuat == pytest.approx(0.04)


def test_ideal_pose_is_the_true_pose(make_config: Make) -> None:
    mocap = make_mocap(make_config, position_noise=0.0, attitude_noise=0.0)
    _, pose = watch(mocap, 10, quat=(0.5, -0.5, 0.5, 0.5))[0]
    assert (pose.x, pose.y, pose.z) == (0.0, -1.0, 0.5)
    assert (pose.quat.w, pose.quat.x, pose.quat.y, pose.quat.z) == (0.5, -0.5, 0.5, 0.5)


def test_noise_has_the_asked_deviation(make_config: Make) -> None:
    mocap = make_mocap(make_config, rate=1000, latency_ms=0, position_noise=0.001, attitude_noise=0.002)
    truth = Rotation.from_euler("xyz", [0.3, -0.2, 2.0])
    x, y, z, w = truth.as_quat()
    poses = [pose for _, pose in watch(mocap, 10_000, quat=(w, x, y, z))]
    position = np.array([(pose.y + 1.0, pose.z - 0.5) for pose in poses])
    quat = np.array([(pose.quat.x, pose.quat.y, pose.quat.z, pose.quat.w) for pose in poses])
    turn = (truth.inv() * Rotation.from_quat(quat)).as_rotvec()
    assert position.std(axis=0) == pytest.approx(0.001, rel=0.04)
    assert turn.std(axis=0) == pytest.approx(0.002, rel=0.04)
    assert np.abs(position.mean(axis=0)).max() < 5e-5
    assert np.abs(turn.mean(axis=0)).max() < 1e-4
    assert np.linalg.norm(quat, axis=1) == pytest.approx(1.0, abs=1e-6)


def test_lost_drone_is_not_seen_but_poses_under_way_arrive(make_config: Make) -> None:
    mocap = make_mocap(make_config)
    assert [tick for tick, _ in watch(mocap, 12)] == [8]
    mocap.is_lost = True
    assert [tick for tick, _ in watch(mocap, 100, start=12)] == [18]
    mocap.is_lost = False
    assert [tick for tick, _ in watch(mocap, 30, start=112)] == [128, 138]


def test_drop_outs_have_the_asked_frequency_and_leave_the_noise_alone(make_config: Make) -> None:
    everything = watch(make_mocap(make_config, rate=1000, latency_ms=0), 10_000)
    some = watch(make_mocap(make_config, rate=1000, latency_ms=0, mishap={"dropout": 0.3}), 10_000)
    assert len(some) == pytest.approx(7000, abs=200)
    same = {tick: (pose.x, pose.y, pose.quat.x) for tick, pose in everything}
    assert all(same[tick] == (pose.x, pose.y, pose.quat.x) for tick, pose in some)


def test_outliers_are_off_by_a_quarter_of_their_size_to_all_of_it_in_any_direction(make_config: Make) -> None:
    quiet = {"rate": 1000, "latency_ms": 0, "position_noise": 0.0}
    poses = watch(make_mocap(make_config, **quiet, mishap={"outlier": 0.1, "outlier_size": 0.8}), 10_000)
    errors = np.array([(pose.x - tick, pose.y + 1.0, pose.z - 0.5) for tick, pose in poses])
    distances = np.linalg.norm(errors, axis=1)
    wrong = distances > 0.01
    assert wrong.sum() == pytest.approx(1000, abs=100)
    assert distances[wrong].min() > 0.199
    assert distances[wrong].max() < 0.801
    assert np.abs(errors[wrong].mean(axis=0)).max() < 0.05


def test_tick_may_wrap_around(make_config: Make) -> None:
    mocap = make_mocap(make_config, position_noise=0.0)
    mocap.tick = 2**32 - 3
    assert [tick for tick, _ in watch(mocap, 40)] == [8, 18, 28, 38]


@pytest.mark.parametrize(
    ("changes", "status"),
    [
        ({"rate": 1001}, lib.CF_ERR_VALUE),
        ({"rate": 1000, "latency_ms": 32}, lib.CF_ERR_CAPACITY),
        ({"rate": 100, "latency_ms": 320}, lib.CF_ERR_CAPACITY),
        ({"rate": 1000, "latency_ms": 2**32 - 1}, lib.CF_ERR_CAPACITY),
        ({"position_noise": -0.001}, lib.CF_ERR_VALUE),
        ({"attitude_noise": float("nan")}, lib.CF_ERR_VALUE),
        ({"position_std": 0.0}, lib.CF_ERR_VALUE),
        ({"attitude_std": float("inf")}, lib.CF_ERR_VALUE),
        ({"mishap": {"dropout": 1.1}}, lib.CF_ERR_VALUE),
    ],
)
def test_impossible_config_is_refused(make_config: Make, changes: dict[str, float], status: int) -> None:
    config = make_config("cf2").mocap
    for name, value in changes.items():
        setattr(config, name, value)
    mocap = ffi.new("cf_mocap_t *")
    dice = ffi.new("cf_random_t *")[0]
    assert lib.cf_mocap_init(mocap, ffi.addressof(config), dice, dice) == status


# ----------------------------------------------------------------------------------------- spells


def seconds_of(mocap: Any, seconds: int) -> list[tuple[int, Any]]:
    return watch(mocap, 1000 * seconds)


def test_gaps_are_bursts(make_config: Make) -> None:
    gap = {"rate": 2.0, "time": 0.1}
    frames = [round(pose.x) // 10 for _, pose in seconds_of(make_mocap(make_config, gap=gap), 200)]
    holes = np.diff(frames) - 1
    holes = holes[holes > 0]
    # one begins twice per second of sight, and lasts 1 to 21 frames
    assert 250 < len(holes) < 400
    assert holes.max() <= 21
    assert 9 < holes.mean() < 12


@pytest.mark.parametrize("kind", ["jump", "swap"])
def test_shifted_pose_stays_off_by_the_same_for_a_while(make_config: Make, kind: str) -> None:
    shift = {"spell": {"rate": 1.0, "time": 0.2}, "size": 0.02, "angle": 0.1}
    mocap = make_mocap(make_config, position_noise=0.0, attitude_noise=0.0, **{kind: shift})
    seen = [(round(tick - 8), pose) for tick, pose in seconds_of(mocap, 100)]
    off = np.array([[pose.x - tick, pose.y + 1.0, pose.z - 0.5] for tick, pose in seen])
    angle = np.array([2 * np.arccos(min(1.0, abs(pose.quat.w))) for _, pose in seen])
    length = np.linalg.norm(off, axis=1)
    wrong = length > 0.01
    assert length[wrong] == pytest.approx(0.02, abs=0.008)  # x grows to 1e5 m, in float32
    assert angle[wrong] == pytest.approx(0.1, abs=1e-3)
    assert angle[~wrong].max() < 1e-3
    begins = np.flatnonzero(np.diff(wrong.astype(int)) == 1)
    assert 60 < len(begins) < 110
    assert 0.1 < wrong.mean() < 0.25
    assert np.ptp(off[begins[0] + 1 : begins[0] + 3, 1]) < 1e-6


def test_busy_radio_is_late_by_up_to_so_much_and_keeps_the_order(make_config: Make) -> None:
    mocap = make_mocap(make_config, position_noise=0.0, busy={"rate": 1.0, "time": 0.3}, busy_ms=50)
    arrived = seconds_of(mocap, 100)
    age = np.array([tick - pose.x for tick, pose in arrived])
    assert len(arrived) == pytest.approx(10000, abs=6)
    assert np.all(np.diff([pose.x for _, pose in arrived]) > 0)
    assert age.min() == pytest.approx(8, abs=0.01)
    assert 40 < age.max() <= 58 + 0.01
    assert 0.1 < np.mean(age > 8.5) < 0.4


def test_spells_leave_the_noise_as_it_was(make_config: Make) -> None:
    calm = {tick: pose.y for tick, pose in seconds_of(make_mocap(make_config), 20)}
    gap = {"rate": 2.0, "time": 0.1}
    wild = {tick: pose.y for tick, pose in seconds_of(make_mocap(make_config, gap=gap), 20)}
    assert len(wild) < len(calm)
    assert all(calm[tick] == y for tick, y in wild.items())


@pytest.mark.parametrize("quality", ["GOOD", "TYPICAL", "POOR"])
def test_every_quality_can_be_flown(make_config: Make, quality: str) -> None:
    config = make_config("cf2").mocap
    assert lib.cf_mocap_of_quality(ffi.addressof(config), getattr(lib, f"CF_MOCAP_{quality}")) == lib.CF_OK
    random, mocap = dice(1), ffi.new("cf_mocap_t *")
    assert lib.cf_mocap_init(mocap, ffi.addressof(config), random[0], lib.cf_random_split(random)) == lib.CF_OK
    assert len(watch(mocap, 5000)) > 300


def test_unknown_quality_is_refused(make_config: Make) -> None:
    config = make_config("cf2").mocap
    assert lib.cf_mocap_of_quality(ffi.addressof(config), 3) == lib.CF_ERR_UNKNOWN
    assert config.rate == 100


@pytest.mark.parametrize(
    "changes",
    [
        {"gap": {"rate": -1.0, "time": 0.1}},
        {"gap": {"rate": 1.0, "time": float("nan")}},
        {"jump": {"size": 11.0}},
        {"swap": {"angle": 3.3}},
        {"busy": {"rate": 101.0}},
        {"busy_ms": 1001},
    ],
)
def test_spells_outside_their_range_are_refused(make_config: Make, changes: dict[str, Any]) -> None:
    config = changed(make_config("cf2").mocap, changes)
    random, mocap = dice(1), ffi.new("cf_mocap_t *")
    assert lib.cf_mocap_init(mocap, config, random[0], random[0]) == lib.CF_ERR_VALUE
