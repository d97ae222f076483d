"""What the page says of take-offs that some drones refuse."""

import pytest


@pytest.fixture
def flight(open_flight, api, tmp_path):
    session = open_flight("draw.yaml", speed=0.0, backend="integrator")
    return session, api(session, tmp_path)


@pytest.mark.parametrize(
    ("refused", "answer"),
    [
        ([], {"ok": True, "text": "TAKE-OFF: all 4 drones"}),
        (
            [1],
            {
                "ok": True,
                "text": "TAKE-OFF: agent_0, agent_2, agent_3; but agent_1: the motors may not run",
            },
        ),
        ([0, 1, 2, 3], {"ok": False, "text": "; ".join(f"agent_{i}: the motors may not run" for i in range(4))}),
    ],
)
def test_who_stays_on_the_floor_is_named(flight, monkeypatch, refused, answer):
    session, client = flight
    monkeypatch.setattr(session.experiment.backend, "unlock", lambda indices: refused)
    assert client.command(name="takeoff") == answer
    assert [agent.is_up for agent in session.experiment.agents] == [i not in refused for i in range(4)]
