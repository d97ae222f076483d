"""The sub-sampler: the numbers of its upstream test (docs/reference/control-pid.md#18)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
axes = st.tuples(*[st.floats(-1e3, 1e3, width=32)] * 3)


def make_sampler(factor=1.0):
    sampler = ffi.new("Axis3fSubSampler_t *")
    lib.axis3fSubSamplerInit(sampler, factor)
    return sampler


def accumulate(sampler, *samples):
    for sample in samples:
        lib.axis3fSubSamplerAccumulate(sampler, ffi.new("Axis3f *", {"axis": sample}))


def finalize(sampler):
    return tuple(lib.axis3fSubSamplerFinalize(sampler).axis)


@pytest.mark.parametrize(
    ("factor", "samples", "mean"),
    [
        (1, [(1, 2, 3)], (1, 2, 3)),
        (1, [(1, 2, 3), (4, 5, 6), (7, 8, 9)], (4, 5, 6)),
        (3, [(1, 2, 3)], (3, 6, 9)),
        (1, [], (0, 0, 0)),
    ],
)
def test_finalize_returns_the_converted_mean(factor, samples, mean):
    sampler = make_sampler(factor)
    accumulate(sampler, *samples)
    assert finalize(sampler) == mean


def test_without_new_samples_the_last_mean_stays():
    sampler = make_sampler()
    accumulate(sampler, (1, 2, 3), (4, 5, 6), (7, 8, 9))
    finalize(sampler)
    assert finalize(sampler) == (4, 5, 6)


def test_old_samples_are_forgotten():
    sampler = make_sampler()
    accumulate(sampler, (1, 2, 3))
    finalize(sampler)
    accumulate(sampler, (4, 5, 6))
    assert finalize(sampler) == (4, 5, 6)


def test_the_result_lives_in_the_sampler():
    sampler = make_sampler()
    assert lib.axis3fSubSamplerFinalize(sampler) == ffi.addressof(sampler, "subSample")


@given(samples=st.lists(axes, min_size=1, max_size=10), factor=st.floats(0.0625, 100, width=32))
def test_the_sum_is_multiplied_before_it_is_divided(samples, factor):
    sampler = make_sampler(factor)
    accumulate(sampler, *samples)
    total = np.zeros(3, F)
    for sample in samples:
        total += np.array(sample, F)
    assert finalize(sampler) == tuple(total * F(factor) / F(len(samples)))
