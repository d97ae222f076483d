"""The driver of the loco deck (docs/reference/estimators.md#13.5): what it tells the estimator and the log."""

from typing import Any

import numpy as np
import pytest
from queued import take

from crazychoir_fw._core import ffi, lib

ANCHORS = np.random.default_rng(1).uniform(-3, 3, (8, 3)).astype(np.float32)


class Deck:
    """A driver that knows its anchors, with the queue of its estimator."""

    def __init__(self) -> None:
        self.deck = ffi.new("cf_loco_deck_t *")
        self.estimator = ffi.new("cf_estimator_t *")
        lib.cf_loco_deck_init(self.deck)
        self.deck.anchors = ANCHORS.tolist()

    def ranging(self, mode: int, previous: int, anchor: int, distance: float, tick: int = 5) -> list[Any]:
        ranging = ffi.new("cf_ranging_t *", {"mode": mode, "anchor": anchor, "previous": previous})
        ranging.distance = distance
        lib.cf_loco_deck_ranging(self.deck, self.estimator, ranging, tick)
        return take(self.estimator)


@pytest.fixture
def deck() -> Deck:
    return Deck()


def test_a_range_is_a_distance_to_its_anchor(deck: Deck) -> None:
    (measurement,) = deck.ranging(lib.CF_LOCO_TWR, 3, 3, 2.5)
    distance = measurement.data.distance
    assert measurement.type == lib.MeasurementTypeDistance
    assert [distance.x, distance.y, distance.z] == ANCHORS[3].tolist()
    assert (distance.anchorId, distance.distance, distance.stdDev) == (3, 2.5, 0.25)


@pytest.mark.parametrize("mode", [lib.CF_LOCO_TDOA2, lib.CF_LOCO_TDOA3])
def test_a_difference_names_both_anchors_the_new_one_second(deck: Deck, mode: int) -> None:
    (measurement,) = deck.ranging(mode, 2, 6, -0.75, tick=9)
    tdoa = measurement.data.tdoa
    assert measurement.type == lib.MeasurementTypeTDOA
    for point, anchor in ((tdoa.anchorPositionA, 2), (tdoa.anchorPositionB, 6)):
        assert [point.x, point.y, point.z] == ANCHORS[anchor].tolist()
        assert point.timestamp == 9
    assert (tdoa.anchorIdA, tdoa.anchorIdB) == (2, 6)
    assert (tdoa.distanceDiff, tdoa.stdDev) == (-0.75, pytest.approx(0.15))


@pytest.mark.parametrize(("mode", "member"), [(lib.CF_LOCO_TDOA2, "tdoa2_std"), (lib.CF_LOCO_TDOA3, "tdoa3_std")])
def test_deviation_of_a_difference_is_a_parameter(deck: Deck, mode: int, member: str) -> None:
    setattr(deck.deck, member, 0.5)
    assert deck.ranging(mode, 0, 1, 0.0)[0].data.tdoa.stdDev == 0.5


@pytest.mark.parametrize("chosen", [lib.CF_LOCO_TWR, lib.CF_LOCO_TDOA2, lib.CF_LOCO_TDOA3])
def test_mode_ignores_what_other_anchors_speak(deck: Deck, chosen: int) -> None:
    deck.deck.mode = chosen
    for mode in (lib.CF_LOCO_TWR, lib.CF_LOCO_TDOA2, lib.CF_LOCO_TDOA3):
        assert bool(deck.ranging(mode, 0, 1, 1.0)) == (mode == chosen)


def test_in_two_dimensions_every_ranging_brings_the_height(deck: Deck) -> None:
    deck.deck.is_planar, deck.deck.height = True, 1.5
    for mode in (lib.CF_LOCO_TWR, lib.CF_LOCO_TDOA2):
        _, measurement = deck.ranging(mode, 0, 1, 1.0, tick=4)
        height = measurement.data.height
        assert measurement.type == lib.MeasurementTypeAbsoluteHeight
        assert (height.timestamp, height.height, height.stdDev) == (4, 1.5, pytest.approx(1e-4))


def test_log_has_the_latest_ranges_and_who_was_heard(deck: Deck) -> None:
    deck.ranging(lib.CF_LOCO_TWR, 0, 0, 1.0)
    deck.ranging(lib.CF_LOCO_TWR, 7, 7, 3.0)
    deck.ranging(lib.CF_LOCO_TWR, 0, 0, 2.0)
    assert list(deck.deck.distances) == [2.0, 0, 0, 0, 0, 0, 0, 3.0]
    assert deck.deck.state == 0
    lib.cf_loco_deck_count(deck.deck)
    assert deck.deck.state == 0b1000_0001
    lib.cf_loco_deck_count(deck.deck)
    assert deck.deck.state == 0
