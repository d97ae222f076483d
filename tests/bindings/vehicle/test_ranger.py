"""Ranging chips against docs/reference/vehicle.md#10 and docs/reference/estimators.md#13.1."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

FLAT = Rotation.identity()
PERIODS = {"multiranger": lib.CF_MULTIRANGER_TICKS, "zranger": lib.CF_ZRANGER_TICKS}


def make_rangers(*decks: str, seed: int = 1, noise: float = 1.0, **mishap: float) -> Any:
    config = ffi.new("cf_rangers_config_t *", {f"has_{deck}": True for deck in decks})
    rangers = ffi.new("cf_rangers_t *")
    lib.cf_rangers_init(rangers, config, noise, ffi.new("cf_mishap_config_t *", mishap), seed, 0)
    return rangers


def watch(rangers: Any, ticks: int, position: Any = (0, 0, 1), rotation: Rotation = FLAT) -> list[dict[int, int]]:
    """Return what was measured at each tick, from direction to mm, over a flat floor."""
    place = ffi.new("float[3]", list(position))
    matrix = ffi.new("float[9]", rotation.as_matrix().ravel().tolist())
    readings = ffi.new("uint16_t[6]")
    steps = []
    for _ in range(ticks):
        measured = lib.cf_rangers_step(rangers, place, matrix, ffi.NULL, readings)
        steps.append({i: readings[i] for i in range(lib.CF_RANGE_COUNT) if measured >> i & 1})
    return steps


@pytest.mark.parametrize(("deck", "directions"), [("multiranger", range(5)), ("zranger", [lib.CF_RANGE_DOWN])])
def test_each_deck_measures_its_directions_at_its_rate(deck: str, directions: Any) -> None:
    steps = watch(make_rangers(deck), 400)
    due = [i for i, step in enumerate(steps, start=1) if step]
    assert due == list(range(PERIODS[deck], 401, PERIODS[deck]))
    assert all(set(step) == set(directions) for step in steps if step)


def test_nothing_fitted_measures_nothing() -> None:
    rangers = make_rangers()
    before = bytes(ffi.buffer(rangers))
    assert not any(watch(rangers, 200))
    assert bytes(ffi.buffer(rangers)) == before


@pytest.mark.parametrize("tilt", [0.0, 20.0, 60.0])
def test_tilt_lengthens_the_range(tilt: float) -> None:
    steps = watch(make_rangers("zranger", noise=0.0), 25, (0, 0, 1.2), Rotation.from_euler("x", tilt, degrees=True))
    assert steps[-1][lib.CF_RANGE_DOWN] == pytest.approx(1200 / np.cos(np.radians(tilt)), abs=0.51)


@pytest.mark.parametrize("distance", [5.0, 5.5, 100.0])
def test_nothing_within_5_m_is_told(distance: float) -> None:
    steps = watch(make_rangers("zranger"), 25, (0, 0, distance))
    assert steps[-1] == {lib.CF_RANGE_DOWN: lib.CF_RANGE_NOTHING}


def test_sideways_over_a_bare_floor_there_is_nothing() -> None:
    steps = watch(make_rangers("multiranger"), 100)
    assert set(steps[-1].values()) == {lib.CF_RANGE_NOTHING}


@pytest.mark.parametrize("height", [0.5, 2.0, 3.0])
def test_noise_has_the_deviation_that_the_driver_tells(height: float) -> None:
    steps = watch(make_rangers("zranger"), 25 * 4000, (0, 0, height))
    ranges = [step[lib.CF_RANGE_DOWN] for step in steps if step]
    assert np.mean(ranges) == pytest.approx(1000 * height, abs=1.0)
    # whole millimeters add a twelfth of a square millimeter
    expected = np.hypot(1000 * lib.cf_range_std(height), 12**-0.5)
    assert np.std(ranges) == pytest.approx(expected, rel=0.05)


def test_readings_drop_out() -> None:
    steps = watch(make_rangers("zranger", dropout=0.3), 25 * 2000)
    assert sum(map(bool, steps)) == pytest.approx(1400, abs=100)


def test_fitting_a_deck_leaves_all_other_noise_as_it_was(make_vehicle: Any) -> None:
    def fit(config: Any) -> None:
        config.rangers.has_multiranger = config.rangers.has_zranger = True

    bare, fitted = make_vehicle(), make_vehicle(change=fit)
    assert bytes(ffi.buffer(ffi.addressof(bare, "imu"))) == bytes(ffi.buffer(ffi.addressof(fitted, "imu")))
    assert bytes(ffi.buffer(ffi.addressof(bare, "mocap"))) == bytes(ffi.buffer(ffi.addressof(fitted, "mocap")))


def test_a_flow_deck_carries_the_z_ranger_already(make_vehicle: Any) -> None:
    def fit(config: Any) -> None:
        config.positioning = lib.CF_POSITIONING_FLOW
        config.rangers.has_zranger = True

    assert not make_vehicle(change=fit).rangers.fitted.has_zranger
