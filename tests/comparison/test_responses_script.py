"""The figures of benchmarks/responses.py against closed forms, and the step of a log."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
import responses


def test_figures_of_a_second_order_step():
    """Damping 0.5 at 2 rad/s: overshoot exp(-pi z / sqrt(1 - z^2)) = 16.3 %, rise 1.64 / w."""
    time, z, w = np.arange(-1.0, 8.0, 0.01), 0.5, 2.0
    t, s = np.maximum(time, 0.0), np.sqrt(1 - 0.5**2)
    share = 1 - np.exp(-z * w * t) / s * np.sin(w * s * t + np.arccos(z))
    found = responses.step_figures(time, np.where(time < 0.0, 0.0, share))
    assert found["overshoot_percent"] == pytest.approx(16.3, abs=0.1)
    assert found["rise_s"] == pytest.approx(1.64 / w, abs=0.02)
    assert found["settled_s"] == pytest.approx(2.64, abs=0.05)


@pytest.mark.parametrize("frequency", [0.3, 1.5])
def test_gain_and_phase_of_a_delayed_lag(frequency):
    """Half the gain, 0.1 s late, on a drift: it comes out as it went in."""
    time = np.arange(-1.0, 2 * responses.PERIODS / frequency, 0.01)
    told = np.sin(2 * np.pi * frequency * time)
    seen = 0.5 * np.sin(2 * np.pi * frequency * (time - 0.1)) + 0.3 + 0.02 * time
    found = responses.transfer(list(told), list(seen), frequency)
    assert abs(found) == pytest.approx(0.5, rel=1e-6)
    assert np.degrees(np.angle(found)) == pytest.approx(-360 * 0.1 * frequency, abs=1e-6)


def test_bandwidth_is_where_the_gain_falls_below_three_decibels():
    frequencies = np.array([0.1, 0.3, 1.0, 3.0, 10.0])
    first_order = 1 / (1 + 1j * frequencies / 1.0)
    assert responses.bandwidth(frequencies, first_order) == pytest.approx(1.0, rel=0.02)
    assert responses.bandwidth(frequencies, np.ones(5, complex)) is None


def test_the_step_of_a_log(as_csv, log, columns):
    told = np.where(np.arange(len(log.time)) < 600, 0.2, 0.7)
    seen = 0.2 + 0.5 * (1 - np.exp(-np.maximum(log.time - log.time[600], 0.0) / 0.4))
    path = as_csv({**columns, "ctrltarget.x": told, "stateEstimate.x": seen})
    time, share = responses.step_of_log(path, "x", None)
    assert time[0] == pytest.approx(-1.0, abs=0.02)
    assert responses.step_figures(time, share)["rise_s"] == pytest.approx(0.4 * np.log(9), abs=0.03)
