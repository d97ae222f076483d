"""Drop-outs and outliers: frequencies, sizes, and that nothing is thrown where nothing can happen."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sensor_parts import dice, mishap

from crazychoir_fw._core import ffi, lib

DRAWS = 20_000


def make(**numbers: float) -> Any:
    return ffi.new("cf_mishap_config_t *", mishap(**numbers))


@pytest.mark.parametrize("probability", [0.01, 0.3, 0.9])
def test_drop_outs_have_the_asked_frequency(probability: float) -> None:
    config, random = make(dropout=probability), dice()
    dropped = sum(lib.cf_mishap_drops(config, random) for _ in range(DRAWS))
    deviation = (DRAWS * probability * (1 - probability)) ** 0.5
    assert abs(dropped - DRAWS * probability) < 4 * deviation


def test_certainties_are_certain() -> None:
    random = dice()
    assert all(lib.cf_mishap_drops(make(dropout=1.0), random) for _ in range(1000))
    assert all(lib.cf_mishap_error(make(outlier=1.0, outlier_size=1.0), random) for _ in range(1000))


def test_outliers_are_uniform_from_a_quarter_of_the_size_to_all_of_it_on_both_sides() -> None:
    config, random = make(outlier=0.25, outlier_size=2.0), dice()
    errors = np.array([lib.cf_mishap_error(config, random) for _ in range(DRAWS)])
    wrong = errors[errors != 0.0]
    assert len(wrong) == pytest.approx(DRAWS / 4, abs=4 * (DRAWS * 3 / 16) ** 0.5)
    assert np.abs(wrong).min() > 0.499
    assert np.abs(wrong).max() < 2.001
    assert np.abs(wrong).mean() == pytest.approx(1.25, abs=0.03)
    assert (wrong > 0).mean() == pytest.approx(0.5, abs=0.03)


def test_nothing_is_thrown_when_nothing_can_happen() -> None:
    random = dice()
    before = bytes(ffi.buffer(random))
    assert not lib.cf_mishap_drops(make(), random)
    assert lib.cf_mishap_error(make(outlier_size=5.0), random) == 0.0
    assert bytes(ffi.buffer(random)) == before


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("dropout", -0.01),
        ("dropout", 1.01),
        ("dropout", float("nan")),
        ("outlier", 2.0),
        ("outlier", float("nan")),
        ("outlier_size", -1.0),
        ("outlier_size", float("inf")),
        ("outlier_size", float("nan")),
    ],
)
def test_impossible_numbers_are_refused(name: str, value: float) -> None:
    assert lib.cf_mishap_check(make(**{name: value})) == lib.CF_ERR_VALUE
    assert lib.cf_mishap_check(make()) == lib.CF_OK
