"""Places that are hardly meant: centimeters taken for meters, and what a safety area forbids."""

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.doubts import doubts
from crazychoir_fw.mission.loader import parse_mission

AREA = {"safety_area": {"low": [-2, -2, 0], "high": [2, 2, 2]}}


def layered(start, goal=(1.0, 0.0, 1.0), **changes):
    go = {"go_to": {"position": list(goal), "duration": 3}}
    data = {
        "drones": [{"id": "a", "position": start, "uri": "udp://127.0.0.1:19850"}],
        "flight": [{"takeoff": {}}, {"together": [go]}, "land"],
        "layers": {"guidance": {"class": "SimpleGuidance"}},
    }
    return parse_mission({"name": "one", **data, **changes})


def test_places_in_centimeters_are_asked_about():
    assert doubts(layered([120.0, -40.0], (100.0, 0.0, 80.0))) == [
        "drones[0].position is [120, -40], more than 20 m from the origin: places are in meters; [1.2, -0.4] if it "
        "was meant in centimeters; of its places 2 are so far"
    ]
    assert doubts(layered([12.0, -4.0])) == []


def test_missions_without_layers_and_layouts():
    flight = [{"takeoff": {}}, {"go_to": {"position": [100, 0, 50], "duration": 9}}, "land"]
    (doubt,) = doubts(parse_mission({"name": "one", "drones": [{"id": "a", "position": [0, 0]}], "flight": flight}))
    assert doubt.startswith("flight[1].go_to.position is [100, 0, 50]")
    wide = {"count": 60, "spacing": 9.0}
    assert doubts(parse_mission({"name": "many", "drones": wide, "flight": [{"hover": {"duration": 1}}]})) == []


@pytest.mark.parametrize(
    ("start", "goal", "sentence"),
    [
        ([120.0, 0.0], (1, 0, 1), r"drones\[0\].position is \[120, 0\], outside .*\[1.2, 0\] if it was meant in"),
        ([0.0, 0.0], (0, 0, 3), r"flight\[1\].go_to.position is \[0, 0, 3\], outside of hardware.safety_area, .*2\]$"),
    ],
)
def test_what_a_safety_area_forbids_is_refused(start, goal, sentence):
    with pytest.raises(MissionError, match=sentence):
        layered(start, goal, backend="hardware", hardware=AREA)
    layered(start, goal, hardware=AREA)  # simulated drones are not kept in
    layered([1.2, 0.0], (1.0, 0.0, 1.0), backend="hardware", hardware=AREA)
