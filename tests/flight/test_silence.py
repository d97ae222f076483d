import math

import numpy as np
import pytest

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.flight.silence import Silence
from crazychoir_fw.guidance import GoToGuidance, SimpleGuidance

HERE = Pose(position=np.zeros(3), velocity=np.zeros(3))


class Counted(GoToGuidance):
    def step(self, now):
        return super().step(now)


def agent_of(cls):
    guidance = cls() if cls is SimpleGuidance else cls(goals=[[2.0, 1.0, 0.0, 1.0], [3.0, 0.0, 0.0, 1.0]])
    guidance.set_pose(HERE)
    return Agent(0, "a", guidance)


def steps_of(agent, silence, begin, end):
    """Step guidance every 10 ms as rounds do; return the times at which it was stepped, and what it asked for."""
    stepped, asked = [], []
    for k in range(round(begin * 100), round(end * 100)):
        now = k / 100
        for one in silence.others([agent], now):
            outputs = one.guidance.step(now)
            stepped.append(now)
            asked += [] if outputs.trajectory is None else [(now, outputs.trajectory[0].time_s)]
            silence.look(one, now)
    return stepped, asked


def test_goals_are_sent_in_the_round_in_which_they_are_due():
    agent = agent_of(GoToGuidance)
    silence = Silence([agent])
    agent.guidance.start(0.0)
    stepped, asked = steps_of(agent, silence, 0.0, 4.0)
    assert asked == [(0.0, 2.0), (2.0, 3.0)]
    assert len(stepped) < 60  # of 400 rounds
    assert np.diff(stepped).max() == pytest.approx(0.1)


def test_a_button_ends_the_silence():
    agent = agent_of(SimpleGuidance)
    silence = Silence([agent])
    agent.guidance.takeoff(0.0)
    steps_of(agent, silence, 0.0, 1.0)
    agent.guidance.land(1.0)
    stepped, asked = steps_of(agent, silence, 1.0, 1.05)
    assert stepped[0] == 1.0
    assert len(asked) == 1


def test_a_law_with_steps_of_its_own_is_never_silent():
    agent = agent_of(Counted)
    silence = Silence([agent])
    agent.guidance.start(0.0)
    assert len(steps_of(agent, silence, 0.0, 1.0)[0]) == 100
    assert agent.guidance.silent_until(1.0) == -math.inf


def test_a_guidance_that_another_component_watches_is_stepped():
    agent = agent_of(GoToGuidance)
    agent.guidance.on_change = lambda: None
    silence = Silence([agent])
    agent.guidance.start(0.0)
    assert len(steps_of(agent, silence, 0.0, 1.0)[0]) == 100
