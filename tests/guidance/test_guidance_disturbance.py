"""Messages that get lost, late or doubled on purpose, and graphs that change under a communicator."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.guidance import (
    DisturbedTransport,
    Graph,
    InProcessTransport,
    SeveralSchedules,
    TimedGraphs,
    TimeVaryingCommunicator,
    WithinDistance,
)


class Clock:
    time = 0.0

    def __call__(self):
        return self.time


def pair(clock=None, schedule=None, synchronous_mode=True, **disturbance):
    """Return two agents, of which agent 0 hears agent 1 badly."""
    air, clock = InProcessTransport(), clock or Clock()
    bad = DisturbedTransport(air, clock=clock, **disturbance)
    return [
        TimeVaryingCommunicator(
            i, 2, [1 - i], None, synchronous_mode, transport=bad if i == 0 else air, clock=clock, schedule=schedule
        )
        for i in range(2)
    ]


def heard_of(rounds, **disturbance):
    agents = pair(**disturbance)
    heard = []
    for k in range(rounds):
        agents[1].neighbors_send(k)
        heard.append(agents[0].has_round())
        for agent in agents:
            agent.collect()
    return heard, agents[0].statistics


def test_so_many_get_lost_and_the_same_by_the_same_seed():
    heard, seen = heard_of(2000, loss=0.2, seed=3)
    assert np.mean(heard) == pytest.approx(0.8, abs=0.03)
    assert seen.lost == heard.count(False) and seen.received == heard.count(True)
    assert heard == heard_of(2000, loss=0.2, seed=3)[0] != heard_of(2000, loss=0.2, seed=4)[0]


def test_messages_that_come_twice_change_no_round():
    heard, seen = heard_of(500, duplication=1.0)
    assert all(heard) and seen.received == 1000 and seen.lost == 0


def test_a_late_message_ends_the_round_when_it_comes():
    clock = Clock()
    agents = pair(clock, delay=0.02, jitter=0.01, seed=1)
    agents[1].neighbors_send("late")
    clock.time = 0.019
    assert not agents[0].has_round()
    clock.time = 0.031
    assert agents[0].has_round() and agents[0].collect() == {1: "late"}
    agents[1].collect()
    agents[1].neighbors_send("later")
    agents[0].close()
    clock.time = 1.0
    assert not agents[0].has_round()


@pytest.mark.parametrize("wrong", [{"loss": 1.5}, {"duplication": -0.1}, {"delay": np.inf}, {"jitter": -1.0}])
def test_numbers_outside_their_range_are_refused(wrong):
    with pytest.raises(RangeError, match=f"{next(iter(wrong))} is"):
        DisturbedTransport(InProcessTransport(), clock=Clock(), **wrong)


def test_nobody_waits_over_an_edge_that_is_not_there():
    clock = Clock()
    schedule = TimedGraphs([(0.0, Graph.complete(2)), (1.0, Graph.directed(2, []))])
    agents = pair(clock, schedule)
    agents[1].neighbors_send("first")
    assert agents[0].has_round() and agents[0].collect() == {1: "first"}
    agents[1].collect()
    clock.time = 1.0
    agents[1].neighbors_send("second")
    assert agents[0].has_round() and agents[0].collect() == {}
    assert agents[0].statistics.cut == 1 and agents[0].statistics.lost == 0
    assert not agents[0].is_lossless


def test_a_clock_is_needed_only_to_wait():
    agent = TimeVaryingCommunicator(0, 2, [1], transport=InProcessTransport())
    with pytest.raises(StateError, match="to wait it needs a clock"):
        agent.neighbors_receive()
    with pytest.raises(RangeError, match="there is no clock"):
        TimeVaryingCommunicator(0, 2, [1], transport=InProcessTransport(), schedule=Graph.complete(2))


def test_several_schedules_are_one():
    together = SeveralSchedules([([0, 1], Graph.complete(2)), ([3, 1], Graph.directed(2, [(0, 1)]))])
    assert together.neighbors_at(1, 0.0, 0) == ((0, 3), (0,))
    assert together.neighbors_at(3, 0.0, 0) == ((), (1,))
    assert together.neighbors_at(2, 0.0, 0) == ((), ())


def test_who_is_nowhere_is_near_nobody():
    at = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [np.nan] * 3])
    near = WithinDistance(Graph.complete(3), 1.5, lambda: at)
    assert [near.neighbors_at(i, 0.0, 0)[0] for i in range(3)] == [(1,), (0,), ()]
    at[1, 0] = 2.0
    assert near.neighbors_at(0, 0.0, 0)[0] == ()
