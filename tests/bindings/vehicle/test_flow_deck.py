"""The flow deck against estimators dossier sections 5.7, 13.1, 13.2 and 17."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]

# range (m), standard deviation (m): section 13.1
RANGE_STD = [
    (0.1, 0.0025023),
    (0.5, 0.0025073),
    (1.0, 0.00253125),
    (2.0, 0.0030802),
    (2.5, 0.005),
    (3.0, 0.0132722),
    (4.0, 0.2025),
]


def make_deck(make_config: Make, seed: int = 1, **changes: float) -> Any:
    config = make_config("cf2").flow_deck
    for name, value in changes.items():
        setattr(config, name, value)
    random = ffi.new("cf_random_t *")
    lib.cf_random_init(random, seed, 0)
    deck = ffi.new("cf_flow_deck_t *")
    assert lib.cf_flow_deck_init(deck, ffi.addressof(config), random[0]) == lib.CF_OK
    return deck


def watch(
    deck: Any,
    ticks: int,
    height: float = 1.0,
    rotation: Any = None,
    velocity: Any = (0.0, 0.0, 0.0),
    rates: Any = (0.0, 0.0, 0.0),
    start: int = 1,
) -> tuple[list[Any], list[Any]]:
    """Return the ranges and the flows measured in a steady motion."""
    flat = np.eye(3).ravel() if rotation is None else rotation.as_matrix().ravel()
    flat = ffi.new("float[9]", flat.tolist())
    velocity, rates = ffi.new("float[3]", list(velocity)), ffi.new("float[3]", list(rates))
    tof, flow = ffi.new("tofMeasurement_t *"), ffi.new("flowMeasurement_t *")
    ranges, flows = [], []
    for tick in range(start, start + ticks):
        measured = lib.cf_flow_deck_step(deck, tick, height, flat, velocity, rates, tof, flow)
        if measured & lib.CF_FLOW_DECK_RANGE:
            ranges.append(ffi.new("tofMeasurement_t *", tof[0]))
        if measured & lib.CF_FLOW_DECK_FLOW:
            flows.append(ffi.new("flowMeasurement_t *", flow[0]))
    return ranges, flows


@pytest.fixture
def ideal(make_config: Make) -> Any:
    return make_deck(make_config, range_noise_scale=0.0, flow_noise=0.0)


@pytest.mark.parametrize(("distance", "deviation"), RANGE_STD)
def test_range_deviation_follows_the_table(distance: float, deviation: float) -> None:
    assert lib.cf_range_std(distance) == pytest.approx(deviation, rel=2e-5)


def test_rates_are_40_and_100_hz(ideal: Any) -> None:
    ranges, flows = watch(ideal, 1000)
    assert [r.timestamp for r in ranges] == list(range(25, 1001, 25))
    assert [f.timestamp for f in flows] == list(range(10, 1001, 10))


@pytest.mark.parametrize(("height", "millimeters"), [(0.0145, 15), (0.5, 500), (1.2344, 1234), (4.999, 4999)])
def test_range_is_in_whole_millimeters(ideal: Any, height: float, millimeters: int) -> None:
    ranges, _ = watch(ideal, 25, height=height)
    assert ranges[0].distance == pytest.approx(millimeters * 0.001, rel=1e-6)
    assert ranges[0].stdDev == pytest.approx(lib.cf_range_std(millimeters * 0.001), rel=1e-6)


@pytest.mark.parametrize("tilt", [0.1, 0.4, -1.0])
def test_range_is_measured_along_the_body(ideal: Any, tilt: float) -> None:
    ranges, _ = watch(ideal, 25, height=1.0, rotation=Rotation.from_euler("xz", [tilt, 1.0]))
    assert ranges[0].distance == pytest.approx(1.0 / np.cos(tilt), abs=6e-4)


@pytest.mark.parametrize("height", [5.0, 7.0, 1e9, float("inf"), float("nan")])
def test_far_floor_gives_no_range(make_config: Make, height: float) -> None:
    assert watch(make_deck(make_config), 500, height=height)[0] == []


def test_deck_that_looks_up_or_sideways_sees_nothing(ideal: Any) -> None:
    for tilt in (1.48, 2.0, np.pi):
        ranges, flows = watch(ideal, 100, rotation=Rotation.from_euler("y", tilt))
        assert (ranges, flows) == ([], [])


def test_below_the_floor_reads_zero(ideal: Any) -> None:
    ranges, _ = watch(ideal, 25, height=-0.01)
    assert ranges[0].distance == 0.0


@pytest.mark.parametrize("height", [0.5, 2.5, 3.0])
def test_range_noise_has_the_told_deviation(make_config: Make, height: float) -> None:
    ranges, _ = watch(make_deck(make_config), 25 * 3000, height=height)
    spread = np.std([r.distance for r in ranges])
    assert spread == pytest.approx(np.hypot(lib.cf_range_std(height), 0.001 / 12**0.5), rel=0.05)


# velocity (m/s), rates (rad/s), height (m): counts = round(10 k (v R22 / z -+ w)), k = 0.01 * 35 / 0.71674
FLOW = [
    ((0.0, 0.0), (0.0, 0.0), 1.0, (0, 0)),
    ((1.0, -2.0), (0.0, 0.0), 1.0, (5, -10)),
    ((1.0, -2.0), (0.0, 0.0), 0.5, (10, -20)),
    ((0.0, 0.0), (1.0, 2.0), 1.0, (-10, 5)),
    ((2.0, 1.0), (-1.0, 2.0), 1.0, (0, 0)),
    ((1.0, 0.0), (0.0, 0.0), 0.09, (49, 0)),  # the model assumes 0.1 m
]


@pytest.mark.parametrize(("velocity", "rates", "height", "counts"), FLOW)
def test_flow_counts_invert_the_model_of_the_filter(
    ideal: Any, velocity: Any, rates: Any, height: float, counts: Any
) -> None:
    _, flows = watch(ideal, 10, height=height, velocity=(*velocity, 0.0), rates=(*rates, 3.0))
    assert (flows[0].dpixelx, flows[0].dpixely) == counts


def test_flow_agrees_with_the_check_vector_of_the_filter(ideal: Any) -> None:
    """Section 17 E: rates (5.7, -11.4) deg/s predict (0.0971603, 0.0485801); here a hundred times that."""
    rates = np.deg2rad([5.7, -11.4, 0.0]) * 100
    _, flows = watch(ideal, 10, rates=rates)
    assert (flows[0].dpixelx, flows[0].dpixely) == (97.0, 49.0)


def test_flow_sees_the_velocity_in_the_body_frame(ideal: Any) -> None:
    _, flows = watch(ideal, 10, velocity=(2.0, 0.0, 0.0), rotation=Rotation.from_euler("z", np.pi / 2))
    assert (flows[0].dpixelx, flows[0].dpixely) == (0.0, -10.0)


def test_flow_tells_deviation_and_time(ideal: Any) -> None:
    _, flows = watch(ideal, 30)
    assert [f.dt for f in flows] == pytest.approx([0.01] * 3)
    assert {(f.stdDevX, f.stdDevY) for f in flows} == {(2.0, 2.0)}


def test_outlier_is_dropped_and_the_next_reading_spans_its_time(ideal: Any) -> None:
    _, flows = watch(ideal, 20, velocity=(30.0, 0.0, 0.0))
    assert flows == []
    _, flows = watch(ideal, 20, start=21)
    assert [f.dt for f in flows] == pytest.approx([0.03, 0.01])


def test_flow_is_blind_close_to_the_floor(ideal: Any) -> None:
    _, flows = watch(ideal, 50, height=0.079)
    assert flows == []
    _, flows = watch(ideal, 10, height=0.081, start=51)
    assert flows[0].dt == pytest.approx(0.01)


def test_flow_noise_has_the_asked_deviation(make_config: Make) -> None:
    _, flows = watch(make_deck(make_config, flow_noise=1.0), 50_000, velocity=(1.0, 0.0, 0.0))
    x = np.array([f.dpixelx for f in flows])
    assert x.std() == pytest.approx(np.hypot(1.0, 1 / 12**0.5), rel=0.05)
    assert x.mean() == pytest.approx(4.8832, abs=0.06)
    assert (x == np.rint(x)).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("range_noise_scale", -1.0),
        ("range_noise_scale", float("nan")),
        ("flow_noise", float("inf")),
        ("flow_std", 0.0),
    ],
)
def test_impossible_config_is_refused(make_config: Make, name: str, value: float) -> None:
    config = make_config("cf2").flow_deck
    setattr(config, name, value)
    deck = ffi.new("cf_flow_deck_t *")
    assert lib.cf_flow_deck_init(deck, ffi.addressof(config), ffi.new("cf_random_t *")[0]) == lib.CF_ERR_VALUE
