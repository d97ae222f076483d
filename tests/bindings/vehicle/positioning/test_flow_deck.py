"""The chips of the flow deck against docs/reference/estimators.md#5.7, #13.1, #13.2 and #17."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]

# range (m), standard deviation (m): docs/reference/estimators.md#13.1
RANGE_STD = [
    (0.1, 0.0025023),
    (0.5, 0.0025073),
    (1.0, 0.00253125),
    (2.0, 0.0030802),
    (2.5, 0.005),
    (3.0, 0.0132722),
    (4.0, 0.2025),
]


def make_deck(make_config: Make, seed: int = 1, **changes: Any) -> Any:
    config = changed(make_config("cf2").flow_deck, changes)
    random, deck = dice(seed), ffi.new("cf_flow_deck_t *")
    assert lib.cf_flow_deck_init(deck, config, random[0], lib.cf_random_split(random)) == lib.CF_OK
    return deck


def watch(
    deck: Any,
    ticks: int,
    height: float = 1.0,
    rotation: Any = None,
    velocity: Any = (0.0, 0.0, 0.0),
    rates: Any = (0.0, 0.0, 0.0),
) -> tuple[dict[int, int], dict[int, Any]]:
    """Return ranges (mm) and flow registers by tick, in a steady motion; the first tick is 1."""
    flat = np.eye(3).ravel() if rotation is None else rotation.as_matrix().ravel()
    flat = ffi.new("float[9]", flat.tolist())
    velocity, rates = ffi.new("float[3]", list(velocity)), ffi.new("float[3]", list(rates))
    reading = ffi.new("cf_flow_reading_t *")
    ranges, flows = {}, {}
    for tick in range(1, 1 + ticks):
        measured = lib.cf_flow_deck_step(deck, height, flat, velocity, rates, reading)
        if measured & lib.CF_FLOW_DECK_RANGE:
            ranges[tick] = reading.range
        if measured & lib.CF_FLOW_DECK_FLOW:
            flows[tick] = ffi.new("cf_flow_reading_t *", reading[0])
    return ranges, flows


def counts_of(flow: Any) -> tuple[int, int]:
    """Return the counts along x and y of the body: the chip lies turned (docs/reference/estimators.md#13.2)."""
    return -flow.delta_y, -flow.delta_x


@pytest.fixture
def ideal(make_config: Make) -> Any:
    return make_deck(make_config, range_noise_scale=0.0, flow_noise=0.0)


@pytest.mark.parametrize(("distance", "deviation"), RANGE_STD)
def test_range_deviation_follows_the_table(distance: float, deviation: float) -> None:
    assert lib.cf_range_std(distance) == pytest.approx(deviation, rel=2e-5)


def test_rates_are_40_and_100_hz(ideal: Any) -> None:
    ranges, flows = watch(ideal, 1000)
    assert list(ranges) == list(range(25, 1001, 25))
    assert list(flows) == list(range(10, 1001, 10))


@pytest.mark.parametrize(("height", "millimeters"), [(0.0145, 15), (0.5, 500), (1.2344, 1234), (4.999, 4999)])
def test_range_is_in_whole_millimeters(ideal: Any, height: float, millimeters: int) -> None:
    assert watch(ideal, 25, height=height)[0] == {25: millimeters}


@pytest.mark.parametrize("tilt", [0.1, 0.4, -1.0])
def test_range_is_measured_along_the_body(ideal: Any, tilt: float) -> None:
    ranges, _ = watch(ideal, 25, height=1.0, rotation=Rotation.from_euler("xz", [tilt, 1.0]))
    assert ranges[25] == pytest.approx(1000.0 / np.cos(tilt), abs=0.6)


@pytest.mark.parametrize("height", [5.0, 7.0, 1e9, float("inf"), float("nan")])
def test_far_floor_reads_as_nothing(make_config: Make, height: float) -> None:
    assert set(watch(make_deck(make_config), 500, height=height)[0].values()) == {lib.CF_RANGE_NOTHING}


def test_deck_that_looks_up_or_sideways_sees_nothing(ideal: Any) -> None:
    for tilt in (1.48, 2.0, np.pi):
        ranges, flows = watch(ideal, 100, rotation=Rotation.from_euler("y", tilt))
        assert set(ranges.values()) == {lib.CF_RANGE_NOTHING}
        assert {flow.motion for flow in flows.values()} == {lib.CF_FLOW_NO_MOTION}


def test_lost_deck_sees_nothing(ideal: Any) -> None:
    ideal.is_lost = True
    ranges, flows = watch(ideal, 100)
    assert set(ranges.values()) == {lib.CF_RANGE_NOTHING}
    assert {(flow.motion, flow.squal) for flow in flows.values()} == {(lib.CF_FLOW_NO_MOTION, 0)}


def test_below_the_floor_reads_zero(ideal: Any) -> None:
    assert watch(ideal, 25, height=-0.01)[0] == {25: 0}


@pytest.mark.parametrize("height", [0.5, 2.5, 3.0])
def test_range_noise_has_the_told_deviation(make_config: Make, height: float) -> None:
    ranges, _ = watch(make_deck(make_config), 25 * 3000, height=height)
    spread = 0.001 * np.std(list(ranges.values()))
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
    assert counts_of(flows[10]) == counts


def test_flow_agrees_with_the_check_vector_of_the_filter(ideal: Any) -> None:
    """Rates (5.7, -11.4) deg/s predict (0.0971603, 0.0485801); here a hundred times that.

    docs/reference/estimators.md#17.E.
    """
    rates = np.deg2rad([5.7, -11.4, 0.0]) * 100
    _, flows = watch(ideal, 10, rates=rates)
    assert counts_of(flows[10]) == (97, 49)


def test_flow_sees_the_velocity_in_the_body_frame(ideal: Any) -> None:
    _, flows = watch(ideal, 10, velocity=(2.0, 0.0, 0.0), rotation=Rotation.from_euler("z", np.pi / 2))
    assert counts_of(flows[10]) == (0, -10)


@pytest.mark.parametrize("speed", [1e4, 1e30])
def test_registers_are_16_bits_wide(ideal: Any, speed: float) -> None:
    _, flows = watch(ideal, 20, velocity=(speed, -speed, 0.0), height=0.1)
    assert {counts_of(flow) for flow in flows.values()} == {(32767, -32767)}


@pytest.mark.parametrize("height", [0.0, 0.015, 0.081])
def test_flow_says_on_the_floor_that_it_stands_still(ideal: Any, height: float) -> None:
    _, flows = watch(ideal, 10, height=height)
    assert flows[10].motion == lib.CF_FLOW_MOTION
    assert counts_of(flows[10]) == (0, 0)


def test_flow_noise_has_the_asked_deviation(make_config: Make) -> None:
    _, flows = watch(make_deck(make_config, flow_noise=1.0), 50_000, velocity=(1.0, 0.0, 0.0))
    x = np.array([counts_of(flow)[0] for flow in flows.values()])
    assert x.std() == pytest.approx(np.hypot(1.0, 1 / 12**0.5), rel=0.05)
    assert x.mean() == pytest.approx(4.8832, abs=0.06)


@pytest.mark.parametrize(("noise", "shutter"), [(0.0, 0), (0.4, 0), (1.0, 710), (2.0, 1962), (100.0, 65535)])
def test_shutter_shows_the_noise(make_config: Make, noise: float, shutter: int) -> None:
    """The driver's rule upside down: 0.0007984 shutter + 0.4335 (docs/reference/estimators.md#13.2)."""
    _, flows = watch(make_deck(make_config, flow_noise=noise), 10)
    assert flows[10].shutter == shutter


def mishap(**numbers: float) -> dict[str, float]:
    return {"dropout": 0.0, "outlier": 0.0, "outlier_size": 0.0, **numbers}


def test_drop_outs_are_no_readings_and_leave_the_noise_alone(make_config: Make) -> None:
    everything = watch(make_deck(make_config), 50_000)
    some = watch(make_deck(make_config, range_mishap=mishap(dropout=0.5), flow_mishap=mishap(dropout=0.2)), 50_000)
    assert len(some[0]) == pytest.approx(1000, abs=100)
    assert len(some[1]) == pytest.approx(4000, abs=120)
    assert all(everything[0][tick] == millimeters for tick, millimeters in some[0].items())
    assert all(counts_of(everything[1][tick]) == counts_of(flow) for tick, flow in some[1].items())


def test_outliers_have_their_frequency_and_size(make_config: Make) -> None:
    deck = make_deck(
        make_config,
        range_noise_scale=0.0,
        flow_noise=0.0,
        range_mishap=mishap(outlier=0.1, outlier_size=0.8),
        flow_mishap=mishap(outlier=0.1, outlier_size=40.0),
    )
    ranges, flows = watch(deck, 50_000)
    wrong = np.abs([millimeters - 1000 for millimeters in ranges.values() if millimeters != 1000])
    assert len(wrong) == pytest.approx(200, abs=50)
    assert wrong.min() >= 199
    assert wrong.max() <= 801
    x = np.abs([counts_of(flow)[0] for flow in flows.values() if counts_of(flow)[0]])
    assert len(x) == pytest.approx(500, abs=80)
    assert x.min() >= 10
    assert x.max() <= 40


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("range_noise_scale", -1.0),
        ("range_noise_scale", float("nan")),
        ("flow_noise", float("inf")),
        ("range_mishap", mishap(outlier=float("nan"))),
        ("flow_mishap", mishap(outlier_size=-1.0)),
    ],
)
def test_impossible_config_is_refused(make_config: Make, name: str, value: Any) -> None:
    config = make_config("cf2").flow_deck
    setattr(config, name, value)
    deck, dice = ffi.new("cf_flow_deck_t *"), ffi.new("cf_random_t *")[0]
    assert lib.cf_flow_deck_init(deck, ffi.addressof(config), dice, dice) == lib.CF_ERR_VALUE
