"""What the page marks: targets and intruders, tasks, and loads with where they go."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("nicegui")

from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.gui.marks import Marks
from crazychoir_fw.gui.opening import open_mission
from crazychoir_fw.recording.marks import COLORS

EXAMPLES = Path(__file__).parents[2] / "examples"


class Watched:
    """A flight of point masses, without the thread of a session, and its marks."""

    def __init__(self, name):
        mission = open_mission(EXAMPLES / name, backend="integrator")
        self.names = [drone.id for drone in mission.fleet]
        self.experiment = make_experiment(mission)
        self.marks = Marks(SimpleNamespace(mission=mission, experiment=self.experiment, names=self.names))

    def fly_until(self, kind):
        """Fly on until something of this kind has happened."""
        seen = len(self.experiment.events)
        for _ in range(3000):
            self.experiment.step()
            if any(event.kind == kind for event in self.experiment.events[seen:]):
                return
        raise AssertionError(f"nothing {kind}")

    def details(self, kind):
        return [event.as_dict() for event in self.experiment.events if event.kind == kind]

    def now(self):
        """Return marks by label; each label stands once."""
        found = self.marks.now()
        by_label = {mark["label"]: mark for mark in found}
        assert len(by_label) == len(found)
        return by_label


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("aggregative.yaml", ["target", "intruder"]),
        # these intruders are drones, which are seen anyhow
        ("aggregative_moving_intruders.yaml", ["target"]),
    ],
)
def test_surveillance_has_fixed_marks(name, expected):
    marks = Watched(name).marks.now()
    assert sorted({mark["label"] for mark in marks}) == sorted(expected)
    for mark in marks:
        assert mark["color"] == COLORS[mark["label"]]
        assert np.shape(mark["position"]) == (3,)
        assert "drone" not in mark
    target = next(mark for mark in marks if mark["label"] == "target")
    given = open_mission(EXAMPLES / name, backend="integrator").layers.guidance
    options = (given[0] if isinstance(given, (list, tuple)) else given).options
    np.testing.assert_allclose(target["position"], options["target"])


def test_tasks_are_marked_with_whose_they_are_and_go_when_done():
    flight = Watched("task_assignment.yaml")
    assert flight.now() == {}
    flight.experiment.start()
    flight.fly_until("assigned")
    flight.fly_until("completed")
    told = {
        str(sequence): (x, y) for event in flight.details("tasks") for _, sequence, x, y, _ in event["details"]["tasks"]
    }
    done = {str(event["details"]["number"]) for event in flight.details("completed")}
    marks = flight.now()
    assert done
    assert set(marks) == set(told) - done
    for label, mark in marks.items():
        np.testing.assert_allclose(mark["position"][:2], told[label], atol=1e-3)
        assert mark["link"] is None
    owners = [mark["drone"] for mark in marks.values() if mark["drone"] is not None]
    assert owners
    assert len(set(owners)) == len(owners), "a drone has one task at a time"


def test_loads_are_marked_with_where_they_go():
    flight = Watched("pickup_delivery.yaml")
    requests = [(2.0, 1.2, -0.6, 2.2), (0.3, -2.3, 2.3, -0.2)]  # of loads 0 and 4, from the file
    flight.experiment.start()
    flight.fly_until("assigned")
    marks = flight.now()
    for number, (x, y, to_x, to_y) in zip((0, 4), requests, strict=True):
        load, sink = marks[str(number)], marks[f"→{number}"]
        assert load["position"] == [x, y, 0.0]
        assert load["link"] == sink["position"] == [to_x, to_y, 0.0]
        assert sink["link"] is None
    flight.fly_until("picked")
    (picked,) = flight.details("picked")
    number, drone = picked["details"]["number"], flight.names.index(picked["drone"])
    marks = flight.now()
    assert str(number) not in marks
    assert marks[f"→{number}"]["drone"] == drone


def test_nothing_new_is_not_worked_out_again(monkeypatch):
    flight = Watched("task_assignment.yaml")
    flight.experiment.start()
    flight.fly_until("tasks")
    first = flight.marks.now()
    monkeypatch.setattr(flight.marks, "_works", lambda newest: pytest.fail("nothing has happened since"))
    assert flight.marks.now() == first
