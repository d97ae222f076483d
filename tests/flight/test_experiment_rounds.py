"""Experiments on the integrator, which is quick: rounds, buttons, and layers that fail."""

import numpy as np
import pytest
from flown_layers import NAMES, formation, hover, mission, within

from crazychoir_fw.common.errors import CrazychoirError, UnknownNameError
from crazychoir_fw.common.messages import TrajectoryPoint
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.agents import make_controller
from crazychoir_fw.flight.control_group import ControlGroup
from crazychoir_fw.flight.engine import fly, make_experiment

RAISES = """
from crazychoir_fw.guidance import BearingFormation

class Fragile(BearingFormation):
    def evaluate_input(self, neigh_data):
        return super().evaluate_input(neigh_data)

    def respond(self, neigh_data, now):
        if self.agent_id == {agent} and now > 4.0:
            {what}
        return super().respond(neigh_data, now)
"""


def fragile(tmp_path, what, agent=2):
    (tmp_path / "mine.py").write_text(RAISES.format(what=what, agent=agent))
    data = within(formation(), "layers.guidance.class", "mine.py:Fragile")
    return mission(data, folder=tmp_path)


@pytest.fixture(scope="module")
def square():
    return fly(mission(formation(criteria={"bearing_error_deg": 1.0, "position_error_m": 0.05})))


def test_formation_is_reached_and_everybody_lands(square):
    assert square.success, square.failures
    assert square.summary["bearing_error_deg"] < 1.0
    assert [drone["phase"] for drone in square.summary["drones"]] == ["landed"] * 4
    assert [drone["role"] for drone in square.summary["drones"]] == ["leader"] * 2 + ["follower"] * 2
    assert {entry["criterion"] for entry in square.summary["criteria"]} == {
        "bearing_error_deg",
        "position_error_m",
        "landed",
    }


@pytest.mark.parametrize("backend", ["integrator", "sim"])
def test_take_off_after_a_landing_elsewhere_goes_straight_up(backend):
    data = hover(2, seed=1, backend=backend)
    away = [TrajectoryPoint(2.0, np.array([0.6, 0.8, 0.5]))]
    experiment = make_experiment(mission(data))
    experiment.takeoff()
    experiment.run(2.5)
    experiment.set_trajectory(away, "a")
    experiment.run(3.0)
    experiment.land()
    assert experiment.run_until_landed(6.0)
    experiment.run(2.0)
    stood = experiment.backend.true_positions()[0].copy()
    assert stood == pytest.approx([0.6, 0.8, 0.02], abs=0.1)
    experiment.takeoff("a")
    farthest = 0.0
    for _ in range(60):
        experiment.run(0.05)
        here = experiment.backend.true_positions()[0]
        farthest = max(farthest, float(np.hypot(*(here - stood)[:2])))
    assert here[2] == pytest.approx(0.5, abs=0.1)
    assert farthest < 0.1


def test_same_mission_gives_the_same_bits(square):
    again = fly(mission(formation()))
    for name, samples in square.log.signals.items():
        assert np.array_equal(samples, again.log.signals[name], equal_nan=True), name


def test_bearing_errors_over_time_fall(square):
    curve = square.curve
    flown = np.flatnonzero(np.isfinite(curve.mean))
    assert curve.mean[flown[75]] > 5.0
    end = square.judge.windows[1].end
    assert curve.mean[np.searchsorted(square.log.time, end) - 1] < 1.0


def test_one_by_one_and_together_give_the_same_flight(square):
    apart = make_experiment(mission(formation()))
    apart._together = None
    for press, seconds in ((apart.takeoff, 3.0), (apart.start, 8.0)):
        press()
        apart.run(seconds)
    at = square.judge.windows[1].end
    there = np.searchsorted(square.log.time, at - 1e-9)
    together = [square.log.signals[f"sim.{axis}"][there] for axis in "xyz"]
    np.testing.assert_allclose(apart.backend.true_positions().T, together, atol=1e-5)


def test_nothing_turns_before_takeoff_and_after_landing():
    experiment = make_experiment(mission(hover()))
    experiment.run(0.5)
    assert np.all(experiment.backend.integrator.input == 0.0)
    experiment.takeoff()
    experiment.run(2.5)
    assert experiment.backend.true_positions()[0, 2] == pytest.approx(0.5, abs=0.02)
    experiment.land()
    assert experiment.run_until_landed(5.0)
    experiment.run(0.5)
    assert np.all(experiment.backend.integrator.input == 0.0)
    assert experiment.agents[0].phase is DronePhase.LANDED
    assert [h.kind for h in experiment.events] == ["takeoff", "land", "landed"]
    experiment.stop()
    assert experiment.agents[0].phase is DronePhase.LANDED


def test_a_drone_that_is_stopped_in_the_air_has_not_landed():
    experiment = make_experiment(mission(hover()))
    experiment.stop()
    assert experiment.agents[0].phase is DronePhase.GROUND
    experiment.takeoff()
    experiment.run(1.0)
    experiment.stop()
    assert experiment.agents[0].phase is DronePhase.STOPPED
    assert not experiment.agents[0].is_up
    experiment.takeoff()
    assert experiment.agents[0].phase is DronePhase.FLYING


def test_buttons_of_some_drones():
    experiment = make_experiment(mission(hover(2)))
    experiment.takeoff("b")
    experiment.run(2.5)
    heights = experiment.backend.true_positions()[:, 2]
    np.testing.assert_allclose(heights, [0.0, 0.5], atol=0.02)
    with pytest.raises(UnknownNameError, match="there is no drone 'z', allowed: a, b"):
        experiment.land(["z"])


def test_stop_button_stops_at_once_and_takeoff_begins_anew():
    experiment = make_experiment(mission(hover()))
    experiment.takeoff()
    experiment.run(2.5)
    experiment.stop()
    experiment.run(1.0)
    assert experiment.backend.true_positions()[0, 2] == 0.0
    experiment.takeoff()
    experiment.run(2.5)
    assert experiment.backend.true_positions()[0, 2] == pytest.approx(0.5, abs=0.03)


def test_a_drawn_curve_is_flown_through_its_points():
    experiment = make_experiment(mission(hover()))
    experiment.takeoff()
    experiment.run(2.0)
    points = [TrajectoryPoint(t, np.array(p)) for t, p in ((2.0, (0.5, 0, 0.5)), (4.0, (0.5, 0.5, 0.7)))]
    experiment.set_trajectory(points)
    experiment.run(2.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[0], [0.5, 0, 0.5], atol=0.03)
    experiment.run(3.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[0], [0.5, 0.5, 0.7], atol=0.02)


@pytest.mark.parametrize(
    ("control", "planning"),
    [
        ({"sender": "FRPYSender", "gains": "mujoco"}, "Polynomial7th"),
        ({"class": "VelocityController", "gains": "mujoco"}, "SplinePosition"),
        ({"gains": {"position": "mujoco", "attitude": {"k_r": 8.0}}}, "MinimumSnap"),
        (None, None),  # the planner on board
    ],
)
def test_every_sender_flies_goals(control, planning):
    layers = {
        "rate": 50,
        "odometry": "truth",
        "guidance": {"class": "GoToGuidance", "goals": {"a": [[3, 0, 0, 0.5], [4, 0.5, 0.2, 0.8]]}},
    }
    if control is not None:
        layers |= {"control": control, "planning": {"class": planning}}
    data = hover(layers=layers, flight=[{"start": {"duration": 9}}], criteria={"landed": False})
    experiment = make_experiment(mission(data))
    experiment.start()
    experiment.run(9.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[0], [0.5, 0.2, 0.8], atol=0.02)


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("raise ZeroDivisionError('in the middle')", "ZeroDivisionError: in the middle (mine.py:10)"),
        (
            "import numpy as np; return type(super().respond(neigh_data, now))(acceleration=np.full(3, np.nan))",
            "allowed: three finite numbers",
        ),
    ],
)
def test_a_guidance_that_fails_stops_its_own_drone_only(tmp_path, what, said):
    result = fly(fragile(tmp_path, what))
    assert not result.success
    assert len([failure for failure in result.failures if failure.startswith("c:")]) == 1
    assert said in result.failures[0]
    assert [drone["phase"] for drone in result.summary["drones"]] == ["landed", "landed", "failed", "landed"]
    events = result.summary["events"]
    failed = next(event["time"] for event in events if event["kind"] == "failure")
    lost = [event for event in events if event["kind"] == "lost"]
    assert {event["drone"] for event in lost} >= {"d"}
    assert all(event["details"]["reason"] == "lost c" for event in lost)
    assert all(failed < event["time"] < failed + 1.0 for event in lost)
    # the others reach their places in the formation
    places = result.judge.places()
    assert np.linalg.norm(result.judge._at[result.judge._final].mean(axis=0)[3] - places[3]) < 0.1


def test_a_drone_that_may_fail_does_not_spoil_the_flight(tmp_path):
    flown = fragile(tmp_path, "raise ValueError")
    result = fly(flown.model_copy(update={"may_fail": ["c"]}))
    assert result.success, result.failures
    assert result.expected_failures[0].startswith("c: Fragile: ValueError")


def test_a_class_of_the_users_must_be_what_it_is_taken_for(tmp_path):
    (tmp_path / "mine.py").write_text("class Guide: pass\n")
    data = within(formation(), "layers.guidance.class", "mine.py:Guide")
    with pytest.raises(CrazychoirError, match="a subclass of CFGuidance"):
        make_experiment(mission(data, folder=tmp_path))
    data = within(formation(), "layers.guidance.class", "mine.py:Other")
    with pytest.raises(CrazychoirError, match="there is no such class, only Guide"):
        make_experiment(mission(data, folder=tmp_path))


def test_a_law_of_the_users_flies(tmp_path):
    (tmp_path / "law.py").write_text(
        "from crazychoir_fw.control import FlatnessPositionCtrl\n"
        "class Higher(FlatnessPositionCtrl):\n"
        "    def force(self, current_pose, desired_reference):\n"
        "        return super().force(current_pose, desired_reference) + [0.05, 0.0, 0.0]\n"
    )
    data = within(hover(), "layers.control", {"position": "law.py:Higher", "gains": "webots"})
    experiment = make_experiment(mission(data, folder=tmp_path))
    experiment.takeoff()
    experiment.run(6.0)
    # k_p is 0.4 N/m
    assert experiment.backend.true_positions()[0, 0] == pytest.approx(0.05 / 0.4, abs=0.05)


def test_asynchronous_formation_with_noisy_poses():
    data = within(formation(), "layers.communication.mode", "asynchronous")
    data = within(data, "layers.odometry", "mocap")
    result = fly(mission({**data, "criteria": {"bearing_error_deg": 1.0, "position_error_m": 0.05}}))
    assert result.success, result.failures


def test_drag_and_disturbance_are_those_of_the_file(square):
    rough = fly(mission(formation(integrator={"drag": "rotor", "disturbance": {"sigma": 0.005}})))
    assert rough.summary["bearing_error_deg"] > 3.0 * square.summary["bearing_error_deg"]


def test_drones_that_start_in_the_air_wait_there():
    data = formation()
    data["drones"] = [{**drone, "position": [*drone["position"], 0.8]} for drone in data["drones"]]
    experiment = make_experiment(mission(data))
    experiment.run(1.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[:, 2], 0.8)
    experiment.start()
    experiment.run(10.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[:, 2], 0.8, atol=0.01)
    assert [agent.name for agent in experiment.agents] == NAMES


def test_one_controller_for_all_is_that_of_each():
    """Leaders and followers share an object; what it commands is what theirs would."""
    together = make_experiment(mission(formation()))
    apart = make_experiment(mission(formation()))
    assert len(together.groups) == 1
    rows = {"fullstate": [0, 1], "acceleration": [2, 3]}
    masses = list(apart.backend.masses)
    apart.groups = [
        ControlGroup(make_controller(mission(formation()), own, masses), own, "fpqr", follows)
        for follows, own in rows.items()
    ]
    for experiment in (together, apart):
        experiment.takeoff()
        experiment.run(3.0)
        experiment.start()
        experiment.run(1.0)
    np.testing.assert_allclose(together.backend.integrator.state, apart.backend.integrator.state, atol=1e-9)
    assert np.linalg.norm(together.backend.poses().velocity[2]) > 0.1
