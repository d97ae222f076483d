"""The table of tasks: what it draws, and what it does about agents that are gone."""

import json

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.schemes import DeliveryTable, PositionTaskTable
from crazychoir_fw.guidance.schemes.delivery import DeliveryRequest
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import LABELS_SKIPPED

FIRST = [  # docs/reference/crazychoir.md#23
    (2.802179, 0.283393, {3, 5}),
    (-1.482106, -0.391251, {1, 4}),
    (-2.946083, -0.680572, {0, 2}),
    (-1.961007, -2.550308, {1, 3}),
    (0.130177, -2.35084, {0, 4}),
    (-0.6186, 0.743497, {1, 2, 5}),
]


def started(**options):
    table = PositionTaskTable(**{"N": 6, "start_delay": 0.0, **options})
    table.events = []
    table.note = lambda kind, agent, details: table.events.append((kind, agent, details))
    table.start(0.0)
    table.step(0.0)
    return table


def asked(table, *agents):
    lists = {}
    for agent in agents:
        table.request(agent, lambda offer, agent=agent: lists.__setitem__(agent, offer))
    return lists


def test_first_generation_is_that_of_the_original():
    table = started()
    for number, (x, y, agents) in enumerate(FIRST):
        task = table.tasks[number]
        assert task.position == pytest.approx((x, y), abs=1e-6)
        assert set(task.agents) == agents
        assert task.sequence == number
    lists = asked(table, *range(6))
    assert [len(lists[i].items) for i in range(6)] == [2, 3, 2, 2, 2, 2]
    assert {offer.label for offer in lists.values()} == {1}


def test_numbers_are_taken_over_and_sequence_numbers_are_not():
    table = started()
    labels = []
    table.listen(labels.append)
    assert table.complete(3, 3)
    assert (table.tasks[3].number, table.tasks[3].sequence) == (3, 6)
    assert table.complete(5, 0)
    assert table.tasks[0].sequence == 7
    assert labels == [2, 3]
    assert table.finished == 2
    assert sorted(table.tasks) == list(range(6))


def test_tasks_are_drawn_eight_times():
    table = started()
    while table.tasks:
        task = next(iter(table.tasks.values()))
        assert table.complete(task.agents[0], task.sequence)
    assert table.finished == 6 + 7
    assert table.is_done


def test_a_task_is_completed_once_by_who_can_do_it():
    table = started()
    assert not table.complete(0, 0)
    assert table.complete(3, 0)
    assert not table.complete(5, 0)
    assert [kind for kind, _, _ in table.events] == ["tasks", "refused", "completed", "tasks", "refused"]


def test_a_task_that_nobody_can_do_is_drawn_again():
    table = started(N=2, probability=0.1, seed=1)
    assert all(task.agents for task in table.tasks.values())
    assert "redrawn" in [kind for kind, _, _ in table.events]


def test_what_only_a_silent_agent_can_do_is_taken_back():
    table = started()
    asked(table, 0, 1, 2, 3, 4)
    table.step(0.9)
    assert not table.gone
    table.step(1.0)
    assert table.gone == {5}
    assert table.label == 1  # others can do all of it
    asked(table, 0, 2, 3, 4, 5)
    table.complete(3, 0)
    asked(table, 0, 2, 5)
    table.step(2.0)
    assert table.gone == {1, 3, 4}
    # tasks 1 of agents 1 and 4, 3 of 1 and 3, and what was drawn for 0, if so
    assert {"returned", "gone"} <= {kind for kind, _, _ in table.events}
    assert table.label > 2
    assert all(set(task.agents) & {0, 2, 5} for task in table.tasks.values())
    before = table.label
    lists = asked(table, 1)
    assert 1 not in table.gone
    assert lists[1].label == table.label == before + 1


def test_a_list_that_nothing_comes_of_is_announced_again():
    table = started(patience=5.0)
    labels = []
    table.listen(labels.append)
    asked(table, *range(6))
    for now in np.arange(0.1, 4.9, 0.1):
        table.step(now)
    assert labels == []
    table.step(5.0)
    assert labels == [2]


def test_nothing_is_offered_before_the_start():
    table = PositionTaskTable(6)
    table.step(5.0)
    assert asked(table, 0) == {}
    table.start(6.0)
    table.start(60.0)  # the first one counts
    table.step(6.4)
    assert not table.tasks
    table.step(6.5)
    assert len(table.tasks) == 6


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"N": 0}, "agents is 0"),
        ({"probability": 0.0}, "probability is 0.0"),
        ({"generations": 0}, "generations is 0"),
        ({"low": (3.0, 0.0), "high": (0.0, 1.0)}, "low is"),
        ({"low": (0.0,)}, "bounds are"),
        ({"deadline": 0.0}, "deadline is 0.0"),
        ({"patience": np.nan}, "patience is nan"),
        ({"start_delay": -1.0}, "start_delay is -1.0"),
    ],
)
def test_what_makes_no_table(options, said):
    with pytest.raises(RangeError, match=said):
        PositionTaskTable(**{"N": 6, **options})


def test_agents_that_do_not_exist_are_refused():
    table = started()
    for call in (
        lambda: table.request(6, print),
        lambda: table.complete(-1, 0),
        lambda: table.report(9, {"label": 1, "takes": []}),
    ):
        with pytest.raises(RangeError, match="allowed: \\[0, 5\\]"):
            call()


def test_a_table_that_remembers_goes_on_as_the_one_before():
    one, other = started(generations=4), PositionTaskTable(6, start_delay=0.0, generations=4)
    one.complete(3, 3)
    one.gone = {2}
    labels = []
    other.listen(labels.append)
    other.remember(json.loads(json.dumps(one.memory())), 30.0)
    assert labels == [other.label] == [one.label + LABELS_SKIPPED + 1]
    for table in (one, other):
        table.complete(5, 0)
    assert other.tasks == one.tasks
    assert (other.finished, other.gone, other.generations_left) == (2, {2}, 1)
    # deadline and patience count from now on
    asked(other, 0, 1, 3, 4, 5)
    label = other.label
    other.step(30.5)
    assert other.label == label


def test_a_delivery_table_remembers_who_carries_what():
    requests = [DeliveryRequest(k, (k, 0.0), (k, 1.0), at=5.0 * k) for k in range(3)]
    one = DeliveryTable(2, requests, start_delay=0.0)
    one.start(0.0)
    for now in (0.0, 5.0):
        one.step(now)
    one.complete(1, 0)  # the pickup of request 0
    other = DeliveryTable(2, requests, start_delay=0.0)
    other.remember(json.loads(json.dumps(one.memory())), 6.0)
    assert other.requests == one.requests
    assert other.requests[0].carrier == 1
    assert other.complete(1, 1)
    other.step(10.0)
    assert set(other.requests) == {1, 2}
    assert not other.is_done


@pytest.mark.parametrize(
    "change",
    [
        {"label": 0},
        {"finished": -1},
        {"gone": [9]},
        {"tasks": [[0, 0, ["a", 0.0], [1]]]},
        {"tasks": [[9, 0, [0.0, 0.0], [1]]]},
        {"tasks": 3},
        {"draws": 10**12},
        {"generations_left": None},
    ],
)
def test_memories_of_others_are_refused(change):
    memory = {**started().memory(), **change}
    table = PositionTaskTable(6)
    with pytest.raises(RangeError, match="memory"):
        table.remember(memory, 0.0)
    assert table.label == 0


def test_only_a_new_table_remembers():
    table = started()
    with pytest.raises(RangeError, match="has begun"):
        table.remember(table.memory(), 0.0)
