"""Missions with layers: what their files may say, and what is said of files that are wrong."""

import pytest
from flown_layers import formation, hover, mission, within

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.mission.loader import numbered_uris, parse_mission
from crazychoir_fw.mission.schema import LayeredMission, Mission


def test_layers_make_another_mission():
    assert isinstance(mission(formation()), LayeredMission)
    plain = {"name": "plain", "drones": [{"id": "a", "position": [0, 0]}], "flight": ["takeoff", "land"]}
    assert type(parse_mission(plain)) is Mission


def test_words_alone_are_buttons_with_nothing_set():
    flight = mission(formation(flight=["takeoff", {"start": {"duration": 1}}, "land"])).flight
    assert [phase.name for phase in flight] == ["takeoff", "start", "land"]
    assert flight[0].maneuver.duration == 5.0


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("layers.guidance.class", "BaringFormation", "did you mean 'BearingFormation'"),
        ("layers.guidance.class", "no_such_file.py:Mine", "no existing file"),
        ("layers.guidance.clas", "BearingFormation", "did you mean 'class'"),
        ("layers.guidance.leaders", ["a", "z"], "layers.guidance.leaders names 'z'"),
        ("layers.guidance.leaders", [], "leader"),
        ("layers.guidance.formation", [[0, 0]], "has 1 places, but must have 4"),
        ("layers.guidance.formation", None, "layers.guidance.formation is missing"),
        ("layers.guidance.formation", [[0, 0], [0, 0], [1, 0], [0, 1]], "apart"),
        ("layers.guidance.gains", {"k_q": 1.0}, "has no key 'k_q'"),
        ("layers.guidance.gains", "webbots", "gains is 'webbots'"),
        ("layers.guidance.goals", {"a": [[1, 0, 0, 1]]}, "are for the class GoToGuidance"),
        ("layers.communication.graph", "complet", "did you mean 'complete'"),
        ("layers.communication.graph", [["a", "z"]], "names 'z'"),
        ("layers.communication.graph", [], "layers.communication.graph is missing"),
        ("layers.communication.graph", {"random": {"probabilty": 0.5}}, "did you mean 'probability'"),
        ("layers.communication.graph", [["a", "b"], ["a", "c"], ["a", "d"]], "ambiguous"),
        ("layers.communication.deadline_s", 0.0, "[0.001, 10]"),
        ("layers.rate", 33, "one of 10, 20, 25, 50, 100 Hz"),
        ("layers.odometry", "gps", "one of estimate, truth, mocap"),
        ("layers.control.sender", "FPQSender", "did you mean 'FPQRSender'"),
        ("layers.control.sender", "VelSender", "must be FPQRSender or FRPYSender"),
        ("layers.control.gains", {"positon": "vicon"}, "position, attitude, velocity"),
        ("layers.control", None, "layers.control is missing"),
        ("layers.planning.class", "Splin", "did you mean 'Spline'"),
        ("flight", [{"takeoff": {"drones": ["z"]}}], "flight[0].takeoff.drones names 'z'"),
        ("flight", [{"takeof": {}}], "did you mean 'takeoff'"),
        ("flight", [{"go_to": {"position": [0, 0, 1], "duration": 2}}], "sends 4 drones to one point"),
        ("flight", [{"trajectory": {"points": [[0, 0, 0, 1], [0, 1, 0, 1]]}}], "times that increase"),
        ("flight", [{"trajectory": {"file": "no.csv"}}], "cannot be read"),
        ("criteria", {"bearing_error": 1.0}, "did you mean 'bearing_error_deg'"),
        ("criteria", {"position_error_m": -1.0}, "[0, 1000] m"),
        ("log_rate", 30, "divisor of 50 Hz"),
        ("backend", "simulation", "one of sim, integrator, hardware"),
        ("backend", "hardware", "drones[0].uri is missing"),
        ("integrator.drag", [1, 2], "rotor, or three numbers"),
        ("hardware.odometry_hz", 200, "[10, 100] Hz"),
        ("faults", [{"kick": {"at": 1, "impulse": [0.01, 0, 0]}}], "faults are for the backend sim"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(path, value, said):
    with pytest.raises(CrazychoirError) as caught:
        from crazychoir_fw.flight.engine import make_experiment

        make_experiment(mission(within(formation(), path, value)))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mission_without_layers_has_one_backend():
    plain = {"name": "plain", "drones": [{"id": "a", "position": [0, 0]}], "flight": ["takeoff"]}
    with pytest.raises(MissionError, match="the others fly missions with layers"):
        parse_mission(plain, backend="integrator")


def test_criteria_of_bearings_need_a_formation():
    with pytest.raises(MissionError, match="needs layers.guidance.formation"):
        mission(hover(criteria={"bearing_error_deg": 1.0}))


def test_backend_and_uris_are_stronger_than_the_file():
    uris = [f"udp://127.0.0.1:{port}" for port in range(19850, 19854)]
    flown = mission(formation(), backend="hardware", uris=uris)
    assert flown.backend == "hardware"
    assert [drone.uri for drone in flown.fleet] == uris
    with pytest.raises(MissionError, match="there are 1 uris, but must be 4"):
        mission(formation(), backend="hardware", uris=uris[:1])


def test_two_drones_at_one_uri_are_refused():
    with pytest.raises(MissionError, match=r"drones\[1\].uri is .* has it already"):
        mission(formation(), backend="hardware", uris=["udp://127.0.0.1:19850"] * 4)


@pytest.mark.parametrize(
    ("base", "last"),
    [
        ("udp://127.0.0.1:19850", "udp://127.0.0.1:19852"),
        ("radio://0/80/2M/E7E7E7E7FE", "radio://0/80/2M/E7E7E7E800"),
    ],
)
def test_uris_are_numbered(base, last):
    uris = numbered_uris(base, 3)
    assert uris[0] == base
    assert uris[2] == last


@pytest.mark.parametrize("base", ["udp://127.0.0.1", "udp://127.0.0.1:65535", "radio://0/80/2M/FFFFFFFFFF", "usb://0"])
def test_uris_that_cannot_be_numbered(base):
    with pytest.raises(MissionError, match="--uri-base"):
        numbered_uris(base, 3)


def test_a_drawn_curve_is_read_from_a_file(tmp_path):
    (tmp_path / "curve.csv").write_text("time,x,y,z\n# begin\n0,0,0,1\n2.5,1,0,1\n")
    data = hover(flight=[{"trajectory": {"file": "curve.csv"}}])
    phase = parse_mission(data, folder=tmp_path).flight[0]
    assert phase.maneuver.rows == [(0.0, 0.0, 0.0, 1.0), (2.5, 1.0, 0.0, 1.0)]
    assert phase.maneuver.duration == 2.5


@pytest.mark.parametrize("line", ["1,2,3", "1,2,3,x", "1,2,3,nan", "1,2,3,4,5"])
def test_a_line_that_is_no_point_is_named(tmp_path, line):
    (tmp_path / "curve.csv").write_text(f"0,0,0,1\n{line}\n")
    with pytest.raises(MissionError, match=r"curve.csv, line 2: allowed: four numbers"):
        parse_mission(hover(flight=[{"trajectory": {"file": "curve.csv"}}]), folder=tmp_path)
