"""The phases of a swarm: arrays that follow every change of an agent's phase."""

import pytest

from crazychoir_fw.flight.agent import Agent, DronePhase, SwarmPhases


@pytest.fixture
def agents():
    return [Agent(i, f"agent_{i}", None) for i in range(3)]


def test_a_swarm_begins_on_the_ground(agents):
    phases = SwarmPhases(agents)
    assert phases.turning.tolist() == [False] * 3 and phases.up == [] and not phases.is_anybody_landing
    assert phases.numbers.tolist() == [DronePhase.GROUND.number] * 3


@pytest.mark.parametrize("phase", list(DronePhase))
def test_a_look_sees_what_an_agent_was_set_to(agents, phase):
    phases = SwarmPhases(agents)
    agents[1].phase = phase
    phases.look()
    assert phases.turning.tolist() == [False, phase.has_motors_on, False]
    assert phases.up == ([agents[1]] if phase.has_motors_on else [])
    assert phases.numbers.tolist() == [0, phase.number, 0]
    assert phases.is_anybody_landing == (phase is DronePhase.LANDING)


def test_arrays_that_were_handed_out_stay_what_they_were(agents):
    phases = SwarmPhases(agents)
    before = phases.turning
    phases.look()
    assert phases.turning is before  # nothing has changed
    agents[0].phase = DronePhase.FLYING
    phases.look()
    assert before.tolist() == [False] * 3 and phases.turning.tolist() == [True, False, False]
    with pytest.raises(ValueError, match="read-only"):
        phases.turning[0] = False
