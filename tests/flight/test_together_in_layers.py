"""Buttons that are pressed at the same time in missions with layers."""

import pytest
from flown_layers import hover, mission

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.flight.engine import fly


def go(name, x, duration):
    return {"go_to": {"drones": [name], "position": [x, 0.0, 0.8], "duration": duration}}


def flight(*phases):
    return [{"takeoff": {"duration": 2}}, {"together": list(phases)}, {"land": {"duration": 2}}]


def test_orders_begin_at_the_same_time_and_the_longest_ends_them():
    result = fly(mission(hover(2, flight=flight(go("a", -1.0, 2.0), go("b", 2.0, 3.0)))))
    assert result.summary["failures"] == []
    windows = result.log.metadata["windows"]
    assert [(name, round(end - begin, 2)) for name, begin, end in windows] == [
        ("takeoff", 2.0),
        ("go_to", 2.0),
        ("go_to", 3.0),
        ("land", 2.0),
    ]
    assert windows[1][1] == windows[2][1] == pytest.approx(windows[3][1] - 3.0)
    x = result.log.stack("sim.x")
    assert x[-1] == pytest.approx([-1.0, 2.0], abs=0.05)
    # both are on their way after a second and a half
    at = int((windows[1][1] + 1.5) * 25)
    assert x[at, 0] < -0.5 and x[at, 1] > 1.3


def test_two_orders_for_one_drone_are_refused():
    with pytest.raises(MissionError, match=r"flight\[1\].together.land gives a two orders at once"):
        mission(hover(2, flight=flight(go("a", -1.0, 2.0), {"land": {"duration": 1}})))


def test_a_hover_beside_an_order_gives_it_time():
    result = fly(mission(hover(2, flight=flight(go("a", -1.0, 2.0), {"hover": {"duration": 4}}))))
    windows = result.log.metadata["windows"]
    assert windows[3][1] - windows[1][1] == pytest.approx(4.0)
