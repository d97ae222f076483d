import json

import numpy as np
import pytest

from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.marks import Mark
from crazychoir_fw.recording.storyboard import Note, Storyboard, Window, notes_of


def fault(time, drone, state, kind="gust", **details):
    return {"time": time, "kind": "fault", "drone": drone, "details": {"fault": kind, "state": state, **details}}


def test_faults_last_from_begin_to_end_and_moments_three_seconds():
    events = [
        fault(1.0, "a", "begins", velocity=[0.0, 3.0, 0.0]),
        fault(2.0, "b", "begins", "motor", motor=2),
        fault(2.5, "a", "ends"),
        fault(3.0, "c", "happens", "kick", impulse=[0.015, 0.0, 0.0]),
        {"time": 4.0, "kind": "collision", "drone": "b", "details": {"what": "floor", "other": "floor"}},
        {"time": 4.1, "kind": "collision", "drone": "b", "details": {"what": "floor", "other": "floor"}},
        {"time": 5.0, "kind": "collision", "drone": "b", "details": {"what": "drone", "other": "c"}},
        {"time": 6.0, "kind": "touchdown", "drone": "c", "details": {}},
    ]
    assert notes_of(events, 9.0) == [
        Note("gust, velocity 0 3 0", 1.0, 2.5, "a"),
        Note("motor 2 stops", 2.0, 9.0, "b"),
        Note("kick, impulse 0.015 0 0", 3.0, 6.0, "c"),
        Note("hits the floor", 4.0, 7.0, "b"),
        Note("hits c", 5.0, 8.0, "b"),
    ]


def test_a_storyboard_comes_out_of_the_metadata_of_a_log():
    marks = [Mark(np.array([1.0, 2.0, 0.5]), "t1", 1.0, drone=1, link=np.zeros(3)), Mark(np.zeros(3), kind="target")]
    metadata = {
        "mission": "m",
        "windows": [["go_to", 0.0, 1.0]],
        "pictures": {"marks": [mark.as_dict() for mark in marks], "links": [[0, 1]], "leaders": [0]},
    }
    story = Storyboard.of(FlightLog(np.arange(3.0), ["a", "b"], {}, json.loads(json.dumps(metadata))))
    assert (story.title, story.windows, story.links) == ("m", [Window("go_to", 0.0, 1.0)], [(0, 1)])
    assert story.leaders == {0}
    assert [mark.as_dict() for mark in story.marks] == [mark.as_dict() for mark in marks]
    assert story.marks[0].is_there(1.0) and not story.marks[0].is_there(0.9)


@pytest.mark.parametrize(
    "metadata",
    [
        {"windows": [["go_to", 0.0]]},
        {"pictures": {"links": [[0, 2]]}},
        {"pictures": {"marks": [{"position": [0.0, None, 1.0]}]}},
        {"pictures": {"marks": [{}]}},
        {"pictures": [1]},
    ],
)
def test_metadata_that_explain_nothing_are_refused(metadata):
    with pytest.raises(ValueError):
        Storyboard.of(FlightLog(np.arange(3.0), ["a", "b"], {}, metadata))
