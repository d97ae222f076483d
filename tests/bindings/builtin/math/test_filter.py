"""Low-pass filters against the tables of docs/reference/control-pid.md#7 and SciPy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from crazychoir_fw._core import ffi, lib

# docs/reference/control-pid.md#7, relative tolerance 1e-6: the last bit of tanf is the platform's
COEFFICIENTS = [
    # fs, fc, b0, b1, a1, a2
    (100, 20, 0.20657209, 0.41314417, -0.3695274, 0.1958157),
    (100, 10, 0.06745528, 0.13491055, -1.1429805, 0.41280165),
    (100, 0.7, 0.00046895290, 0.00093790581, -1.9378188, 0.93969458),
    (500, 30, 0.027859773, 0.055719547, -1.4754804, 0.58691949),
    (500, 15, 0.0078202095, 0.015640419, -1.7347257, 0.76600659),
    (500, 12.5, 0.0055427165, 0.011085433, -1.7786317, 0.80080259),
    (500, 3, 0.00034604134, 0.00069208269, -1.9466977, 0.94808173),
    # docs/reference/estimators.md#12.7: gyroscope and accelerometer
    (1000, 80, 0.046131805, 2 * 0.046131805, -1.307285, 0.4918122),
    (1000, 30, 0.0078202095, 2 * 0.0078202095, -1.7347257, 0.7660066),
]
STEP_RESPONSES = [
    (100, 20, (0.20657209, 0.69605029, 1.0430479, 1.0754256, 1.0194424, 0.9924151, 0.9933901, 0.9990427)),
    (500, 30, (0.02785977, 0.12468588, 0.27905923, 0.45000494, 0.61162734, 0.74976653, 0.858729, 0.93842441)),
]
samples = st.floats(-1e6, 1e6, width=32)


def make_lpf(fs=100.0, fc=20.0):
    lpf = ffi.new("lpf2pData *")
    lib.lpf2pInit(lpf, fs, fc)
    return lpf


def as_tuple(lpf):
    return (lpf.a1, lpf.a2, lpf.b0, lpf.b1, lpf.b2, lpf.delay_element_1, lpf.delay_element_2)


@pytest.mark.parametrize(("fs", "fc", "b0", "b1", "a1", "a2"), COEFFICIENTS)
def test_coefficients_match_the_table(fs, fc, b0, b1, a1, a2):
    lpf = make_lpf(fs, fc)
    assert (lpf.b0, lpf.b1, lpf.b2, lpf.a1, lpf.a2) == pytest.approx((b0, b1, b0, a1, a2), rel=1e-6)


@pytest.mark.parametrize(("fs", "fc", "response"), STEP_RESPONSES)
def test_step_response_matches_the_table(fs, fc, response):
    lpf = make_lpf(fs, fc)
    assert [lib.lpf2pApply(lpf, 1.0) for _ in response] == pytest.approx(list(response), rel=1e-6)


@given(fs=st.floats(50, 1000), ratio=st.floats(0.02, 0.45))
def test_coefficients_are_those_of_a_butterworth_filter(fs, ratio):
    lpf = make_lpf(fs, fs * ratio)
    b, a = signal.butter(2, ratio, fs=1.0)
    assert (lpf.b0, lpf.b1, lpf.b2, 1.0, lpf.a1, lpf.a2) == pytest.approx((*b, *a), rel=1e-3, abs=1e-5)


@given(inputs=st.lists(st.floats(-100, 100, width=32), min_size=1, max_size=30))
def test_outputs_follow_scipy(inputs):
    lpf = make_lpf()
    b, a = signal.butter(2, 0.2, fs=1.0)
    outputs = [lib.lpf2pApply(lpf, x) for x in inputs]
    assert outputs == pytest.approx(signal.lfilter(b, a, inputs).tolist(), rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("cutoff", [0.0, -1.0])
def test_init_without_cutoff_changes_nothing(cutoff):
    lpf = make_lpf()
    lib.lpf2pApply(lpf, 3.0)
    before = as_tuple(lpf)
    lib.lpf2pInit(lpf, 100.0, cutoff)
    assert as_tuple(lpf) == before


def test_init_accepts_a_null_filter():
    """The call must not crash, nor reach into a filter that stands beside it."""
    lpf = make_lpf()
    lib.lpf2pApply(lpf, 3.0)
    before = as_tuple(lpf)
    lib.lpf2pInit(ffi.NULL, 100.0, 20.0)
    assert as_tuple(lpf) == before


def test_setting_the_cutoff_clears_the_memory():
    lpf = make_lpf()
    lib.lpf2pApply(lpf, 3.0)
    lib.lpf2pSetCutoffFreq(lpf, 100.0, 10.0)
    assert (lpf.delay_element_1, lpf.delay_element_2) == (0.0, 0.0)


@given(value=samples)
def test_reset_settles_the_filter_at_once(value):
    lpf = make_lpf()
    assert lib.lpf2pReset(lpf, value) == pytest.approx(value, rel=1e-5, abs=1e-6)
    assert lib.lpf2pApply(lpf, value) == pytest.approx(value, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_bad_sample_is_forgotten_after_two_good_ones(bad):
    lpf = make_lpf()
    lib.lpf2pApply(lpf, bad)
    outputs = [lib.lpf2pApply(lpf, 1.0) for _ in range(60)]
    assert not math.isfinite(outputs[0])
    assert outputs[-1] == pytest.approx(1.0, rel=1e-5)


def iir_twin(inputs, attenuation):
    """Return the outputs of the integer low-pass, in Python integers."""
    share, filt, outputs = min(max(attenuation, 1), 256), 0, []
    for value in inputs:
        filt += (((value << 8) - filt) >> 8) * share
        outputs.append((filt >> 8) + ((filt >> 7) & 1))
    return outputs


@given(
    inputs=st.lists(st.integers(-32000, 32000), min_size=1, max_size=20),
    attenuation=st.integers(-10, 400),
)
def test_integer_low_pass_equals_its_twin(inputs, attenuation):
    filt = ffi.new("int32_t *")
    outputs = [lib.iirLPFilterSingle(value, attenuation, filt) for value in inputs]
    assert outputs == iir_twin(inputs, attenuation)


@pytest.mark.parametrize(
    ("value", "attenuation", "rounded"),
    [(1, 127, 0), (1, 128, 1), (-1, 128, 0), (-1, 129, -1), (3, 128, 2), (-3, 128, -1)],
)
def test_integer_low_pass_rounds_half_up(value, attenuation, rounded):
    assert lib.iirLPFilterSingle(value, attenuation, ffi.new("int32_t *")) == rounded


def make_butterworth(cutoff_hz=8.0, fs=500.0, value=0.0):
    lpf = ffi.new("Butterworth2LowPass *")
    lib.init_butterworth_2_low_pass(lpf, 1.0 / (2.0 * math.pi * cutoff_hz), 1.0 / fs, value)
    return lpf


def test_second_order_coefficients_match_the_table():
    # docs/reference/control-geometric.md#8: 8 Hz at 500 Hz
    lpf = make_butterworth()
    assert tuple(lpf.a) == pytest.approx((-1.85804212, 0.86747092), rel=1e-6)
    assert tuple(lpf.b) == pytest.approx((0.00235720747, 0.00471441494), rel=1e-6)


@given(inputs=st.lists(st.floats(-100, 100, width=32), min_size=1, max_size=30))
def test_second_order_outputs_follow_scipy(inputs):
    lpf = make_butterworth(cutoff_hz=50.0)
    b = (lpf.b[0], lpf.b[1], lpf.b[0])
    a = (1.0, lpf.a[0], lpf.a[1])
    outputs = [lib.update_butterworth_2_low_pass(lpf, x) for x in inputs]
    assert outputs == pytest.approx(signal.lfilter(b, a, inputs).tolist(), rel=1e-4, abs=1e-3)
    assert lib.get_butterworth_2_low_pass(lpf) == outputs[-1]


@given(value=st.floats(-100, 100, width=32))
def test_second_order_filter_starts_settled(value):
    lpf = make_butterworth(value=value)
    assert lib.get_butterworth_2_low_pass(lpf) == value
    assert lib.update_butterworth_2_low_pass(lpf, value) == pytest.approx(value, rel=1e-4, abs=1e-6)


def test_quality_shapes_the_general_filter():
    lpf = ffi.new("struct SecondOrderLowPass *")
    tau, quality, dt = 0.02, 2.0, 0.01
    lib.init_second_order_low_pass(lpf, tau, quality, dt, 0.0)
    k = math.tan(dt / (2 * tau))
    poly = k * k + k / quality + 1
    assert tuple(lpf.a) == pytest.approx((2 * (k * k - 1) / poly, (k * k - k / quality + 1) / poly), rel=1e-5)
    assert tuple(lpf.b) == pytest.approx((k * k / poly, 2 * k * k / poly), rel=1e-5)

    # constant input: unit gain, reached after an overshoot
    outputs = np.array([lib.update_second_order_low_pass(lpf, 1.0) for _ in range(100)])
    assert outputs.max() > 1.2
    assert lib.get_second_order_low_pass(lpf) == pytest.approx(1.0, abs=1e-3)
