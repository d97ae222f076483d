"""Vehicles of both platforms for the tests of bindings/vehicle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

PLATFORMS = {"cf2": lib.CF_PLATFORM_CF2, "cf21bl": lib.CF_PLATFORM_CF21BL}

Make = Callable[..., Any]


@pytest.fixture
def make_config() -> Make:
    """Return a function that gives the default config of a platform; it lives as long as the test."""
    made = []  # a reference to a member does not keep its struct alive

    def make(platform: str = "cf2") -> Any:
        config = ffi.new("cf_vehicle_config_t *")
        assert lib.cf_vehicle_default_config(config, PLATFORMS[platform]) == lib.CF_OK
        made.append(config)
        return config

    return make


@pytest.fixture
def make_vehicle(make_config: Make) -> Make:
    """Return a function that makes a vehicle from a platform, after `change(config)`."""

    def make(
        platform: str = "cf2", change: Callable[[Any], None] | None = None, seed: int = 1, drone_id: int = 0
    ) -> Any:
        config = make_config(platform)
        if change is not None:
            change(config)
        vehicle = ffi.new("cf_vehicle_t *")
        assert lib.cf_vehicle_init(vehicle, config, seed, drone_id) == lib.CF_OK
        return vehicle

    return make


@pytest.fixture
def wrench() -> Make:
    """Return a function that gives force (world, N) and torque (body, N m) of a vehicle."""

    def call(
        vehicle: Any, rotation: Any = None, velocity: Any = (0.0, 0.0, 0.0), rates: Any = (0.0, 0.0, 0.0)
    ) -> tuple[np.ndarray, np.ndarray]:
        flat = np.eye(3).ravel() if rotation is None else np.asarray(rotation).ravel()
        force, torque = ffi.new("float[3]"), ffi.new("float[3]")
        lib.cf_vehicle_wrench(
            vehicle,
            ffi.new("float[9]", flat.tolist()),
            ffi.new("float[3]", list(velocity)),
            ffi.new("float[3]", list(rates)),
            force,
            torque,
        )
        return np.array(list(force)), np.array(list(torque))

    return call


@pytest.fixture
def run() -> Make:
    """Return a function that actuates a vehicle with constant ratios for some ticks."""

    def call(vehicle: Any, ratios: Any, ticks: int) -> None:
        array = ffi.new("uint16_t[4]", list(ratios))
        for _ in range(ticks):
            lib.cf_vehicle_actuate(vehicle, array)

    return call
