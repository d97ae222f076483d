import threading
import time

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.guidance import InProcessTransport, StaticCommunicator
from crazychoir_fw.guidance.optimization import Agent, Consensus, GradientTracking, graphs


def communicator(agent=1, size=3, neighbors=(0, 2), **options):
    return StaticCommunicator(agent, size, neighbors, transport=InProcessTransport(), clock=time.monotonic, **options)


def test_own_weight_is_what_the_others_leave():
    agent = Agent([0, 2], [0, 2], communicator(), in_weights=[0.2, 0.0, 0.3])
    assert agent.id == 1
    assert agent.in_weights == pytest.approx({0: 0.2, 2: 0.3, 1: 0.5})


def test_weights_by_neighbor_with_the_own_one():
    agent = Agent([0, 2], [0, 2], communicator(), in_weights={0: 0.2, 2: 0.3, 1: 0.4}, auto_local=False)
    assert agent.in_weights[1] == 0.4


def test_without_weights_neighbors_have_equal_shares():
    assert Agent(communicator=communicator()).in_weights == {0: 0.5, 2: 0.5, 1: 0.0}


@pytest.mark.parametrize(
    ("weights", "says"),
    [
        ([0.8, 0.0, 0.3], "its own weight is -0.1"),
        ([-0.1, 0.0, 0.3], "the weight of agent 0 is -0.1"),
        ({0: 0.1}, "no weight for agent 2"),
        ([0.1, float("nan"), float("nan")], "the weight of agent 2 is nan"),
    ],
)
def test_weights_outside_their_range_are_named(weights, says):
    with pytest.raises(RangeError, match=says):
        Agent([0, 2], [0, 2], communicator(), in_weights=weights)


def test_agent_needs_a_communicator():
    with pytest.raises(RangeError, match="no communicator"):
        Agent([0], [0])


def test_an_agent_is_not_its_own_neighbor():
    with pytest.raises(RangeError, match="hold itself"):
        Agent([1], [0], communicator())


def test_algorithm_without_a_problem_says_so():
    with pytest.raises(StateError, match="agent 1: GradientTracking needs its part of the problem"):
        GradientTracking(Agent(communicator=communicator()), np.zeros(2))


def test_threads_run_and_log_every_round(team):
    agents = team(graphs.ring_graph(4), serialize=True)
    algorithms = [Consensus(agent, [float(agent.id), 1.0], enable_log=True) for agent in agents]
    logs = {}
    threads = [
        threading.Thread(target=lambda one=one: logs.setdefault(one.agent.id, one.run(iterations=40, timeout=20.0)))
        for one in algorithms
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [len(log) for log in logs.values()] == [40] * 4
    for one in algorithms:
        np.testing.assert_allclose(one.get_result(), [1.5, 1.0], atol=1e-6)


def test_a_round_that_is_not_complete_can_be_ended(team):
    agents = team(graphs.path_graph(3))
    algorithms = [Consensus(agent, float(agent.id)) for agent in agents]
    for one in algorithms[:2]:
        one.begin_round()
    assert algorithms[0].is_complete()
    assert not algorithms[1].is_complete()
    algorithms[1].finish_round()
    # the message of 0 arrived; that of 2 did not, and its weight went to the own value
    assert algorithms[1].get_result() == pytest.approx(1 / 3 * 0 + 2 / 3 * 1)


def test_event_ends_a_run(team, capsys):
    (first, _) = team(graphs.path_graph(2))
    event = threading.Event()
    event.set()
    algorithm = Consensus(first, 1.0)
    algorithm.run(iterations=5, event=event)
    assert algorithm.rounds == 0
    algorithm.run(iterations=1, verbose=True, timeout=0.01)
    assert capsys.readouterr().out == "agent 0: round 1\n"


def test_exchange_as_in_disropt(team):
    first, second = team(graphs.path_graph(2))
    second.neighbors_send({"x": 2})
    assert first.neighbors_exchange({"x": 1}) == {1: {"x": 2}}
