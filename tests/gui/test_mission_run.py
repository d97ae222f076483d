"""MISSION and START on the page: the phases of the mission that it was opened with."""

import numpy as np
import pytest

PHASES = {
    "hello_swarm.yaml": ["takeoff", "go_to", "land"],
    "bearing_formation.yaml": ["takeoff", "start", "land"],
    "figure8.yaml": ["takeoff", "start_trajectory", "land"],
}


@pytest.mark.parametrize("name", PHASES)
def test_mission_flies_its_phases_and_lands(open_flight, api, until, tmp_path, name):
    session = open_flight(name, speed=100.0)
    client = api(session, tmp_path)
    before = session.frame.position.copy()
    session.speed = 0.0
    assert client.command(name="mission")["ok"]
    run, session.speed = session.flying, 100.0
    until(lambda: session.flying is None)
    assert run.phases == ["begins", *PHASES[name], "done"]
    _, samples = session.branches.lineage(0)
    assert max(sample.position[:, 2].max() for sample in samples) > 0.4
    assert {agent.phase.value for agent in session.experiment.agents} == {"landed"}
    assert not [line.text for line in session.lines if line.kind in ("error", "failure")]
    if name == "figure8.yaml":  # closed
        np.testing.assert_allclose(session.frame.position[:, :2], before[:, :2], atol=0.1)


def test_mission_refuses_drones_that_fly(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=100.0)
    client = api(session, tmp_path)
    client.command(name="takeoff", drones=["agent_1"])
    answer = client.command(name="mission")
    assert answer == {"ok": False, "text": "MISSION: agent_1 flies already; LAND first"}


def test_a_button_takes_its_drones_out_of_the_mission(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=1.0)
    client = api(session, tmp_path)
    assert client.command(name="mission")["ok"]
    until(lambda: session.flying.phase == "takeoff")
    client.command(name="stop", drones=["agent_0"])
    session.speed = 100.0
    until(lambda: session.flying is None)
    states = {agent.name: agent.phase.value for agent in session.experiment.agents}
    assert states.pop("agent_0") == "stopped"
    assert set(states.values()) == {"landed"}
    kinds = [(event.kind, event.drone) for event in session.experiment.events]
    assert ("land", "agent_0") not in kinds and ("land", "agent_1") in kinds


def test_a_mission_that_is_rewound_goes_on(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=100.0)
    client = api(session, tmp_path)
    assert client.command(name="mission")["ok"]
    until(lambda: session.flying is None)
    landing = next(event.time for event in session.experiment.events if event.kind == "land")
    session.speed = 0.0
    assert client.command(name="rewind", time=landing - 0.1)["ok"]
    assert session.flying.phase in ("takeoff", "hover")  # moments are up to 2 s apart
    session.speed = 100.0
    until(lambda: session.flying is None)
    assert {agent.phase.value for agent in session.experiment.agents} == {"landed"}


def test_start_is_offered_where_it_means_something(open_flight, api, tmp_path):
    plain, formation = open_flight("draw.yaml"), open_flight("bearing_formation.yaml")
    about = api(plain, tmp_path).get("/api/setting").json()
    assert "start" in about["missing"] and about["phases"] == ["takeoff", "hover", "land"]
    answer = api(plain, tmp_path).command(name="start")
    assert not answer["ok"] and "MISSION" in answer["text"]
    assert "start" not in api(formation, tmp_path).get("/api/setting").json()["missing"]


def test_a_plan_for_planners_on_board_needs_simulated_drones(open_flight, tmp_path):
    from crazychoir_fw.flight.access import Access
    from crazychoir_fw.gui.mission_run import cannot_run

    session = open_flight("figure8.yaml")
    assert cannot_run(session.mission, session.access) is None
    assert "simulated" in cannot_run(session.mission, Access(session.experiment.backend))


def test_parameters_are_described_and_compared_with_defaults(open_flight, api, tmp_path):
    session = open_flight("draw.yaml")
    client = api(session, tmp_path)
    assert client.command(name="set_parameter", parameter="posCtlPid.xKp", value=1.5)["ok"]
    rows = {row["name"]: row for row in client.get("/api/parameters?drone=agent_0").json()["parameters"]}
    row = rows["posCtlPid.xKp"]
    assert (row["value"], row["default"], row["unit"]) == (1.5, 2.0, "1/s")
    assert row["description"] == "proportional gain of position"


def test_drones_go_to_their_starts_after_a_landing_elsewhere(open_flight, api, until, tmp_path):
    session = open_flight("draw.yaml", speed=100.0, backend="integrator")
    client = api(session, tmp_path)
    answer = client.command(name="starts")
    assert answer == {"ok": False, "text": "GO TO STARTS: all 4 drones must fly first; press TAKE-OFF"}
    starts = session.frame.position[:, :2].copy()
    client.command(name="takeoff")
    until(lambda: session.frame.position[:, 2].min() > 0.4)
    client.command(name="goto", drones=["agent_0", "agent_1"], x=1.5, y=1.5, z=1.0, duration=3.0)
    until(lambda: np.linalg.norm(session.frame.position[:2, :2] - starts[:2], axis=1).min() > 0.5)
    session.speed = 0.0
    answer = client.command(name="starts", drones=["agent_0", "agent_1"])
    assert answer["ok"] and answer["text"].startswith("GO TO STARTS (")
    assert answer["text"].endswith("agent_0, agent_1")
    assert client.command(name="starts")["text"].startswith("GO TO STARTS: 'GO TO STARTS' is being flown")
    session.speed = 100.0
    until(lambda: session.flying is None)
    np.testing.assert_allclose(session.frame.position[:, :2], starts, atol=0.1)
