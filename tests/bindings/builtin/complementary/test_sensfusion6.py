"""Mahony's and Madgwick's filters (docs/reference/estimators.md#10.2, #17.K)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

MAHONY, MADGWICK = lib.CF_SENSFUSION6_MAHONY, lib.CF_SENSFUSION6_MADGWICK
GYRO = (10.0, -20.0, 30.0)  # deg/s
ACC = (0.1, -0.2, 0.97)  # g
DT = 0.004  # s


class Fusion:
    """A filter, fresh from boot."""

    def __init__(self, kind: int = MAHONY) -> None:
        self.struct = ffi.new("cf_sensfusion6_t *")
        ffi.buffer(self.struct)[:] = b"\xaa" * ffi.sizeof("cf_sensfusion6_t")
        lib.cf_sensfusion6_boot(self.struct, kind)

    def update(self, gyro: Any = GYRO, acc: Any = ACC, times: int = 1) -> Fusion:
        for _ in range(times):
            lib.cf_sensfusion6_update_q(self.struct, *gyro, *acc, DT)
        return self

    @property
    def wxyz(self) -> list[float]:
        x, y, z, w = (ffi.new("float *") for _ in range(4))
        lib.cf_sensfusion6_get_quaternion(self.struct, x, y, z, w)
        return [w[0], x[0], y[0], z[0]]

    @property
    def rpy(self) -> NDArray[np.float64]:
        """Roll, pitch (legacy) and yaw in degrees, shape (3,)."""
        angles = [ffi.new("float *") for _ in range(3)]
        lib.cf_sensfusion6_get_euler_rpy(self.struct, *angles)
        return np.array([angle[0] for angle in angles])

    @property
    def gravity(self) -> list[float]:
        return [self.struct.gravX, self.struct.gravY, self.struct.gravZ]

    def acc_z(self, acc: Any) -> float:
        return lib.cf_sensfusion6_get_acc_z_without_gravity(self.struct, *acc)


# filter, updates, factor on the gyro, quaternion w x y z, relative tolerance of it, roll pitch yaw (deg)
VECTORS = [
    (MAHONY, 1, 1.0, (0.998306394, 1.88281963e-4, -7.77045731e-4, 0.00104542403), (0.0215187, 0.0889147, 0.1199832)),
    (MAHONY, 2, 1.0, (0.998308957, 3.77355085e-4, -0.00155235047, 0.00209113653), (0.0429416, 0.1776762, 0.2399653)),
    (MAHONY, 250, 1.0, (0.948708, 0.0416886, -0.1575861, 0.2645933), (-0.26063, 18.72749, 31.21054)),
    (MADGWICK, 1, 1.0, (0.995650113, 0.0198773891, -0.0398438126, 0.0597390085), (2.00855, 4.68720, 6.78479)),
    # the same with the conversion that the release leaves out
    (
        MADGWICK,
        1,
        np.pi / 180,
        (0.998306394, 3.12765507e-4, -7.14804046e-4, 0.00104542403),
        (0.0358151, 0.0818093, 0.1199743),
    ),
]


@pytest.mark.parametrize(("kind", "updates", "factor", "wxyz", "rpy"), VECTORS)
def test_attitude_is_that_of_the_check_vectors(kind, updates, factor, wxyz, rpy):
    fusion = Fusion(kind).update(np.multiply(GYRO, factor), times=updates)
    np.testing.assert_allclose(fusion.wxyz, wxyz, rtol=1e-6)
    np.testing.assert_allclose(fusion.rpy, rpy, rtol=2e-5)


def test_first_update_of_mahony_calibrates():
    fusion = Fusion()
    assert (fusion.struct.isCalibrated, fusion.struct.baseZacc) == (0, 1.0)
    fusion.update()
    struct = fusion.struct
    integral = [struct.integralFBx, struct.integralFBy, struct.integralFBz]
    np.testing.assert_allclose(integral, [-8.02314446e-7, -4.01157223e-7, 0], rtol=1e-6)
    np.testing.assert_allclose(fusion.gravity, [0.00155185314, 3.74301482e-4, 0.996616066], rtol=1e-6)
    assert struct.isCalibrated == 1
    assert struct.baseZacc == pytest.approx(0.966797948, rel=1e-7)
    assert fusion.acc_z((0.1, -0.2, 1.05)) == pytest.approx(0.0797291994, rel=1e-6)
    fusion.update(acc=(0.0, 0.0, 3.0))
    assert struct.baseZacc == pytest.approx(0.966797948, rel=1e-7)


def test_starting_marks_the_filter_and_keeps_its_attitude():
    fusion = Fusion().update(times=5)
    before = fusion.wxyz
    assert not lib.cf_sensfusion6_test(fusion.struct)
    lib.cf_sensfusion6_init(fusion.struct)
    assert lib.cf_sensfusion6_test(fusion.struct)
    assert fusion.wxyz == before


def test_madgwick_turns_57_times_too_fast():
    """docs/reference/estimators.md#10.2: 2 s at (20, -10, 30) deg/s end at (-23, -3, -34) deg."""
    fusion = Fusion(MADGWICK).update((20.0, -10.0, 30.0), (0.0, 0.0, 1.0), times=500)
    np.testing.assert_allclose(fusion.rpy, [-23, -3, -34], atol=0.5)


def test_madgwick_told_radians_turns_as_it_should():
    """docs/reference/estimators.md#10.2: (26, 35, 55) deg instead, which is what the gyroscope alone gives."""
    radians = np.radians((20.0, -10.0, 30.0))
    fusion = Fusion(MADGWICK).update(radians, (0.0, 0.0, 0.0), times=500)
    np.testing.assert_allclose(fusion.rpy, [26, 35, 55], atol=0.5)


def test_norm_stays_within_six_millionths_over_5000_noisy_updates():
    """docs/reference/estimators.md#10.2: 0.998307 to 0.998313."""
    rng, fusion, norms = np.random.default_rng(1), Fusion(), []
    for _ in range(5000):
        fusion.update(rng.normal(size=3) * 100.0, [0.0, 0.0, 1.0] + rng.normal(size=3) * 0.1)
        struct = fusion.struct
        norms.append(np.linalg.norm([struct.qw, struct.qx, struct.qy, struct.qz]))
    assert (min(norms), max(norms)) == pytest.approx((0.998307, 0.998313), abs=6e-7)


def test_madgwick_finds_gravity_at_rest():
    acc = Rotation.from_euler("x", 10, degrees=True).inv().apply([0, 0, 1.0])
    fusion = Fusion(MADGWICK).update((0, 0, 0), acc, times=20000)
    np.testing.assert_allclose(fusion.rpy, [10, 0, 0], atol=0.05)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-300, 300))
def test_norm_is_what_the_fast_square_root_leaves(x, y, z, rate):
    """docs/reference/estimators.md#10.2: the stored norm is 0.998307 to 0.998313, whatever the motion."""
    fusion = Fusion().update((rate, -rate, rate), (x, y, z), times=20)
    assert 0.99830 < np.linalg.norm(fusion.wxyz) < 0.99832


@pytest.mark.parametrize(("roll", "pitch"), [(0, 20), (0, 35), (30, 0), (-25, -15)])
def test_tilt_at_rest_is_found(roll, pitch):
    """To 0.3 %: half of gravity is taken for a vector of length 0.5, but has the norm of the quaternion."""
    attitude = Rotation.from_euler("ZYX", [0, -pitch, roll], degrees=True)
    fusion = Fusion().update((0, 0, 0), attitude.inv().apply([0, 0, 1.0]), times=8000)
    np.testing.assert_allclose(fusion.rpy[:2], [roll, pitch], rtol=0.003)


@pytest.mark.parametrize(("pitch", "lost"), [(20, 0.07), (35, 0.14), (90, 4.7)])
def test_told_pitch_is_a_little_smaller_than_that_of_the_quaternion(pitch, lost):
    """The pitch is asin(0.99662 sin), 0.07 deg less at 20 deg, 0.14 at 35, and 85.3 deg at most.

    docs/reference/estimators.md#10.2.
    """
    fusion = Fusion()
    w, y = np.cos(np.radians(pitch) / 2), -np.sin(np.radians(pitch) / 2)
    fusion.struct.qw, fusion.struct.qy = w, y
    fusion.update((0, 0, 0), (0, 0, 0))
    told = fusion.rpy[1]
    assert told == pytest.approx(np.degrees(np.arcsin(0.99662 * np.sin(np.radians(pitch)))), abs=0.01)
    assert pitch - told == pytest.approx(lost, abs=0.05 * lost + 0.005)


def test_turns_follow_the_gyroscope_when_there_is_no_gravity():
    """In free fall nothing corrects: 1 s at 45 deg/s about each axis in turn."""
    for axis in range(3):
        rates = np.zeros(3)
        rates[axis] = 45.0
        fusion = Fusion().update(rates, (0, 0, 0), times=250)
        signs = [1, -1, 1]  # legacy pitch
        expected = np.eye(3)[axis] * 45.0 * signs[axis]
        np.testing.assert_allclose(fusion.rpy, expected, atol=0.25)
        assert fusion.struct.integralFBx == 0.0


def test_a_steady_error_of_the_gyroscope_is_integrated_away():
    fusion = Fusion()
    fusion.struct.twoKi = 0.2
    fusion.update((2.0, 0, 0), (0, 0, 1.0), times=20000)
    assert fusion.struct.integralFBx == pytest.approx(-np.radians(2.0), rel=0.01)
    np.testing.assert_allclose(fusion.rpy[:2], 0, atol=0.05)


def test_without_integral_gain_the_integral_is_forgotten():
    fusion = Fusion().update(times=100)
    assert fusion.struct.integralFBx != 0.0
    fusion.struct.twoKi = 0.0
    fusion.update()
    assert [fusion.struct.integralFBx, fusion.struct.integralFBy, fusion.struct.integralFBz] == [0, 0, 0]


@pytest.mark.parametrize("kind", [MAHONY, MADGWICK])
def test_what_is_no_number_reaches_all_angles(kind):
    """The loop stops a drone whose attitude is no number, so that it must not be hidden by a limit."""
    fusion = Fusion(kind).update((np.nan, 0, 0))
    assert np.isnan(fusion.rpy).all()
