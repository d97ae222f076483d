"""Rounds in lock step, the latest message of each neighbor, and neighbors that are gone."""

import math
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import MessageError, RangeError, StateError
from crazychoir_fw.guidance import (
    BestEffortCommunicator,
    Graph,
    InProcessTransport,
    StaticCommunicator,
    TimeVaryingCommunicator,
)
from crazychoir_fw.guidance.communicator import TOPIC
from crazychoir_fw.guidance.serialization import dumps


class Clock:
    """A clock that advances by a tick at each reading, so that no test waits for real seconds."""

    def __init__(self, tick=0.0):
        self.time, self.tick = 0.0, tick

    def __call__(self):
        self.time += self.tick
        return self.time


def of_graph(graph, kind=TimeVaryingCommunicator, transport=None, **options):
    transport = InProcessTransport() if transport is None else transport
    options.setdefault("clock", time.monotonic)
    return [
        kind(i, graph.size, graph.in_neighbors(i), graph.out_neighbors(i), transport=transport, **options)
        for i in range(graph.size)
    ]


@pytest.fixture(params=[False, True], ids=["objects", "bytes"])
def transport(request):
    return InProcessTransport(serialize=request.param)


def test_everybody_hears_the_neighbors_of_the_same_round(transport):
    graph = Graph.ring(5)
    agents = of_graph(graph, transport=transport)
    for label in range(20):
        for agent in agents:
            agent.neighbors_send([agent.rank, label])
        for agent in agents:
            assert agent.has_round()
            assert agent.collect() == {j: [j, label] for j in graph.in_neighbors(agent.rank)}
            assert agent.current_label == label + 1


@given(st.lists(st.integers(0, 2), min_size=1, max_size=80))
def test_nobody_is_more_than_a_round_ahead_and_none_is_skipped(turns):
    agents = of_graph(Graph.complete(3))
    sent = [-1, -1, -1]
    for turn in turns:
        agent = agents[turn]
        if sent[turn] < agent.current_label:
            agent.neighbors_send(("round", agent.current_label))
            sent[turn] = agent.current_label
        if agent.has_round():
            label = agent.current_label
            assert agent.collect() == {j: ("round", label) for j in agent.in_neighbors}
        labels = [one.current_label for one in agents]
        assert max(labels) - min(labels) <= 1
    assert all(one.statistics.lost == one.statistics.late == 0 for one in agents)


def test_an_early_message_waits_and_a_late_one_takes_no_turn():
    transport = InProcessTransport()
    agent = TimeVaryingCommunicator(0, 2, [1], transport=transport, clock=Clock(0.1), deadline=0.5)
    topic = TOPIC.format(agent=1)
    transport.publish(topic, 2, "two")
    transport.publish(topic, 0, "zero")
    assert agent.collect([1]) == {1: "zero"}
    transport.publish(topic, 0, "zero again")
    assert not agent.has_round([1])
    transport.publish(topic, 1, "one")
    assert agent.neighbors_receive() == {1: "one"}
    assert agent.neighbors_receive() == {1: "two"}
    assert (agent.statistics.late, agent.statistics.lost, agent.statistics.received) == (1, 0, 4)


def test_a_dead_neighbor_holds_nobody_up_longer_than_the_deadline():
    clock = Clock(0.1)
    agents = of_graph(Graph.complete(3), clock=clock, deadline=1.0)
    for agent in agents[:2]:
        agent.neighbors_send(agent.rank)
    begin = clock.time
    assert agents[0].neighbors_receive() == {1: 1}
    assert clock.time - begin == pytest.approx(1.1, abs=0.11)
    assert agents[1].neighbors_receive(timeout=0.3) == {0: 0}
    assert agents[0].statistics.lost == agents[1].statistics.lost == 1


def test_a_stop_event_ends_the_wait():
    stop = threading.Event()
    agent = of_graph(Graph.complete(2))[0]
    threading.Timer(0.02, stop.set).start()
    assert agent.neighbors_receive(stop_event=stop, timeout=math.inf) == {}


def test_agents_in_threads_stay_in_step():
    graph = Graph.ring(6)
    agents = of_graph(graph, deadline=60.0)
    sums = [0.0] * 6

    def consensus(agent):
        value = float(agent.rank)
        for _ in range(200):
            heard = agent.neighbors_exchange(value)
            assert sorted(heard) == list(agent.in_neighbors)
            value = (value + sum(heard.values())) / 3.0
        sums[agent.rank] = value

    threads = [threading.Thread(target=consensus, args=(agent,)) for agent in agents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert sums == pytest.approx([2.5] * 6, abs=1e-9)
    assert all(agent.statistics.rounds == 200 and agent.statistics.lost == 0 for agent in agents)


def test_a_late_joiner_takes_over_the_round_of_the_others():
    transport, clock = InProcessTransport(), Clock(0.1)
    first = TimeVaryingCommunicator(0, 2, [1], transport=transport, clock=clock, deadline=0.3)
    for _ in range(5):
        first.neighbors_exchange("alone")
    late = TimeVaryingCommunicator(1, 2, [0], transport=transport, clock=clock, deadline=0.3)
    first.neighbors_send("here")
    assert late.neighbors_exchange("new") == {0: "here"}
    assert late.current_label == first.current_label + 1 == 6
    assert first.neighbors_receive() == {1: "new"}
    # from now on nothing is lost
    lost = first.statistics.lost
    for label in range(6, 9):
        first.neighbors_send(label)
        assert late.neighbors_exchange(label) == {0: label}
        assert first.neighbors_receive() == {1: label}
    assert first.statistics.lost == lost


def test_who_was_away_catches_up_after_the_round_it_missed():
    transport, clock = InProcessTransport(), Clock(0.1)
    here, away = (
        TimeVaryingCommunicator(i, 2, [1 - i], transport=transport, clock=clock, deadline=0.3) for i in range(2)
    )
    here.neighbors_send(0)
    away.neighbors_send(0)
    here.collect(), away.collect()
    for label in range(1, 8):
        here.neighbors_exchange(label)
    away.neighbors_exchange("old")  # label 1: too late for the other
    here.neighbors_send("now")
    away.neighbors_exchange("late once more")
    away.catch_up()
    here.collect()
    for _ in range(3):
        here.neighbors_send("here")
        away.catch_up()
        away.neighbors_send("away")
        assert here.collect() == {1: "away"}
        assert away.collect() == {0: "here"}


def test_differentiated_topics_give_each_neighbor_its_own(transport):
    agents = of_graph(Graph.complete(3), transport=transport, differentiated_topics=True)
    for agent in agents:
        agent.neighbors_send(None)
    for agent in agents:
        agent.collect()
    results = [None] * 3

    def exchange(agent):
        objects = {j: (agent.rank, j) for j in agent.out_neighbors}
        results[agent.rank] = agent.neighbors_exchange(objects, dict_neigh=True, timeout=60.0)

    threads = [threading.Thread(target=exchange, args=(agent,)) for agent in agents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert results == [{j: (j, i) for j in range(3) if j != i} for i in range(3)]


def test_only_named_receivers_hear_on_differentiated_topics():
    agents = of_graph(Graph.complete(3), differentiated_topics=True)
    agents[0].neighbors_send("for one", [1])
    assert agents[1].has_round([0])
    assert not agents[2].has_round([0])


def test_time_varying_neighbors_are_those_of_the_call():
    agents = of_graph(Graph.complete(3))
    for agent in agents:
        agent.neighbors_send(agent.rank)
    assert agents[0].collect([1]) == {1: 1}
    assert agents[0].current_label == 1
    agents[1].collect([]), agents[2].collect([])
    for agent in agents:
        agent.neighbors_send(agent.rank)
    # of both rounds, what came from the neighbor that was not asked is gone
    assert agents[0].collect([2]) == {2: 2}
    assert agents[0].statistics.late == 2


def test_a_static_communicator_does_not_listen_to_the_call():
    agents = of_graph(Graph.complete(3), StaticCommunicator)
    for agent in agents:
        agent.neighbors_send(agent.rank, [])
    assert agents[0].neighbors_receive([1]) == {1: 1, 2: 2}


def test_asynchronous_gives_the_latest_of_each_once(transport):
    first, second = of_graph(Graph.complete(2), transport=transport, synchronous_mode=False)
    for value in range(3):
        second.neighbors_send(value)
    assert first.neighbors_receive_asynchronous() == {1: 2}
    assert first.neighbors_receive_asynchronous() == {}
    second.neighbors_send(None)
    assert first.neighbors_receive_asynchronous([1]) == {1: None}


def test_modes_are_kept_apart():
    lockstep, asynchronous = (of_graph(Graph.complete(2), synchronous_mode=mode)[0] for mode in (True, False))
    with pytest.raises(StateError, match="synchronous_mode=False"):
        lockstep.neighbors_receive_asynchronous()
    with pytest.raises(StateError, match="synchronous_mode=True"):
        asynchronous.neighbors_receive()
    with pytest.raises(StateError, match="differentiated"):
        lockstep.neighbors_exchange({1: 0}, dict_neigh=True)


def test_best_effort_goes_on_where_messages_get_lost():
    transport = InProcessTransport(loss=0.2, seed=3)
    first, second = of_graph(Graph.complete(2), BestEffortCommunicator, transport)
    heard = 0
    for value in range(500):
        second.neighbors_send(value)
        heard += first.neighbors_receive_asynchronous() == {1: value}
    assert 360 < heard < 440 and first.statistics.received == heard


def test_same_seed_loses_the_same_messages():
    def heard(seed):
        transport = InProcessTransport(loss=0.5, seed=seed)
        first, second = of_graph(Graph.complete(2), BestEffortCommunicator, transport)
        result = []
        for value in range(50):
            second.neighbors_send(value)
            result.append(bool(first.neighbors_receive_asynchronous()))
        return result

    assert heard(1) == heard(1) != heard(2)


@pytest.mark.parametrize(
    ("label", "data"), [(0, b"\xff\xff"), (0, b""), (-1, dumps(1)), (1 << 60, dumps(1)), (0, dumps(bytes(300)))]
)
def test_what_is_no_message_changes_nothing(label, data):
    transport = InProcessTransport(serialize=True)
    agent = TimeVaryingCommunicator(0, 2, [1], transport=transport, largest_bytes=100)
    transport.publish(TOPIC.format(agent=1), label, data)
    assert not agent.has_round() and not agent.catch_up() and agent.heard(1) == 0
    assert agent.statistics.refused == 1


def test_a_neighbor_that_runs_ahead_cannot_fill_the_memory():
    transport = InProcessTransport()
    agent = TimeVaryingCommunicator(0, 2, [1], transport=transport)
    for label in range(10_500):
        transport.publish(TOPIC.format(agent=1), label, None)
    assert agent.statistics.refused == 500
    assert agent.collect() == {1: None}


def test_bytes_are_counted():
    transport = InProcessTransport(serialize=True)
    first, second = of_graph(Graph.complete(2), transport=transport)
    first.neighbors_send(np.zeros(3))
    size = len(dumps(np.zeros(3)))
    assert first.statistics.bytes_sent == second.statistics.bytes_received == size


def test_what_may_not_be_sent_is_refused(transport):
    with pytest.raises(MessageError):
        of_graph(Graph.complete(2), transport=transport)[0].neighbors_send(object())


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda t: TimeVaryingCommunicator(3, 3, [], transport=t), r"agent_id is 3, allowed: \[0, 2\]"),
        (lambda t: TimeVaryingCommunicator(0, 3, [0], transport=t), "in_neighbors holds 0"),
        (lambda t: TimeVaryingCommunicator(0, 3, [1], [3], transport=t), "out_neighbors holds 3"),
        (lambda t: TimeVaryingCommunicator(0, 0, [], transport=t), "size is 0"),
        (lambda t: TimeVaryingCommunicator(0, 2, [1], transport=t, deadline=0.0), "deadline is 0"),
        (lambda t: TimeVaryingCommunicator(0, 3, [1], transport=t).neighbors_receive([2]), "none of its in-neighbors"),
        (lambda t: TimeVaryingCommunicator(0, 3, [1], transport=t).neighbors_send(1, [2]), "none of its out-neighbors"),
        (lambda t: InProcessTransport(loss=1.5), "loss is 1.5"),
    ],
)
def test_bad_arguments_are_named(call, words):
    with pytest.raises(RangeError, match=words):
        call(InProcessTransport())


def test_a_closed_communicator_hears_nobody():
    first, second = of_graph(Graph.complete(2))
    first.close()
    second.neighbors_send(1)
    assert not first.has_round()
