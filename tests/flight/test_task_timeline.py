"""Marks of tasks, with or without a drone."""

import numpy as np

from crazychoir_fw.guidance.schemes.tasks.task_timeline import timeline_of


def event(time, kind, drone=None, **details):
    return {"time": time, "kind": kind, "drone": drone, "details": details}


def test_a_task_that_nobody_takes_is_marked_to_the_end():
    timeline = timeline_of([event(1.0, "tasks", tasks=[[0, 7, 0.5, -0.5, [0]]])], ["a"], 4.0)
    (mark,) = timeline.marks
    assert (mark.label, mark.begin, mark.end, mark.drone) == ("7", 1.0, 4.0, None)
    np.testing.assert_array_equal(mark.position, [0.5, -0.5, 0.0])
    assert timeline.intervals == []


def test_one_mark_for_each_owner_without_gaps():
    events = [
        event(1.0, "tasks", tasks=[[0, 7, 0.5, -0.5, [0, 1]]]),
        event(2.0, "assigned", "a", takes=[7]),
        event(3.0, "assigned", "a", takes=[]),
        event(4.0, "assigned", "b", takes=[7]),
        event(6.0, "completed", "b", number=7),
    ]
    timeline = timeline_of(events, ["a", "b"], 9.0)
    assert [(mark.begin, mark.end, mark.drone) for mark in timeline.marks] == [
        (1.0, 2.0, None),
        (2.0, 3.0, 0),
        (3.0, 4.0, None),
        (4.0, 6.0, 1),
    ]
    assert [(interval.drone, interval.begin, interval.end) for interval in timeline.intervals] == [
        (0, 2.0, 3.0),
        (1, 4.0, 6.0),
    ]
