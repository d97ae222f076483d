"""The dice: bits, uniform and normal numbers."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from crazychoir_fw._core import ffi, lib

COUNT = 1_000_000


def make(seed: int = 1, drone_id: int = 0) -> Any:
    random = ffi.new("cf_random_t *")
    lib.cf_random_init(random, seed, drone_id)
    return random


def normals(random: Any, count: int) -> np.ndarray:
    numbers = np.empty(count, np.float32)
    lib.cf_random_normals(random, ffi.from_buffer("float[]", numbers), count)
    return numbers.astype(float)


def test_state_is_sixteen_bytes() -> None:
    assert ffi.sizeof("cf_random_t") == 16


def test_same_seed_and_id_give_the_same_bits() -> None:
    a, b = make(7, 3), make(7, 3)
    assert [lib.cf_random_bits(a) for _ in range(100)] == [lib.cf_random_bits(b) for _ in range(100)]


def test_first_bits_are_those_of_every_other_run() -> None:
    """Recorded once: a change of the generator changes every recorded flight."""
    random = make(2026, 5)
    assert [hex(lib.cf_random_bits(random)) for _ in range(3)] == RECORDED_BITS


RECORDED_BITS = ["0xe76999b16d72e49", "0xb44fbf3f7afbf434", "0x222879ab7c1c2a4f"]


@pytest.mark.parametrize(("one", "other"), [((1, 0), (1, 1)), ((1, 0), (2, 0)), ((1, 2), (2, 1)), ((0, 1), (1, 0))])
def test_other_seed_or_id_gives_other_bits(one: tuple[int, int], other: tuple[int, int]) -> None:
    a, b = make(*one), make(*other)
    assert not {lib.cf_random_bits(a) for _ in range(1000)} & {lib.cf_random_bits(b) for _ in range(1000)}


def test_no_seed_gives_the_zero_state() -> None:
    for seed in range(1000):
        random = make(seed, seed)
        assert random.state[0] | random.state[1]


def test_split_gives_an_independent_generator() -> None:
    parent = make()
    child = ffi.new("cf_random_t *", lib.cf_random_split(parent))
    a, b = normals(parent, 100_000), normals(child, 100_000)
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.015


def test_uniform_numbers_fill_the_unit_interval() -> None:
    random = make()
    numbers = np.array([lib.cf_random_uniform(random) for _ in range(50_000)])
    assert numbers.min() >= 0.0
    assert numbers.max() < 1.0
    assert stats.kstest(numbers, "uniform").pvalue > 0.001


def test_normal_moments() -> None:
    x = normals(make(), COUNT)
    assert abs(x.mean()) < 0.004
    assert x.std() == pytest.approx(1.0, abs=0.003)
    assert abs(stats.skew(x)) < 0.01
    assert abs(stats.kurtosis(x)) < 0.02


def test_normal_distribution_passes_kolmogorov_smirnov() -> None:
    assert stats.kstest(normals(make(3), COUNT), "norm").pvalue > 0.001


@pytest.mark.parametrize("sigmas", [1.0, 2.0, 3.0, 4.0])
def test_tail_is_as_heavy_as_it_should_be(sigmas: float) -> None:
    x = np.abs(normals(make(4), 4 * COUNT))
    expected = 2 * stats.norm.sf(sigmas) * x.size
    assert abs((x > sigmas).sum() - expected) < 4 * expected**0.5


@given(st.integers(0, 2**31 - 1))
def test_normal_from_bits_is_the_inverse_distribution(tail: int) -> None:
    expected = stats.norm.isf((tail | 1) / 2**32)
    assert lib.cf_random_normal_from_bits(tail) == pytest.approx(expected, abs=4e-4)
    assert lib.cf_random_normal_from_bits(tail | 2**31) == -lib.cf_random_normal_from_bits(tail)


@pytest.mark.parametrize(("bits", "expected"), [(0, 6.2303), (2**31 - 1, 0.0), (2**30, 0.67449), (2**31, -6.2303)])
def test_normal_at_the_ends_and_the_quartile(bits: int, expected: float) -> None:
    assert lib.cf_random_normal_from_bits(bits) == pytest.approx(expected, abs=4e-4)


def test_variance_of_the_table_is_one() -> None:
    """The integral over all bits: the pieces are straight, so Simpson's rule is exact on each."""
    variance = 0.0
    for low, high, at_low, at_high in runpy.run_path(str(TABLE_SCRIPT))["pieces"]():
        is_wide = high - low > 64  # narrower ones hold a handful of bit patterns
        middle = lib.cf_random_normal_from_bits(int((low + high) / 2)) if is_wide else (at_low + at_high) / 2
        variance += (high - low) / 2**31 * (at_low**2 + 4 * middle**2 + at_high**2) / 6
    assert variance == pytest.approx(1.0, abs=2e-6)


TABLE_SCRIPT = Path(__file__).parents[3] / "bindings" / "vehicle" / "random_table.py"


def test_table_is_what_its_script_writes() -> None:
    assert TABLE_SCRIPT.with_suffix(".c").read_text() == runpy.run_path(str(TABLE_SCRIPT))["table"]()


def test_consecutive_numbers_do_not_correlate() -> None:
    x = normals(make(5), COUNT)
    for lag in (1, 2, 3, 6, 12):
        assert abs(np.corrcoef(x[:-lag], x[lag:])[0, 1]) < 0.004
        assert abs(np.corrcoef(x[:-lag] ** 2, x[lag:] ** 2)[0, 1]) < 0.004


def test_drones_do_not_correlate() -> None:
    x = np.stack([normals(make(1, drone_id), 20_000) for drone_id in range(64)])
    correlation = np.corrcoef(x)[np.triu_indices(64, 1)]
    assert np.abs(correlation).max() < 5 / 20_000**0.5
    assert correlation.std() == pytest.approx(1 / 20_000**0.5, rel=0.1)


@pytest.mark.parametrize("count", [0, 1, 2, 5, 6])
def test_exactly_the_asked_count_is_written(count: int) -> None:
    numbers = np.full(8, 99.0, np.float32)
    lib.cf_random_normals(make(), ffi.from_buffer("float[]", numbers), count)
    assert (numbers[count:] == 99.0).all()
    assert (numbers[:count] != 99.0).all()


def test_single_and_array_numbers_agree() -> None:
    random = make(9)
    first = normals(make(9), 2)[0]
    assert lib.cf_random_normal(random) == first
