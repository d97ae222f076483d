"""What is checked before drones over the radio fly."""

import numpy as np
import pytest
from flown_layers import hover, mission, within

pytest.importorskip("cflib")

from served_drones import Served

from crazychoir_fw.common.errors import MissionError, StateError
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.flight.roll_call import roll_call
from crazychoir_fw.mission.loader import load_mission
from crazychoir_fw.radio import identity

STANDING = [(1.5, 0.0), (0.4, 0.0)]


def standing(positions, *, names=("a", "b")):
    """Return drones that stand at places."""
    return [{"id": name, "position": list(at)} for name, at in zip(names, positions, strict=True)]


@pytest.fixture
def serve(tmp_path):
    """Return a function that serves two drones standing anywhere, under the names of the mission's."""
    opened = []

    def start(positions, names=("a", "b")):
        served = Served(mission({**hover(2), "drones": standing(positions, names=names)}), tmp_path)
        opened.append(served)
        served.names = ["a", "b"]
        return served

    yield start
    for served in opened:
        served.close()


def called(served, **hardware):
    flown = mission(hover(2, hardware=hardware))
    roll_call(flown, [([0, 1], served)])  # time goes on while it waits


def test_drones_at_their_places_may_fly(serve):
    called(serve([(0.0, 0.1), (1.0, 0.0)]))


def test_drones_elsewhere_do_not_fly(serve):
    served = serve(STANDING)
    with pytest.raises(StateError, match=r"a stands at \(1\.\d\d, .*\), 1\.\d\d m from its start \(0\.00, 0\.00\)"):
        called(served)
    called(served, start_tolerance_m=2.0)
    called(served, accept=["places"])


def test_a_flight_ends_before_it_begins(serve):
    served, flown = serve(STANDING), mission(hover(2))

    def checked():
        roll_call(flown, [([0, 1], served)])

    served.before_flight = checked
    with pytest.raises(StateError, match="nothing flies"):
        fly(flown, backend=served)
    assert served.world_there.positions()[:, 2].max() < 0.05


def test_drones_of_another_program_do_not_fly(serve):
    served = serve([(0.0, 0.0), (1.0, 0.0)], names=("cf1", "b"))
    with pytest.raises(StateError, match="answers 'cf1' of a served simulation, and not a"):
        called(served)
    called(served, accept=["names"])


def test_a_mixture_does_not_fly(serve, monkeypatch):
    served = serve([(0.0, 0.0), (1.0, 0.0)])
    monkeypatch.setattr(served, "simulated_names", lambda: ["a", None])
    with pytest.raises(StateError, match="b: real, but simulations answer for a"):
        called(served)
    called(served, accept=["mixture"])


def test_a_real_drone_has_no_truth_in_its_log(serve):
    served = serve([(0.0, 0.0), (1.0, 0.0)])
    cf = served.handler["a"].cf
    assert identity.simulated_name(cf) == "a"
    del cf.log.toc.toc["sim"]
    assert identity.simulated_name(cf) is None


def test_empty_batteries_and_drones_that_lie_do_not_fly(serve):
    served = serve([(0.0, 0.0), (1.0, 0.0)])
    with pytest.raises(StateError, match=r"b has \d\.\d\d V, allowed: 5 V or more"):
        called(served, least_battery_v=5.0)
    served.world_there.drones[1].emergency_stop()
    served.world_there.run(0.3)
    with pytest.raises(StateError, match="b: it is locked, and must be restarted"):
        called(served)


def test_drones_take_off_straight_up_from_where_they_stand(serve):
    served = serve(STANDING)
    experiment = make_experiment(mission(hover(2)), served)
    begin = served.world_there.positions()[:, :2].copy()
    experiment.takeoff()
    apart = []
    for _ in range(50):
        experiment.step()
        apart.append(np.linalg.norm(served.world_there.positions()[:, :2] - begin, axis=1).max())
    experiment.run(1.5)
    assert served.world_there.positions()[:, 2] == pytest.approx(0.5, abs=0.06)
    assert max(apart) < 0.1
    assert np.linalg.norm(served.world_there.positions()[:, :2] - begin, axis=1).max() < 0.1


MIXED = """
backend: mixed
drones:
  - {id: a, position: [0, 0], uri: "udp://127.0.0.1:1"}
  - {id: b, position: [1, 0]}
  - {id: c, position: [2, 0], uri: "udp://127.0.0.1:2"}
layers:
  guidance: {class: SimpleGuidance, height: 0.5}
  planning: {class: Spline}
  control: {gains: mujoco}
flight: [{takeoff: {duration: 2}}]
"""


def test_simulated_drones_of_a_mixed_mission_stay_simulated(tmp_path):
    path = tmp_path / "mission.yaml"
    path.write_text(MIXED)
    flown = load_mission(path, "udp://127.0.0.1:19850")
    assert [drone.uri for drone in flown.fleet] == ["udp://127.0.0.1:19850", None, "udp://127.0.0.1:19851"]


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("start_tolerance_m", 0.0, "hardware.start_tolerance_m"),
        ("accept", ["all"], "hardware.accept"),
        ("least_battery_v", -1, "hardware.least_battery_v"),
    ],
)
def test_settings_out_of_range_are_refused(key, value, says):
    with pytest.raises(MissionError, match=says):
        mission(within(hover(2), f"hardware.{key}", value))
