"""Deciding together gives what each decides by itself."""

import numpy as np
import pytest
from guidance_swarm import GRID, SQUARE, SQUARE_GRAPH, SQUARE_STARTS, Swarm, grid_graph

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import BearingFormation, GuidanceGroup, SimpleGuidance
from crazychoir_fw.guidance.cf_guidance import Phase


class Alone(Swarm):
    """Agents one by one: first all send, then all agents whose round is complete decide."""

    def decide(self):
        up = [self.agents[i] for i in sorted(self.alive)]
        for agent in up:
            agent.begin_round(self.now)
        return {a.agent_id: a.finish_round(self.now) for a in up if a.is_complete(self.now)}


class Grouped(Swarm):
    """Counts what is decided together."""

    together = 0
    sends = True

    def decide(self):
        up = [self.agents[i] for i in sorted(self.alive)]
        if self.group is None or self.group.agents != up:
            self.group = GuidanceGroup(up, sends=self.sends)
        outputs = super().decide()
        self.together += self.group.was_together
        return outputs


class Silent(Grouped):
    """Sends only where it tells something new."""

    sends = False


def both(formation, graph, starts, **options):
    return [kind(formation, graph, starts, noise=(0.002, 0.02), dt=0.01, **options) for kind in (Alone, Grouped)]


@pytest.mark.parametrize("gains", ["webots", "vicon", "mujoco"])
def test_together_as_alone_through_a_whole_flight(gains):
    swarms = both(SQUARE, SQUARE_GRAPH, SQUARE_STARTS * (1, 1, 0.015), gains=gains, takeoff_time=2.0)
    for swarm in swarms:
        swarm.measure()
        swarm.press("takeoff")
        swarm.run(3.0)
        swarm.press("start")
        swarm.run(4.0)
        swarm.press("land")
        swarm.run(3.0)
    alone, grouped = swarms
    assert grouped.together == 400
    np.testing.assert_allclose(grouped.position, alone.position, atol=1e-9)
    assert [a.phase for a in alone.agents] == [a.phase for a in grouped.agents]


def test_together_as_alone_with_thirty():
    swarms = both(GRID, grid_graph(), GRID + np.random.default_rng(1).normal(0.0, 0.2, GRID.shape), gains="mujoco")
    for swarm in swarms:
        swarm.press("start")
        swarm.run(2.0)
    np.testing.assert_allclose(swarms[1].position, swarms[0].position, atol=1e-9)
    assert swarms[1].together == 200
    for first, second in zip(swarms[0].agents, swarms[1].agents, strict=True):
        assert first.communicator.statistics == second.communicator.statistics


@pytest.mark.parametrize("victim", [0, 2, 3])
def test_together_as_alone_when_one_is_lost_and_comes_back(victim):
    swarms = both(SQUARE, SQUARE_GRAPH, SQUARE_STARTS, gains="mujoco")
    for swarm in swarms:
        swarm.press("start")
        swarm.run(2.0)
        swarm.kill(victim)
        swarm.run(3.0)
        swarm.agents[victim] = swarm.make(victim)
        swarm.alive.add(victim)
        swarm.measure()
        swarm.agents[victim].start(swarm.now)
        swarm.run(2.0)
    np.testing.assert_allclose(swarms[1].position, swarms[0].position, atol=1e-9)
    assert swarms[0].events == swarms[1].events != []
    assert swarms[1].together > 380


def test_laws_of_users_are_asked():
    class Lazy(BearingFormation):
        def respond(self, neigh_data, now):
            return None

    class Lazies(Grouped):
        def make(self, i, **options):
            agent = super().make(i, **options)
            agent.__class__ = Lazy
            return agent

    swarm = Lazies(SQUARE, SQUARE_GRAPH, SQUARE_STARTS)
    swarm.press("start")
    swarm.run(0.1)
    assert swarm.together == 0 and swarm.outputs[2].reference is None


def test_others_take_part():
    swarm = Swarm(SQUARE, SQUARE_GRAPH, SQUARE_STARTS)
    alone = SimpleGuidance(init_pos=(0.0, 0.0), agent_id=9)
    alone.takeoff(0.0)
    swarm.press("start")
    swarm.measure()
    outputs = GuidanceGroup([*swarm.agents, alone]).step(0.0)
    assert outputs[2].reference is not None and outputs[4].trajectory is not None
    with pytest.raises(RangeError, match="each once"):
        GuidanceGroup([alone, alone])


@pytest.mark.parametrize("gains", ["webots", "vicon", "mujoco"])
def test_climbs_and_descents_need_no_message_and_change_no_bit(gains):
    swarms = [
        kind(SQUARE, SQUARE_GRAPH, SQUARE_STARTS * (1, 1, 0.015), noise=(0.002, 0.02), gains=gains, takeoff_time=2.0)
        for kind in (Alone, Silent)
    ]
    for swarm in swarms:
        swarm.measure()
        swarm.press("takeoff")
        swarm.run(3.0)
    alone, silent = swarms
    np.testing.assert_array_equal(silent.position, alone.position)
    assert alone.agents[2].communicator.statistics.rounds > 100 > 1 > silent.agents[2].communicator.statistics.rounds
    for swarm in swarms:
        for _again in range(2):
            swarm.press("start")
            swarm.run(0.5)
            swarm.press("land")
            swarm.run(4.0)
            swarm.press("takeoff")
            swarm.run(1.0)
        swarm.press("land")
        swarm.run(8.0)
    # formations differ by rounding
    np.testing.assert_allclose(silent.position, alone.position, atol=1e-9)
    assert [a.phase for a in alone.agents] == [a.phase for a in silent.agents]
    assert [a.phase for a in silent.agents] == [Phase.IDLE] * 4
    assert silent.events == alone.events == []


@pytest.mark.parametrize("victim", [None, 1, 3])
def test_silence_changes_no_number(victim):
    swarms = [
        kind(SQUARE, SQUARE_GRAPH, SQUARE_STARTS, noise=(0.002, 0.02), gains="mujoco", takeoff_time=1.0)
        for kind in (Grouped, Silent)
    ]
    for swarm in swarms:
        swarm.measure()
        swarm.press("start")
        swarm.run(2.0)
        if victim is not None:
            swarm.kill(victim)
            killed = swarm.now
            swarm.run(0.98)
            assert {event[:3] for event in swarm.events} == {
                ("lost", agent, victim) for agent in SQUARE_GRAPH.in_neighbors(victim)
            }
            assert all(event[3] - killed < 1.0 for event in swarm.events)
    if victim is None:
        assert swarms[0].agents[2].communicator.statistics.rounds == 100
        assert swarms[1].agents[2].communicator.statistics.rounds == 1
        np.testing.assert_array_equal(swarms[0].position, swarms[1].position)
        for swarm in swarms:
            swarm.press("land")
            swarm.run(1.0)
        np.testing.assert_array_equal(swarms[0].position, swarms[1].position)
        assert swarms[1].events == []
