"""Quaternions in 32 bits (docs/reference/planner-commander.md#11 and #17.2, docs/reference/crtp-cflib.md#12)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

# docs/reference/planner-commander.md#17.2: x, y, z, w; word; what comes back
VECTORS = [
    ((0, 0, 0, 1), 0xC0000000, (0, 0, 0, 1)),
    ((1, 0, 0, 0), 0x00000000, (1, 0, 0, 0)),
    ((0.707107, 0, 0, 0.707107), 0x000001FF, (0.70710677, 0, 0, 0.70710677)),
    ((0.182574, 0.365148, 0.547723, 0.730297), 0xC844218C, (0.18265772, 0.36531544, 0.54797316, 0.73000425)),
    ((-0.5, 0.5, -0.5, 0.5), 0x3695A769, (0.50137389, -0.49954119, 0.49954119, -0.49954119)),
]


def compress(quat) -> int:
    return lib.quatcompress(ffi.new("float[4]", [float(value) for value in quat]))


def decompress(word: int) -> np.ndarray:
    quat = ffi.new("float[4]")
    lib.quatdecompress(word, quat)
    return np.array(list(quat))


@pytest.mark.parametrize(("quat", "word", "back"), VECTORS)
def test_quaternion_has_the_expected_word(quat, word: int, back) -> None:
    assert compress(quat) == word


@pytest.mark.parametrize(("quat", "word", "back"), VECTORS)
def test_word_has_the_expected_quaternion(quat, word: int, back) -> None:
    assert decompress(word) == pytest.approx(back, rel=1e-7, abs=1e-9)


def reference(quat: np.ndarray) -> int:
    """Compress in double, as the client does."""
    largest = int(np.argmax(np.abs(quat)))
    quat = quat * np.copysign(1.0, quat[largest])
    word = largest
    for i in range(4):
        if i != largest:
            word = word << 10 | bool(quat[i] < 0) << 9 | int(511 * abs(quat[i]) * math.sqrt(2) + 0.5)
    return word


def random_attitudes(count: int) -> np.ndarray:
    quats = np.random.default_rng(1).normal(size=(count, 4))
    return quats / np.linalg.norm(quats, axis=1, keepdims=True)


def test_round_trip_errs_by_a_fifth_of_a_degree_at_most() -> None:
    quats = random_attitudes(20000)
    back = np.array([decompress(compress(quat)) for quat in quats])
    assert np.all(np.isfinite(back))
    angles = 2 * np.degrees(np.arccos(np.clip(np.abs(np.sum(quats * back, axis=1)), 0, 1)))
    assert 0.15 < angles.max() < 0.21


def test_word_differs_from_that_in_double_by_a_count_now_and_then() -> None:
    quats = random_attitudes(20000)
    different = [(compress(quat), reference(quat)) for quat in quats if compress(quat) != reference(quat)]
    assert len(different) < 20
    for ours, theirs in different:
        fields = [abs((ours >> shift & 1023) - (theirs >> shift & 1023)) for shift in (0, 10, 20)]
        assert sorted(fields) == [0, 0, 1]


@given(st.integers(0, 0xFFFFFFFF))
def test_every_word_that_is_a_rotation_comes_back(word: int) -> None:
    quat = decompress(word)
    largest = word >> 30
    others = [quat[i] for i in range(4) if i != largest]
    if np.isfinite(quat[largest]) and quat[largest] > max(map(abs, others)):
        signs = 0x20080200  # of three fields: a zero may come with either
        again = compress(quat)
        assert again & ~signs & 0xFFFFFFFF == word & ~signs & 0xFFFFFFFF
        assert np.linalg.norm(quat) == pytest.approx(1.0, abs=1e-6)


def test_first_of_equal_components_is_the_largest() -> None:
    assert [compress(np.array(q) / 2) >> 30 for q in [(1, 1, 1, 1), (-1, 1, -1, 1)]] == [0, 0]
    half = math.sqrt(0.5)
    assert compress((0, half, -half, 0)) >> 30 == 1


def test_word_that_no_rotation_has_is_no_number() -> None:
    assert math.isnan(decompress(0x1FF7FDFF)[0])


@pytest.mark.parametrize("quat", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (0, math.inf, 1, 0), (3e38, 3e38, -3e38, 0)])
def test_what_is_no_unit_quaternion_gives_some_word(quat) -> None:
    fields = [compress(quat) >> shift & 511 for shift in (0, 10, 20)]
    assert all(0 <= field <= 511 for field in fields)
