"""What a base station of the second generation sees (docs/reference/estimators.md#5.11)."""

import math

import pytest

from crazychoir_fw._core import ffi, lib

TILT = math.pi / 6


def angle(x: float, y: float, z: float, t: float, **calibration: float) -> float:
    return lib.lighthouseCalibrationMeasurementModelLh2(
        x, y, z, t, ffi.new("lighthouseCalibrationSweep_t *", calibration)
    )


def test_the_geometry_of_check_vector_h():
    assert 0.5 - angle(2.515, 0.7075, -0.8, -TILT) == pytest.approx(0.0480527282, abs=1e-7)


@pytest.mark.parametrize("azimuth", [-3.0, -1.0, 0.0, 0.5, 2.0])
def test_at_the_height_of_the_rotor_both_planes_see_the_azimuth(azimuth):
    for t in (-TILT, TILT):
        assert angle(2 * math.cos(azimuth), 2 * math.sin(azimuth), 0.0, t) == pytest.approx(azimuth, abs=1e-6)


def test_above_the_rotor_the_planes_pass_one_after_the_other():
    # z tan(t) / r = 0.5 tan(30 deg)
    early, late = angle(2.0, 0.0, 1.0, -TILT), angle(2.0, 0.0, 1.0, TILT)
    assert (early, late) == pytest.approx((-0.2928428, 0.2928428), abs=1e-6)


@pytest.mark.parametrize(("z", "beyond"), [(10.0, math.pi / 2), (-10.0, -math.pi / 2)])
def test_beyond_its_reach_the_plane_is_taken_at_its_edge(z, beyond):
    assert angle(1.0, 0.0, z, TILT) == pytest.approx(beyond)


def test_phase_delays_the_sweep():
    assert angle(2.0, 1.0, 0.3, TILT, phase=0.05) == pytest.approx(angle(2.0, 1.0, 0.3, TILT) - 0.05, abs=1e-6)


def test_calibrated_tilt_adds_to_that_of_the_plane():
    assert angle(2.0, 1.0, 0.3, TILT, tilt=0.05) == pytest.approx(angle(2.0, 1.0, 0.3, TILT - 0.05), abs=1e-6)


@pytest.mark.parametrize(("x", "y", "share"), [(2.0, 0.0, math.cos(0.4)), (0.0, 2.0, math.cos(math.pi / 2 + 0.4))])
def test_gibbous_term_depends_on_the_azimuth(x, y, share):
    plain, gibbous = angle(x, y, 0.3, TILT), angle(x, y, 0.3, TILT, gibmag=0.01, gibphase=0.4)
    assert gibbous - plain == pytest.approx(0.01 * share, abs=1e-6)


def test_curve_and_ogee_are_left_out():
    extras = {"curve": 0.1, "ogeemag": 0.1, "ogeephase": 0.1}
    assert angle(2.0, 1.0, 0.3, TILT, **extras) == angle(2.0, 1.0, 0.3, TILT)
