"""Dynamic task assignment of plain guidance: optimal, and continuing after the loss of any agent."""

import numpy as np
import pytest
from task_swarm import STARTS, TaskSwarm

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.guidance.schemes import PositionTaskTable, TaskGuidance
from crazychoir_fw.guidance.schemes.tasks.judging import agreements, completed

COMPLETE = Graph.undirected(6, [(i, j) for i in range(6) for j in range(i)], [str(i) for i in range(6)])


def swarm(graph=None, synchronous=True, guidance=None, **options):
    table = PositionTaskTable(6, **options)

    def make(i, communicator, start):
        return TaskGuidance(i, communicator, init_pos=start, update_frequency=50.0, **(guidance or {}))

    return TaskSwarm(table, make, graph=graph, synchronous=synchronous)


def takes(flown, label=1):
    decided = [event for event in flown.kinds("assigned") if event["details"]["label"] == label]
    return {event["drone"]: event["details"]["takes"] for event in decided}


def test_first_assignment_is_that_of_the_original():
    flown = swarm()
    flown.start()
    flown.run(2.0, until=lambda: bool(flown.kinds("agreed")))
    # numbers of the first tasks are their sequence numbers
    assert takes(flown) == {0: [2], 1: [1], 2: [5], 3: [3], 4: [4], 5: [0]}
    (agreed,) = agreements(flown.events)
    assert agreed.cost == pytest.approx(12.048675919, abs=1e-9)
    assert agreed.best_cost == pytest.approx(12.048675919, abs=1e-9)


def test_all_tasks_are_done_and_every_assignment_is_optimal():
    flown = swarm()
    flown.start()
    flown.run(30.0, until=lambda: flown.table.is_done)
    assert completed(flown.events) == flown.table.finished == 13
    agreed = agreements(flown.events)
    assert len(agreed) >= 5
    assert all(one.is_optimal for one in agreed)
    # a drone without a task hovers
    at = flown.positions.copy()
    flown.run(2.0)
    np.testing.assert_allclose(flown.positions, at, atol=0.1)
    assert not any(guidance.task for guidance in flown.guidance)


def test_a_drone_flies_at_its_own_height_to_its_task():
    flown = swarm()
    flown.start()
    flown.run(1.5)
    np.testing.assert_allclose(flown.goals[:, 2], 0.5 + 0.15 * np.arange(6))
    np.testing.assert_allclose(flown.goals[5, :2], flown.guidance[5].task.position)


@pytest.mark.parametrize("probability", [0.2])
@pytest.mark.parametrize("seed", [1, 2])
def test_draws_that_cannot_all_be_assigned_are_done_one_after_the_other(seed, probability):
    flown = swarm(seed=seed, probability=probability)
    flown.start()
    flown.run(60.0, until=lambda: flown.table.is_done)
    assert flown.table.finished == 13
    assert any(event["details"]["left"] for event in flown.kinds("agreed"))
    assert all(one.is_optimal for one in agreements(flown.events))


def test_asynchronous_rounds_do_as_well():
    flown = swarm(synchronous=False)
    flown.start()
    flown.run(30.0, until=lambda: flown.table.is_done)
    assert flown.table.finished == 13
    assert all(one.is_optimal for one in agreements(flown.events))


@pytest.mark.parametrize("victim", [0, 1, 5])
def test_survivors_do_the_tasks_of_one_that_dies(victim):
    flown = swarm(COMPLETE, patience=5.0)
    flown.start()
    flown.run(1.2)
    flown.dead.add(victim)
    flown.run(60.0, until=lambda: flown.table.is_done)
    assert flown.table.is_done
    assert flown.table.gone == {victim}
    assert flown.table.finished >= 13 - 1
    later = [event for event in flown.kinds("completed") if event["time"] > 1.3]
    assert victim not in {event["drone"] for event in later}
    # two rounds of a deadline for the silent one, then none
    assert all(guidance.lost <= {victim} for i, guidance in enumerate(flown.guidance) if i != victim)


def test_one_that_comes_back_takes_part_again():
    flown = swarm(COMPLETE, patience=5.0, generations=40)
    flown.start()
    flown.run(1.2)
    flown.dead.add(2)
    flown.run(8.0)
    assert flown.table.gone == {2}
    flown.dead.clear()
    flown.guidance[2].start(flown.now)
    flown.run(10.0)
    assert flown.table.gone == set()
    assert 2 in {event["drone"] for event in flown.kinds("completed") if event["time"] > 9.2}


def test_one_that_cannot_move_leaves_its_task_to_others():
    flown = swarm(COMPLETE, patience=5.0, guidance={"speed": 2.0})
    flown.start()
    stuck = 3
    for _ in range(round(90.0 / 0.02)):
        place = flown.positions[stuck].copy()
        flown.step()
        flown.positions[stuck] = place
        if flown.table.is_done:
            break
    assert flown.table.is_done
    assert "did not reach task" in flown.guidance[stuck].unable
    assert stuck in flown.table.gone


def test_who_is_not_started_passes_on_what_others_say():
    # 5 is in the middle of the graph: 1 - 4 - 5 - 3 - 0 and 2 - 5
    flown = swarm()
    flown.start(0, 1, 2, 3, 4)
    flown.run(60.0, until=lambda: flown.table.is_done)
    assert flown.table.is_done
    assert 5 not in {event["drone"] for event in flown.kinds("completed", "assigned")}
    assert all(one.is_optimal for one in agreements(flown.events))


def test_landing_and_stop_drop_the_task():
    flown = swarm()
    flown.start()
    flown.run(1.5)
    flown.guidance[0].land(flown.now)
    flown.guidance[1].stop(flown.now)
    assert flown.guidance[0].task is None
    assert flown.guidance[1].task is None
    before = flown.goals[0].copy()
    flown.run(5.0)
    assert 0 not in {event["drone"] for event in flown.kinds("completed") if event["time"] > 1.6}
    assert not np.array_equal(flown.goals[0], before)


def test_messages_that_are_none_do_not_spoil_an_optimization():
    flown = swarm()
    flown.start()
    flown.run(0.54)
    wrong = flown.guidance[5]
    assert wrong.is_optimizing
    wrong._simplex._message = lambda: {"label": 1, "basis": "nothing"}
    flown.run(1.0)
    decided = [event["drone"] for event in flown.kinds("assigned")]
    assert sorted(decided)[:6] == list(range(6))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"max_iterations": 0}, "max_iterations is 0"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
        ({"speed": -1.0}, "speed is -1.0"),
        ({"duration": 0.0}, "duration is 0.0"),
        ({"height_step": -0.1}, "height_step is -0.1"),
        ({"deadline": np.inf}, "deadline is inf"),
    ],
)
def test_what_makes_no_guidance(options, said):
    communicator = TimeVaryingCommunicator(0, 6, [1], transport=InProcessTransport())
    with pytest.raises(RangeError, match=said):
        TaskGuidance(0, communicator, init_pos=STARTS[0], **options)
    with pytest.raises(RangeError, match="the communicator is that of agent 0"):
        TaskGuidance(1, communicator)


def test_who_lands_while_an_optimization_runs_goes_nowhere_afterwards():
    flown = swarm()
    flown.start()
    flown.run(2.0, until=lambda: flown.guidance[0].is_optimizing)
    flown.guidance[0].land(flown.now)
    flown.run(0.1)
    goal = flown.goals[0].copy()
    flown.run(3.0, until=lambda: not flown.guidance[0].is_optimizing)
    flown.run(0.1)
    np.testing.assert_array_equal(flown.goals[0], goal)
