"""References on the side of the controller (docs/reference/crazychoir.md#6)."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Reference
from crazychoir_fw.planning import AccelerationTraj, FullStateTraj, PositionTraj, TrajHandlerStrategy

EVERYTHING = Reference(*np.arange(12.0).reshape(4, 3), 0.3, 0.1)


@pytest.mark.parametrize(
    ("make", "kind", "kept"),
    [
        (PositionTraj, "position", {"position"}),
        (AccelerationTraj, "acceleration", {"acceleration"}),
        (FullStateTraj, "fullstate", {"position", "velocity", "acceleration", "jerk", "yaw", "yaw_rate"}),
    ],
)
def test_each_kind_keeps_what_it_carries(make, kind, kept):
    strategy = make()
    assert strategy.kind == strategy.topic == kind
    assert strategy.get_desired_reference() is None
    strategy.update(EVERYTHING)
    found = strategy.get_desired_reference()
    assert {name for name, value in vars(found).items() if value is not None} == kept
    for name in kept:
        np.testing.assert_array_equal(getattr(found, name), getattr(EVERYTHING, name))


def test_whole_groups_are_kept_alike():
    strategy = AccelerationTraj("push")
    strategy.update(Reference(acceleration=np.ones((30, 3))))
    assert strategy.topic == "push"
    assert strategy.get_desired_reference().acceleration.shape == (30, 3)


@pytest.mark.parametrize(
    "bad",
    [Reference(), Reference(position=np.zeros(2)), Reference(position=np.zeros(3), velocity=np.full(3, np.nan))],
)
def test_bad_references_are_refused_and_the_last_good_one_stays(bad):
    strategy = FullStateTraj()
    strategy.update(EVERYTHING)
    with pytest.raises(RangeError, match="fullstate: "):
        strategy.update(bad)
    assert strategy.get_desired_reference().yaw == 0.3


def test_unknown_kinds_are_refused():
    with pytest.raises(RangeError, match="kind is 'speed', allowed: position, acceleration, fullstate"):
        TrajHandlerStrategy("speed", "topic")
