"""Drones over the radio against the mission that they are to fly, and what its campaign says today."""

import json
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
import yaml

pytest.importorskip("cflib")

from lockstep import SILENCE_S, GoingOn
from typer.testing import CliRunner

from crazychoir_fw.campaign.campaign import backend_of, load_campaign
from crazychoir_fw.campaign.standing import standing
from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import MissionError, StateError
from crazychoir_fw.flight import roll_call
from crazychoir_fw.flight.backends import build_world
from crazychoir_fw.flight.real_drones import radio_parts
from crazychoir_fw.mission.loader import load_mission, parse_mission
from crazychoir_fw.preflight import at_rest, drones
from crazychoir_fw.preflight.drones import look
from crazychoir_fw.preflight.firmware import _propellers, is_same_firmware
from crazychoir_fw.preflight.geometry import difference, simulated_stations
from crazychoir_fw.preflight.radio_load import radio_load
from crazychoir_fw.radio import RadioHandlerVel

MISSION = {
    "name": "one",
    "log_rate": 50,
    "drones": [{"id": "a", "position": [0.2, 0.0], "positioning": "lighthouse"}],
    "layers": {
        "rate": 50,
        "guidance": {"class": "SimpleGuidance", "height": 0.5},
        "planning": {"class": "Spline"},
        "control": {"gains": "mujoco"},
    },
    "flight": [{"takeoff": {"duration": 1}}, {"land": {"duration": 1}}],
}
NO_GO = {"hardware": {"safety_area": {"low": [1, -1, -1], "high": [2, 1, 1]}}}


@contextmanager
def serving():
    """One drone of a served world whose time goes on, with its URI."""
    world = build_world(parse_mission(MISSION), visuals=False)
    server = world.serve(port=0, silence=SILENCE_S)
    server.start()
    with GoingOn(world):
        yield SimpleNamespace(drone=world.drones[0], uri=server.uris["a"])
    server.close()


@pytest.fixture(scope="module")
def served():
    with serving() as one:
        yield one


@pytest.fixture(scope="module")
def connected(served, tmp_path_factory):
    """Connects once; returns what looks at the drone as the one of a mission that differs from the served one."""
    radio = {"cache": str(tmp_path_factory.mktemp("tables"))}
    parts = radio_parts(
        parse_mission({**MISSION, "backend": "hardware", "hardware": {"radio": radio}}, uris=[served.uri])
    )

    def see(change=None, drone=None, **options):
        data = {**MISSION, "backend": "hardware", **(change or {})}
        data["drones"] = [{**MISSION["drones"][0], **(drone or {})}]
        flown = parse_mission(data, uris=[served.uri])
        likeness = build_world(flown, visuals=False).drones[0]
        found = look(flown, parts, {"a": likeness}, **options)
        return {line.name: line for line in found.checks}, found.differences

    yield see
    for _, backend in parts:
        backend.close()


@pytest.fixture(autouse=True)
def in_haste(monkeypatch):
    monkeypatch.setattr(at_rest, "REST_S", 0.2)
    monkeypatch.setattr(roll_call, "_SETTLE_S", 0.1)


def bad(found):
    return {name for name, line in found.items() if not line.ok}


def test_a_drone_of_the_mission_is_good(connected):
    found, differences = connected(spins=True)
    assert bad(found) == set() and differences == []
    assert "base stations 0: " in found["geometry"].text and "as simulated" in found["geometry"].text
    assert found["propellers"].text == "good"
    assert found["positioning"].text.startswith("at rest within ")


def test_another_drone_is_not(connected, served, monkeypatch):
    monkeypatch.setattr(at_rest, "SPREAD_M", 0.0)
    monkeypatch.setattr(at_rest, "LATENCY_S", 0.0)
    other = {"position": [1.5, 0.0], "decks": ["zranger"], "parameters": {"colAv.enable": 1.0, "velCtlPid.vxKp": 3.0}}
    found, differences = connected(NO_GO, other)
    assert bad(found) == {"decks", "parameters", "starts", "positioning", "safety area", "links"}
    assert "a has no bcZRanger" in found["decks"].text
    assert "1.3" in found["starts"].text
    marks = {one.name: (one.found, one.wanted, one.is_persistent, one.is_asked) for one in differences}
    assert marks == {"colAv.enable": (0.0, 1.0, False, True), "velCtlPid.vxKp": (25.0, 3.0, True, True)}


def test_parameters_are_set_when_asked_to(connected, served):
    served.drone.param["posCtlPid.xKp"] = 1.25
    value = {"parameters": {"posCtlPid.yKp": 1.75}}
    found, differences = connected(drone=value, applies=True)
    assert found["parameters"].ok
    assert {one.name for one in differences if one.is_applied} >= {"posCtlPid.yKp"}
    assert served.drone.param["posCtlPid.yKp"] == 1.75
    found, differences = connected(applies=True)
    assert served.drone.param["posCtlPid.yKp"] == 2.0


def test_drones_that_fly_are_left_alone(connected, monkeypatch):
    monkeypatch.setattr(drones, "supervisor_bits", lambda cf: drones.IS_FLYING)
    with pytest.raises(StateError, match="a flies, but only drones on the floor"):
        connected(applies=True)


@pytest.mark.parametrize(
    ("version", "tested", "revision", "is_same"),
    [
        ("2026.08", "2026.08 +crazychoir 0.1.0", "", True),
        ("2026.08 +crazychoir 0.1.0", "2026.08 +crazychoir 0.1.0", "", True),
        ("2026.08 +crazychoir 0.0.9", "2026.08 +crazychoir 0.1.0", "", False),
        ("2025.02", "2026.08 +crazychoir 0.1.0", "", False),
        ("2026.08 +3", "2026.08-3-g0123abc", "0123abcdef01", True),
        ("2026.08 +3", "2026.08-3-g0123abc-dirty", "0123abcdef01", True),
        ("2026.08 +3", "2026.08-3-g0123abc", "1123abcdef01", False),
        ("2026.08", "2026.08-3-g0123abc", "", False),
        ("2026.08", "2026.08", "", True),
    ],
)
def test_revisions(version, tested, revision, is_same):
    assert is_same_firmware(version, tested, revision) is is_same


def test_propellers_that_shake_are_named():
    assert _propellers({"health.motorPass": 0b1101}) == "M2 shake, or do not turn"
    assert _propellers({"health.motorPass": 0b1111}) is None


def test_rooms_that_differ():
    drone = build_world(parse_mission(MISSION), visuals=False).drones[0]
    room = simulated_stations(drone)
    assert len(room) == 2 and difference(room, room) is None
    assert difference(room, {**room, 1: room[1] + [0.3, 0.0, 0.0]}) == "base station 1 is 0.30 m away"
    assert difference(room, {0: room[0]}) == "base stations 0, 1 and 0"


@pytest.mark.parametrize(("count", "is_good"), [(2, True), (40, False)])
def test_load_of_a_radio(count, is_good):
    uris = {f"cf{i}": f"radio://0/80/2M/E7E7E7E7{i:02X}" for i in range(1, count + 1)}
    handler = RadioHandlerVel(uris, odometry_hz=100.0)
    flown = parse_mission({**MISSION, "drones": {"count": count}})
    line = radio_load(flown, dict.fromkeys(uris, handler))
    assert line.ok is is_good
    assert f"radio 0: {count} drones use" in line.text


# ------------------------------------------------------------------------------------------------ what was tested


@pytest.fixture
def mission_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "one.yaml"
    path.write_text(yaml.safe_dump(MISSION, sort_keys=False))
    return path


@pytest.fixture
def tested(tmp_path, mission_file):
    """The mission file, of which a campaign was GO."""
    (tmp_path / "campaign.yaml").write_text("{extends: one.yaml, name: one, flights: 1, require: {success: 0.01}}")
    result = CliRunner().invoke(app, ["campaign", "campaign.yaml", "--workers", "1", "--seed", "5"])
    assert result.exit_code == 0, result.output
    return mission_file


def test_a_verdict_counts_as_long_as_nothing_changes(tested):
    folder = tested.parent / "out/one"
    now = standing(tested, (), folder)
    assert now.ok and now.text.startswith("GO: 1 of 1")
    assert "stale" in standing(tested, ["seed=3"], folder).text
    tested.write_text(tested.read_text().replace("height: 0.5", "height: 0.6"))
    now = standing(tested, (), folder)
    assert not now.ok and "stale: mission, values or build were changed since" in now.text
    (tested.parent / "other.yaml").write_text(tested.read_text())
    assert "flew one.yaml, and not" in standing(tested.parent / "other.yaml", (), folder).text
    for damaged in ("{", "[]", json.dumps({"answer": "GO"})):
        (folder / "summary.json").write_text(damaged)
        assert not standing(tested, (), folder).ok
    assert "none was flown" in standing(tested, (), folder / "nowhere").text


def test_the_verdict_of_one_side_counts(mission_file):
    mission_file.with_name("c.yaml").write_text(
        "{extends: one.yaml, name: two, flights: 1, require: {success: 0.01}, compare: {after: {set: [seed=1]}}}"
    )
    CliRunner().invoke(app, ["campaign", "c.yaml", "--workers", "1"])
    for side in ("before", "after"):
        assert standing(mission_file, (), mission_file.parent / "out/two" / side).ok


def test_go_needs_drones_and_campaign(tested):
    with serving() as served:
        result = CliRunner().invoke(app, ["preflight", "one.yaml", "--uri-base", served.uri, "--json"])
    said = json.loads(result.output)
    assert (result.exit_code, said["answer"], said["reasons"]) == (0, "GO", [])


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        ([], 1, "NO-GO campaign: none was flown: nowhere/summary.json is not there; run crazychoir campaign one.yaml"),
        (["--skip", "campaign"], 0, "GO all checks are good"),
        (["--skip", "wind"], 2, "--skip is 'wind', but must be one of campaign"),
    ],
)
def test_answers(mission_file, monkeypatch, words, code, says):
    monkeypatch.setattr(drones, "look_at", lambda *_, **__: drones.Findings([], []))
    uri = ["--uri-base", "udp://127.0.0.1:1", "--campaign", "nowhere"]
    result = CliRunner().invoke(app, ["preflight", "one.yaml", *uri, *words])
    assert result.exit_code == code
    assert says in result.output


def test_drones_that_do_not_answer_leave_it_open(mission_file):
    result = CliRunner().invoke(app, ["preflight", "one.yaml", "--uri-base", "udp://127.0.0.1:1"])
    assert result.exit_code == 2
    assert "nobody listens there" in result.output


@pytest.mark.parametrize("backend", ["hardware", "mixed"])
def test_a_campaign_moves_no_real_drones(tmp_path, backend):
    data = {**MISSION, "backend": backend}
    data["drones"] = [{**MISSION["drones"][0], "uri": "radio://0/80/2M/E7E7E7E701"}]
    data["drones"] += [{"id": "b", "position": [1.0, 0.0]}] if backend == "mixed" else []
    path = tmp_path / "real.yaml"
    path.write_text(yaml.safe_dump(data))
    assert load_mission(path).backend == backend
    whole = load_campaign(path)
    assert whole.mission.backend == "sim"
    assert whole.job(0, {}).command.endswith("--backend sim")
    path.write_text(yaml.safe_dump(MISSION))
    assert backend_of(path, [f"backend={backend}"]) == "sim"
    assert backend_of(path, []) is None
    with pytest.raises(MissionError):
        backend_of(tmp_path / "none.yaml", [])
