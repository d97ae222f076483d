"""Anchors: rates, order, geometry, noise, biases and mishaps of TWR, TDoA2 and TDoA3."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from sensor_parts import changed, dice

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]

TWR, TDOA2, TDOA3 = lib.CF_LOCO_TWR, lib.CF_LOCO_TDOA2, lib.CF_LOCO_TDOA3
PLACE = (0.4, -0.7, 1.1)
IDEAL = {"noise": 0.0, "bias": 0.0, "mishap": {}}


def configure(make_config: Make, **changes: Any) -> Any:
    return changed(make_config("cf2").loco, {**IDEAL, **changes})


def make(make_config: Make, mode: int, seed: int = 1, world: int = 1, **changes: Any) -> Any:
    """Return an ideal system with the default anchors, after changes."""
    loco, config = ffi.new("cf_loco_t *"), configure(make_config, **changes)
    status = lib.cf_loco_init(loco, config, mode, dice(seed)[0], dice(seed + 100)[0], dice(world)[0])
    assert status == lib.CF_OK
    return loco


def watch(loco: Any, ticks: int, position: Any = PLACE) -> list[tuple[int, int, int, float]]:
    """Return (tick, previous anchor, anchor, distance) of the rangings of a drone at rest."""
    place, ranging = ffi.new("float[3]", list(position)), ffi.new("cf_ranging_t *")
    seen = []
    for tick in range(ticks):
        if lib.cf_loco_step(loco, place, ranging):
            assert ranging.mode == loco.mode
            seen.append((tick, ranging.previous, ranging.anchor, ranging.distance))
    return seen


def distances(loco: Any, position: Any = PLACE) -> np.ndarray:
    anchors = np.array([list(row) for row in loco.config.anchors])
    return np.linalg.norm(anchors - np.array(position), axis=1)


@pytest.mark.parametrize(("rate", "count"), [(0, 0), (100, 100), (125, 125), (150, 150), (1000, 1000)])
def test_twr_asks_the_anchors_in_turn_at_its_rate(make_config: Make, rate: int, count: int) -> None:
    seen = watch(make(make_config, TWR, twr_rate=rate), 1000)
    assert [anchor for _, _, anchor, _ in seen] == [i % 8 for i in range(count)]


def test_tdoa2_compares_neighbors_in_turn(make_config: Make) -> None:
    seen = watch(make(make_config, TDOA2), 1000)
    assert len(seen) == 499  # the first packet has no predecessor
    assert [(a, b) for _, a, b, _ in seen] == [((i - 1) % 8, i % 8) for i in range(1, 500)]


def test_tdoa3_compares_anchors_at_random(make_config: Make) -> None:
    seen = watch(make(make_config, TDOA3), 20_000)
    pairs = Counter((a, b) for _, a, b, _ in seen)
    assert len(seen) == pytest.approx(10_000, abs=30)
    assert len(pairs) == 56
    assert max(pairs.values()) < 1.5 * min(pairs.values())


@pytest.mark.parametrize("mode", [TWR, TDOA2, TDOA3])
@pytest.mark.parametrize("position", [PLACE, (0.0, 0.0, 0.0), (-2.5, -2.5, 0.2), (7.0, 1.0, -0.3)])
def test_ideal_rangings_are_the_geometry(make_config: Make, mode: int, position: Any) -> None:
    loco = make(make_config, mode)
    truth = distances(loco, position)
    for _, a, b, distance in watch(loco, 500, position):
        assert distance == pytest.approx(truth[b] - (truth[a] if mode != TWR else 0.0), abs=2e-6)


def test_default_rates_lie_where_the_reference_has_them(make_config: Make) -> None:
    """docs/reference/vehicle.md#10: 100 to 150 ranges, 400 to 500 pairs per second."""
    config = make_config("cf2").loco
    for mode, low, high in ((TWR, 100, 150), (TDOA2, 400, 500), (TDOA3, 400, 500)):
        loco = ffi.new("cf_loco_t *")
        assert lib.cf_loco_init(loco, ffi.addressof(config), mode, dice(1)[0], dice(2)[0], dice(3)[0]) == lib.CF_OK
        assert low <= len(watch(loco, 10_000)) / 10 <= high


@pytest.mark.parametrize(("mode", "factor"), [(TWR, 1.0), (TDOA2, 2**0.5), (TDOA3, 2**0.5)])
def test_noise_is_that_of_the_arrivals(make_config: Make, mode: int, factor: float) -> None:
    loco = make(make_config, mode, noise=0.08, twr_rate=1000, tdoa_rate=1000)
    truth = distances(loco)
    errors = np.array([d - truth[b] + (truth[a] if mode != TWR else 0.0) for _, a, b, d in watch(loco, 20_000)])
    assert errors.std() == pytest.approx(0.08 * factor, rel=0.04)
    assert abs(errors.mean()) < 0.005


def test_consecutive_pairs_share_an_arrival(make_config: Make) -> None:
    """What makes one difference too large makes the next one too small."""
    loco = make(make_config, TDOA2, noise=0.1)
    truth = distances(loco)
    errors = np.array([d - truth[b] + truth[a] for _, a, b, d in watch(loco, 20_000)])
    assert np.corrcoef(errors[:-1], errors[1:])[0, 1] == pytest.approx(-0.5, abs=0.03)


def test_biases_are_constant_and_follow_their_deviation(make_config: Make) -> None:
    biases = []
    for world in range(200):
        loco = make(make_config, TWR, world=world, bias=0.2)
        biases.append(list(loco.bias))
    assert np.std(biases) == pytest.approx(0.2, rel=0.06)
    truth, bias = distances(loco), biases[-1]
    for _, _, b, distance in watch(loco, 200):
        assert distance == pytest.approx(max(truth[b] + bias[b], 0.0), abs=2e-6)


def test_distance_is_never_negative(make_config: Make) -> None:
    seen = watch(make(make_config, TWR, noise=1.0), 3000, (-2.5, -2.5, 0.2))
    at_the_anchor = [distance for _, _, anchor, distance in seen if anchor == 0]
    assert min(at_the_anchor) == 0.0
    assert max(at_the_anchor) > 0.0


def test_lost_ranges_have_the_asked_frequency_and_leave_the_noise_alone(make_config: Make) -> None:
    options = {"noise": 0.1, "twr_rate": 1000}
    everything = {tick: rest for tick, *rest in watch(make(make_config, TWR, **options), 10_000)}
    some = watch(make(make_config, TWR, **options, mishap={"dropout": 0.3}), 10_000)
    assert len(some) == pytest.approx(7000, abs=200)
    assert all(everything[tick] == rest for tick, *rest in some)


def test_a_lost_packet_costs_tdoa2_two_pairs(make_config: Make) -> None:
    seen = watch(make(make_config, TDOA2, tdoa_rate=1000, mishap={"dropout": 0.1}), 20_000)
    assert len(seen) / 20_000 == pytest.approx(0.81, abs=0.015)
    assert all(b == (a + 1) % 8 for _, a, b, _ in seen)


def test_outliers_are_always_farther(make_config: Make) -> None:
    loco = make(make_config, TWR, twr_rate=1000, mishap={"outlier": 0.05, "outlier_size": 2.0})
    truth = distances(loco)
    errors = np.array([d - truth[b] for _, _, b, d in watch(loco, 20_000)])
    wrong = np.abs(errors) > 1e-3
    assert wrong.mean() == pytest.approx(0.05, abs=0.006)
    assert errors[wrong].min() > 0.499
    assert errors[wrong].max() < 2.001


def test_outliers_of_tdoa2_come_in_pairs_of_opposite_sign(make_config: Make) -> None:
    loco = make(make_config, TDOA2, mishap={"outlier": 0.01, "outlier_size": 2.0})
    truth = distances(loco)
    errors = np.array([d - truth[b] + truth[a] for _, a, b, d in watch(loco, 100_000)])
    wrong = errors[np.abs(errors) > 1e-3]
    assert len(wrong) / len(errors) == pytest.approx(0.02, abs=0.004)
    assert (wrong > 0).mean() == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("mode", [TWR, TDOA2, TDOA3])
def test_lost_deck_hears_nothing(make_config: Make, mode: int) -> None:
    loco = make(make_config, mode)
    loco.is_lost = True
    assert watch(loco, 100) == []
    loco.is_lost = False
    assert watch(loco, 100) != []


@pytest.mark.parametrize("mode", [TWR, TDOA2, TDOA3])
def test_same_seed_gives_the_same_rangings(make_config: Make, mode: int) -> None:
    options = {"noise": 0.1, "mishap": {"dropout": 0.1, "outlier": 0.1, "outlier_size": 1.0}}
    one, same, other = (watch(make(make_config, mode, seed=seed, **options), 500) for seed in (5, 5, 6))
    assert one == same
    assert one != other


def anchors(i: int, value: float) -> list[list[float]]:
    return [[value if k == i else 0.0 for k in range(3)] for _ in range(8)]


@pytest.mark.parametrize(
    "changes",
    [
        {"twr_rate": 1001},
        {"tdoa_rate": 2**32 - 1},
        {"noise": float("nan")},
        {"noise": -1.0},
        {"bias": float("inf")},
        {"mishap": {"outlier": float("nan")}},
        {"anchors": anchors(0, float("nan"))},
        {"anchors": anchors(2, 1001.0)},
    ],
)
def test_impossible_config_is_refused(make_config: Make, changes: dict[str, Any]) -> None:
    config = configure(make_config, **changes)
    one = dice(1)[0]
    assert lib.cf_loco_init(ffi.new("cf_loco_t *"), config, TWR, one, one, one) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("mode", [-1, 0, 4])
def test_impossible_mode_is_refused(make_config: Make, mode: int) -> None:
    config, one = configure(make_config), dice(1)[0]
    mode = ffi.cast("cf_loco_mode_t", mode % 2**32)
    assert lib.cf_loco_init(ffi.new("cf_loco_t *"), config, mode, one, one, one) == lib.CF_ERR_VALUE
