"""The declarations of laws: options, arguments, metrics, and the neighbors whose messages they use."""

import math

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.guidance import (
    CFDistributedFeedback,
    CFGuidance,
    Flown,
    Graph,
    LawContext,
    Metrics,
    criterion,
    option,
)
from crazychoir_fw.guidance.formation_metrics import BearingMetrics
from crazychoir_fw.guidance.law import arguments_of, options_of
from crazychoir_fw.guidance.presence import Presence


class Law(CFGuidance):
    """With one option of each kind, and another height than its base."""

    height: float = option(0.4, "height of the take-off", "m", above=0)
    count: int = option(3, "how many", low=1, high=5)
    word: str = option("left", "which side", choices=("left", "right"))
    limit: float = option(math.inf, "largest speed", "m/s", above=0, is_finite=False)
    anything = option(None, "whatever")
    may_lack: float | None = option(None, "how long", "s", low=0, kind=float)


class Positional(Law):
    def __init__(self, place, *, side=1.0, **options):
        super().__init__(**options)


def test_options_become_attributes_of_their_type():
    made = Law(2, count=4, limit=2, takeoff_time=3)
    assert (made.agent_id, made.height, made.count, made.word) == (2, 0.4, 4, "left")
    assert (made.limit, made.takeoff_time, made.anything, made.may_lack) == (2.0, 3.0, None, None)
    assert type(made.limit) is float
    assert next(iter(options_of(Law))) == "init_pos"
    assert options_of(Law)["height"].default == 0.4
    assert options_of(CFGuidance)["height"].default == 1.0


@pytest.mark.parametrize(
    ("options", "kind", "said"),
    [
        ({"count": 6}, RangeError, r"agent 0: count is 6, allowed: \[1, 5\]"),
        ({"count": 2.5}, RangeError, r"count is 2.5, allowed: \[1, 5\]"),
        ({"count": True}, RangeError, "count is True"),
        ({"height": 0}, RangeError, "height is 0, allowed: above 0 m"),
        ({"height": math.inf}, RangeError, "height is inf"),
        ({"height": "high"}, RangeError, "height is high"),
        ({"limit": math.nan}, RangeError, "limit is nan"),
        ({"may_lack": -1.0}, RangeError, "may_lack is -1.0, allowed: 0 or more s"),
        ({"word": "up"}, UnknownNameError, "word is 'up', allowed: left, right"),
        ({"hight": 1.0}, TypeError, "Law has no option hight"),
    ],
)
def test_what_no_option_allows_is_refused(options, kind, said):
    with pytest.raises(kind, match=said):
        Law(**options)


def test_arguments_are_those_of_all_constructors():
    assert arguments_of(Positional)[:3] == ("place", "side", "agent_id")
    assert {"count", "height", "init_pos"} < set(arguments_of(Positional))
    assert {"communicator", "deadline", "silence"} < set(arguments_of(CFDistributedFeedback))


# ---------------------------------------------------------------- metrics


class Far(Metrics):
    curve_label, curve_limit = "distance (m)", "far_m"

    def errors(self, flown):
        return np.where(flown.up, flown.at[..., 0], np.nan)

    @criterion("the origin", "m")
    def far_m(self, flown):
        return flown.final_positions[:, 0]

    @criterion("the sum", "m", high=9.0)
    def sum_m(self, flown):
        return flown.final_positions[:, 0].sum()


class Farther(Far):
    @criterion("the product")
    def product(self, flown):
        return math.nan


def flown(counted=None):
    at = np.zeros((4, 2, 3))
    at[:, 0, 0], at[:, 1, 0] = [0, 1, 1, 1], [0, 2, 2, 2]
    up = np.ones((4, 2), bool)
    up[0] = False
    return Flown("ab", np.arange(4.0), at, at + 1.0, up, slice(2, 4), (0.0, 3.0), (), counted)


def context(**changes):
    return LawContext(Law, ("a", "b"), (0, 1), Graph.undirected(2, [(0, 1)]), **changes)


def test_criteria_are_methods_and_make_verdicts():
    metrics = Farther(context())
    assert set(metrics.criteria) == {"far_m", "sum_m", "product"}
    assert set(Metrics.criteria) == set()
    far = metrics.verdict("far_m", 1.5, flown())
    assert (far.value, far.passed, far.sentence) == (2.0, False, "b: is 2.000 m from the origin, allowed: 1.5 m")
    assert metrics.verdict("far_m", 1.5, flown(np.array([True, False]))).passed
    assert metrics.verdict("sum_m", 3.0, flown()).sentence == "the sum is 3 m, allowed: 3 m"
    lost = metrics.verdict("product", 1.0, flown())
    assert (lost.value, lost.passed, lost.sentence) == (None, False, "the product is not known, allowed: 1")


@pytest.mark.parametrize("limit", [-1, 9.5, True, "1", math.nan])
def test_limits_are_checked(limit):
    with pytest.raises(RangeError, match=r"criteria.sum_m is .*, but must be a number in \[0, 9\] m"):
        Far.criteria["sum_m"].checked("sum_m", limit)


def test_a_curve_is_made_of_errors():
    class Criteria:
        far_m = 1.5

    curve = Far(context()).curve(flown(), Criteria)
    np.testing.assert_array_equal(curve.mean, [np.nan, 1.5, 1.5, 1.5])
    np.testing.assert_array_equal(curve.largest, [np.nan, 2, 2, 2])
    assert (curve.label, curve.limit, curve.judged, curve.places) == ("distance (m)", 1.5, (2.0, 3.0), None)


def test_bearings_count_where_there_is_a_formation():
    assert BearingMetrics.of(context()) is None
    metrics = BearingMetrics.of(context(formation=np.array([[0.0, 0, 0], [0, 1, 0]]), leaders=(0,)))
    np.testing.assert_allclose(metrics.errors(flown()), [[np.nan], [90], [90], [90]])
    assert metrics.figures(flown()) == pytest.approx({"bearing_error_deg": 90, "bearing_error_max_deg": 90})
    # one leader leaves the follower a choice
    assert np.isnan(metrics.places(flown().at[-1], flown().wanted[-1])[1]).all()


# ---------------------------------------------------------------- neighbors


class Ear:
    """What `Presence` asks of a communicator."""

    in_neighbors = (1, 2)
    current_label = 10

    def __init__(self):
        self.counts = {1: 0, 2: 0}
        self.labels = {1: 10, 2: 10}

    def heard(self, one):
        return self.counts[one]

    def newest_label(self, one):
        return self.labels[one]


def test_silence_loses_a_neighbor_and_a_word_brings_it_back():
    ear = Ear()
    presence = Presence(ear)
    assert presence.look(0.0, (1, 2), 0.5) == ([], [])
    ear.counts[1] += 1
    assert presence.look(0.4, (1, 2), 0.5) == ([], [])
    assert presence.look(0.6, (1, 2), 0.5) == ([2], [])
    assert presence.look(0.7, (1, 2), 0.5) == ([], [])
    ear.counts[2] += 1
    assert presence.look(0.8, (1, 2), 0.5) == ([], [2])
    presence.forget(1)
    assert presence.look(2.0, (1,), 0.5) == ([], [])  # its time begins with this look


def test_missed_rounds_lose_a_neighbor_that_comes_back_in_the_rounds_of_the_others():
    ear = Ear()
    presence = Presence(ear)
    assert presence.count([2], (1, 2), rounds=2) == []
    assert presence.count([], (1, 2), rounds=2) == []
    assert presence.count([2], (1, 2), rounds=2) == []
    assert presence.count([2], (1, 2), rounds=2) == [2]
    assert presence.welcome() == []
    ear.counts[2], ear.labels[2] = 1, 6
    assert presence.welcome(late_rounds=3) == []
    ear.counts[2], ear.labels[2] = 2, 7
    assert presence.welcome(late_rounds=3) == [2]
    assert presence.lost == set()
