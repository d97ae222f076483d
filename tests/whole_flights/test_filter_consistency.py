"""Is the filter honest when the world is what it assumes: normalized errors and innovations squared (NEES, NIS).

The truth is drawn from the filter's own model: its equations of flight (docs/reference/estimators.md#4.4), the noise
that it adds every millisecond, and measurements with the deviations in their items. Then the mean over several filters
of the normalized error squared has a chi-squared distribution of known degrees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from crazychoir_fw._core import ffi, lib

FILTERS = 20
SECONDS = 8.0
SETTLED = 1.5  # [s], by then nothing is left of the start
INTERVAL = 0.01  # [s], of predictions and measurements
TICKS = 10
GRAVITY = 9.81
BAND = (0.025, 0.975)
ANCHORS = np.array([[-2.5, -2.5, 0.2], [-2.5, 2.5, 2.4], [2.5, 2.5, 0.2], [2.5, -2.5, 2.4]])


@dataclass
class Truth:
    """`FILTERS` drones at once: position (m, world), velocity (m/s, body), attitude."""

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    attitude: Rotation

    def fly(self, thrust: float, rates: NDArray, random: np.random.Generator, scale: float) -> None:
        """Advance by one interval with a specific thrust (m/s^2) and body rates (rad/s), by the filter's equations."""
        dt, down = INTERVAL, np.array([0.0, 0.0, -GRAVITY])
        body_gravity = self.attitude.inv().apply(np.tile(down, (FILTERS, 1)))
        acceleration = (
            np.array([0.0, 0.0, thrust]) + body_gravity - np.cross(np.tile(rates, (FILTERS, 1)), self.velocity)
        )
        self.position += (
            self.attitude.apply(self.velocity * dt + np.array([0, 0, thrust]) * dt**2 / 2) + down * dt**2 / 2
        )
        self.velocity = self.velocity + acceleration * dt
        self.attitude = self.attitude * Rotation.from_rotvec(rates * dt)
        # ten times the noise of a millisecond
        tick = 1e-3
        acc, gyro = np.array([0.5, 0.5, 1.0]), 0.1
        draw = lambda: scale * np.sqrt(TICKS) * random.standard_normal((FILTERS, 3))
        self.position += draw() * acc * tick**2
        self.velocity = self.velocity + draw() * acc * tick
        self.attitude = self.attitude * Rotation.from_rotvec(draw() * gyro * tick)


def start(random: np.random.Generator) -> tuple[Truth, list[Any], Any]:
    """Return the truth, filters that start where it is, within their deviations, and their parameters."""
    params = ffi.new("kalmanCoreParams_t *")
    lib.kalmanCoreDefaultParams(params)
    params.stdDevInitialPosition_xy = params.stdDevInitialPosition_z = 0.01
    params.initialZ = 1.0
    filters = [ffi.new("kalmanCoreData_t *") for _ in range(FILTERS)]
    for core in filters:
        lib.kalmanCoreInit(core, params, 0)
    small = 0.01 * random.standard_normal((3, FILTERS, 3))
    return Truth(small[0] + [0, 0, 1.0], small[1], Rotation.from_rotvec(small[2])), filters, params


class Beliefs:
    """State, attitude (w, x, y, z) and covariance of all filters, as views of their memory."""

    def __init__(self, filters: list[Any]) -> None:
        view = lambda member: [np.frombuffer(ffi.buffer(member(core)), np.float32) for core in filters]
        self._states, self._attitudes, self._covariances = (
            view(lambda core: core.S),
            view(lambda core: core.q),
            view(lambda core: core.P),
        )

    def read(self) -> tuple[NDArray, NDArray, NDArray]:
        """Return copies, shapes (FILTERS, 9), (FILTERS, 4) and (FILTERS, 9, 9)."""
        covariance = np.array(self._covariances, float).reshape(-1, 9, 9)
        return np.array(self._states, float), np.array(self._attitudes, float), covariance


Measure = Callable[[NDArray, NDArray, int, np.random.Generator], tuple[str, Any]]


def position(place: NDArray, quat: NDArray, step: int, random: np.random.Generator) -> tuple[str, Any]:
    measured = place + 0.01 * random.standard_normal(3)
    return "kalmanCoreUpdateWithPosition", ffi.new("positionMeasurement_t *", {"pos": list(measured), "stdDev": 0.01})


def pose(place: NDArray, quat: NDArray, step: int, random: np.random.Generator) -> tuple[str, Any]:
    measured = place + 0.01 * random.standard_normal(3)
    a, b, c = 0.5 * 0.02 * random.standard_normal(3)
    x, y, z, w = quat
    turned = (
        x + w * a + y * c - z * b,
        y + w * b + z * a - x * c,
        z + w * c + x * b - y * a,
        w - x * a - y * b - z * c,
    )
    x, y, z, w = np.array(turned) / np.linalg.norm(turned)
    content = {"pos": list(measured), "quat": {"x": x, "y": y, "z": z, "w": w}, "stdDevPos": 0.01, "stdDevQuat": 0.02}
    return "kalmanCoreUpdateWithPose", ffi.new("poseMeasurement_t *", content)


def distance(place: NDArray, quat: NDArray, step: int, random: np.random.Generator) -> tuple[str, Any]:
    anchor = ANCHORS[step % len(ANCHORS)]
    measured = np.linalg.norm(place - anchor) + 0.01 * random.standard_normal()
    content = {"pos": list(anchor), "distance": measured, "stdDev": 0.01}
    return "kalmanCoreUpdateWithDistance", ffi.new("distanceMeasurement_t *", content)


def difference(place: NDArray, quat: NDArray, step: int, random: np.random.Generator) -> tuple[str, Any]:
    a, b = ANCHORS[step % len(ANCHORS)], ANCHORS[(step + 1) % len(ANCHORS)]
    content = {
        "anchorPositions": [dict(zip("xyz", anchor, strict=True)) for anchor in (a, b)],
        "distanceDiff": np.linalg.norm(place - b) - np.linalg.norm(place - a) + 0.02 * random.standard_normal(),
        "stdDev": 0.02,
    }
    return "kalmanCoreUpdateWithTdoaUnfiltered", ffi.new("tdoaMeasurement_t *", content)


def innovations_squared(was: tuple[NDArray, ...], now: tuple[NDArray, ...]) -> NDArray:
    """Return NIS of scalar updates, shape (FILTERS,).

    With an innovation e of variance s the state moves by P H' e / s and its variances shrink by (P H')^2 / s.
    """
    before, after = (np.diagonal(covariance, axis1=1, axis2=2) for covariance in (was[2], now[2]))
    clearest = np.argmax((before - after) / before, axis=1)
    row = np.arange(FILTERS)
    return (now[0] - was[0])[row, clearest] ** 2 / (before - after)[row, clearest]


def errors_squared(belief: tuple[NDArray, ...], truth: Truth) -> NDArray:
    """Return NEES of position, velocity and attitude of finalized filters, shape (FILTERS, 3)."""
    state, attitude, covariance = belief
    estimated = Rotation.from_quat(attitude[:, [1, 2, 3, 0]])
    errors = (
        state[:, 0:3] - truth.position,
        state[:, 3:6] - truth.velocity,
        (truth.attitude.inv() * estimated).as_rotvec(),
    )
    squares = []
    for k, error in enumerate(errors):
        block = covariance[:, 3 * k : 3 * k + 3, 3 * k : 3 * k + 3]
        squares.append(np.einsum("ni,ni->n", error, np.linalg.solve(block, error[:, :, None])[:, :, 0]))
    return np.stack(squares, axis=1)


def fly(measure: Measure, scale: float = 1.0, seed: int = 1) -> tuple[NDArray, NDArray]:
    """Return NEES, shape (T, FILTERS, 3), and NIS, shape (T, FILTERS), behind the start.

    Args:
        measure: The measurements for the filters.
        scale: Of the noise of the truth; 1 is what the filter assumes.
        seed: Of all noise.
    """
    random = np.random.default_rng(seed)
    truth, filters, params = start(random)
    beliefs, acc, gyro = Beliefs(filters), ffi.new("Axis3f *"), ffi.new("Axis3f *")
    nees, nis = [], []
    for step in range(round(SECONDS / INTERVAL)):
        now = (step + 1) * TICKS
        rates = np.array([0.3 * np.cos(0.02 * step), 0.3 * np.sin(0.017 * step), 0.2])
        thrust = GRAVITY + 0.5 * np.sin(0.01 * step)
        truth.fly(thrust, rates, random, scale)
        acc.z, (gyro.x, gyro.y, gyro.z) = thrust, rates
        for core in filters:
            lib.kalmanCorePredict(core, params, acc, gyro, now, True)
            for tick in range(now - TICKS + 1, now + 1):
                lib.kalmanCoreAddProcessNoise(core, params, tick)
            lib.kalmanCoreFinalize(core)
        was = beliefs.read()
        quats = truth.attitude.as_quat()
        measured = [measure(truth.position[i], quats[i], step, random) for i in range(FILTERS)]
        for core, (name, measurement) in zip(filters, measured, strict=True):
            getattr(lib, name)(core, measurement)
        updated = beliefs.read()
        for core in filters:
            lib.kalmanCoreFinalize(core)
        if now >= 1000 * SETTLED:
            nees.append(errors_squared(beliefs.read(), truth))
            if measure in (position, pose):  # several numbers: the first of them, x
                first = np.array([measurement.pos[0] for _, measurement in measured])
                nis.append((first - was[0][:, 0]) ** 2 / (was[2][:, 0, 0] + 0.01**2))
            else:
                nis.append(innovations_squared(was, updated))
    return np.array(nees), np.array(nis)


def share_in_band(squares: NDArray, degrees: int) -> float:
    """Return the share of instants at which the mean over the filters is in its 95 % band; shape (T, FILTERS)."""
    low, high = chi2.ppf(BAND, degrees * FILTERS) / FILTERS
    mean = squares.mean(axis=1)
    return float(np.mean((mean >= low) & (mean <= high)))


@pytest.mark.parametrize("measure", [position, pose, distance, difference], ids=lambda f: f.__name__)
def test_matched_filter_knows_its_errors(measure: Measure) -> None:
    """Of three seeds together: errors last for half a second, so that one flight has few instants of its own."""
    flights = [fly(measure, seed=seed) for seed in (1, 2, 3)]
    for k, what in enumerate(("position", "velocity", "attitude")):
        squares = [nees[:, :, k] for nees, _ in flights]
        assert np.mean([share_in_band(each, 3) for each in squares]) >= 0.90, what
        assert np.mean(squares) == pytest.approx(3.0, rel=0.15), what
    assert np.mean([share_in_band(nis, 1) for _, nis in flights]) >= 0.90
    assert np.mean([nis for _, nis in flights]) == pytest.approx(1.0, rel=0.05)


def test_noise_that_the_filter_does_not_expect_shows() -> None:
    nees, _ = fly(position, scale=2.0)
    assert share_in_band(nees[:, :, 1], 3) < 0.2
