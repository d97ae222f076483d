"""Surveillance of a target: pace, references, the loss of an agent (docs/reference/crazychoir.md#23)."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight import Experiment, IntegratorBackend
from crazychoir_fw.flight.agent import Agent
from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.guidance.law import LawContext
from crazychoir_fw.guidance.optimization import AggregativeTracking, SurveillanceProblem
from crazychoir_fw.guidance.schemes import (
    AggregativeGuidance,
    AggregativeGuidanceCrazyflie,
    AggregativeGuidanceCrazyflieMovingIntruder,
)
from crazychoir_fw.guidance.schemes.surveillance import SurveillanceMetrics
from crazychoir_fw.planning import SplinePosition

INTRUDERS = np.array([(-1.0, 1.0), (-1.0, -1.0), (1.0, 0.0)])
STARTS = np.array([(-0.5, -0.5, 0.0), (0.0, -0.5, 0.0), (0.5, -0.5, 0.0)])
LIMITS = np.array([(-0.5, 0.5), (-0.5, -0.5), (0.5, 0.0)])
GRAPH = Graph.binomial(3, 0.5, 3)
PERIOD = 0.01


def team(kind=AggregativeGuidanceCrazyflie, graph=GRAPH, lockstep=True, transport=None, **options):
    """Return three defenders of one process."""
    transport = InProcessTransport() if transport is None else transport
    weights = graph.metropolis_hastings()
    found = []
    for i in range(3):
        communicator = TimeVaryingCommunicator(
            i, 3, graph.in_neighbors(i), synchronous_mode=lockstep, transport=transport
        )
        own = {} if kind.intruder_moves else {"intruder": INTRUDERS[i]}
        found.append(
            kind(
                i,
                communicator,
                target=(0.0, 0.0, 1.0),
                weights=weights[i].tolist(),
                init_pos=STARTS[i],
                **own,
                **options,
            )
        )
    return found


def fly(agents, rounds, begin=0, seen=None):
    """Let agents do rounds at 100 Hz, as an experiment does; return what they asked for."""
    asked = []
    for k in range(begin, begin + rounds):
        now = k * PERIOD
        for agent in agents:
            agent.set_pose(Pose(position=STARTS[agent.agent_id], time=now))
            for j in agent.watched if seen is not None else ():
                if (pose := seen(j, now)) is not None:
                    agent.see(j, pose)
            agent.begin_round(now)
        asked.append([a.finish_round(now) if a.round_open and a.is_complete(now) else a.step(now) for a in agents])
    return asked


def decisions(agents):
    return np.array([agent.algorithm.get_result() for agent in agents])


@pytest.mark.parametrize("optimizer", ["AggregativeTracking", "ResilientAggregativeTracking"])
@pytest.mark.parametrize(("stepsize", "expected"), [(1e-3, (573, 1145, 1717)), (5e-3, (112, 224, 335))])
def test_iterations_until_the_error_is_small(optimizer, stepsize, expected):
    agents = team(optimizer=optimizer, stepsize=stepsize, enable_log=True)
    for agent in agents:
        agent.start(0.0)
    fly(agents, expected[-1] + 5)
    results = np.array([agent.results for agent in agents])
    errors = np.abs(results - LIMITS[:, None]).max(axis=(0, 2))
    assert tuple(1 + int(np.argmax(errors < bound)) for bound in (0.1, 0.01, 0.001)) == expected


def test_the_optimum_with_other_weights_is_that_of_the_problems():
    gammas = {"gamma_intruder": 0.7, "gamma_target": 1.4, "gamma_shape": 0.5}
    agents = team(stepsize=0.02, **gammas)
    for agent in agents:
        agent.start(0.0)
    fly(agents, 900)
    np.testing.assert_allclose(decisions(agents), optimum(np.zeros(2), **gammas), atol=1e-4)


def optimum(target, **gammas):
    """Return where three defenders should be (m), shape (3, 2)."""
    options = {i: {"intruder": INTRUDERS[i], "target": target, **gammas} for i in range(3)}
    context = LawContext(AggregativeGuidance, ("a", "b", "c"), (0, 1, 2), GRAPH, options=options)
    return SurveillanceMetrics(context).optimum(np.zeros((3, 3)))


def test_places_are_where_gradients_vanish():
    names = {"gamma_intruder": 0.7, "gamma_target": 1.4, "gamma_shape": 0.5}
    places = optimum((0.2, 0.1), **names)
    problems = [SurveillanceProblem(intruder, (0.2, 0.1), **names) for intruder in INTRUDERS]
    both = [one.gradients(x, places.mean(axis=0)) for one, x in zip(problems, places, strict=True)]
    total = np.array([own for own, _ in both]) + np.mean([mean for _, mean in both], axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-12)


def test_iterations_and_references_are_paced():
    agents = team(iterations_per_second=20.0, freq_reference=10.0, takeoff_time=0.5, enable_log=True)
    for agent in agents:
        agent.takeoff(0.0)
    first = fly(agents, 100)
    assert [len(agent.results) for agent in agents] == [0, 0, 0]
    assert sum(outputs[0].trajectory is not None for outputs in first) == 1  # the climb
    for agent in agents:
        agent.start(1.0)
    asked = fly(agents, 100, begin=100)
    assert [len(agent.results) for agent in agents] == [20, 20, 20]
    sent = [outputs[1].trajectory for outputs in asked if outputs[1].trajectory is not None]
    assert len(sent) == 10
    assert {len(points) for points in sent} == {1}
    np.testing.assert_allclose(sent[0][0].position[2], 1.0)


def test_references_may_go_straight_to_the_controller():
    agents = team(references="position", takeoff_time=0.1)
    for agent in agents:
        agent.takeoff(0.0)
        agent.start(0.0)
    asked = fly(agents, 60)
    sent = [k for k, outputs in enumerate(asked) if outputs[0].reference is not None]
    assert sent[0] >= 9  # not before the climb is over
    np.testing.assert_allclose(np.diff(sent), 10)


def test_the_iteration_ends_by_its_number_and_by_the_landing():
    saved = []

    class Saving(AggregativeGuidance):
        def save_results(self):
            saved.append(len(self.results))

    agents = team(Saving, max_iterations=7, enable_log=True)
    for agent in agents:
        agent.start(0.0)
    fly(agents, 20)
    assert [len(agent.results) for agent in agents] == [7, 7, 7]
    for agent in agents:
        agent.land(0.2)
    asked = fly(agents, 20, begin=20)
    assert saved == [7, 7, 7]
    np.testing.assert_allclose(asked[0][0].trajectory[0].position[2], 0.01)
    assert all(outputs[0].trajectory is None for outputs in asked[1:])


def test_moving_intruders_are_followed():
    agents = team(AggregativeGuidanceCrazyflieMovingIntruder, stepsize=0.02)
    assert [agent.watched for agent in agents] == [(3,), (4,), (5,)]
    for agent in agents:
        agent.start(0.0)

    def seen(j, now):
        return Pose(position=np.append(INTRUDERS[j - 3] + [0.1 * now, 0.0], 1.0), time=now)

    fly(agents, 1000, seen=seen)
    np.testing.assert_allclose(decisions(agents), LIMITS + np.array([0.5, 0.0]), atol=0.03)


@pytest.mark.parametrize("drop_unseen", [False, True])
def test_an_intruder_that_is_not_seen_is_reported_until_it_is_seen_again(drop_unseen):
    agents = team(AggregativeGuidanceCrazyflieMovingIntruder, stepsize=0.02, drop_unseen=drop_unseen)
    for agent in agents:
        agent.start(0.0)

    def seen(j, now):
        gone = j == 3 and 2.0 <= now < 10.0
        return None if gone else Pose(position=np.append(INTRUDERS[j - 3], 1.0), time=now)

    fly(agents, 200, seen=seen)
    assert agents[0].lost == frozenset()
    fly(agents, 700, begin=200, seen=seen)
    assert agents[0].lost == {3}
    assert agents[1].lost == frozenset()
    # without its intruder, a defender is to be at the target
    np.testing.assert_allclose(decisions(agents), [(0.0, 0.0) if drop_unseen else LIMITS[0], *LIMITS[1:]], atol=1e-3)
    fly(agents, 900, begin=900, seen=seen)
    assert agents[0].lost == frozenset()
    np.testing.assert_allclose(decisions(agents), LIMITS, atol=1e-3)


def test_nothing_begins_before_anything_is_known():
    communicator = TimeVaryingCommunicator(0, 2, [1], transport=InProcessTransport())
    agent = AggregativeGuidanceCrazyflieMovingIntruder(0, communicator, init_pos=STARTS[0])
    agent.start(0.0)
    fly([agent], 5)
    assert agent.algorithm is None


@pytest.mark.parametrize("optimizer", ["ResilientAggregativeTracking", "RobustAggregativeTracking"])
@pytest.mark.parametrize("lockstep", [True, False])
def test_who_falls_silent_holds_nobody_up(optimizer, lockstep):
    if optimizer == "ResilientAggregativeTracking" and not lockstep:
        pytest.skip("needs rounds in lock step")
    complete = Graph.complete(3)
    agents = team(graph=complete, optimizer=optimizer, lockstep=lockstep, stepsize=0.02, deadline=0.05, silence=0.3)
    for agent in agents:
        agent.start(0.0)
    fly(agents, 150)
    rest = agents[:2]  # the third does nothing any more
    rounds = rest[0].algorithm.rounds
    fly(rest, 700, begin=150)
    assert rest[0].lost == rest[1].lost == {2}
    assert rest[0].algorithm.rounds - rounds >= 690  # no agent iterated until the deadline
    np.testing.assert_allclose(decisions(rest), LIMITS[:2], atol=1e-3)
    # it comes back, from where it was
    fly(agents, 700, begin=850)
    assert [agent.lost for agent in agents] == [frozenset()] * 3
    np.testing.assert_allclose(decisions(agents), LIMITS, atol=1e-3)


def test_twenty_percent_of_messages_may_be_lost_in_asynchronous_mode():
    lossy = InProcessTransport(loss=0.2, seed=1)
    agents = team(optimizer="RobustAggregativeTracking", lockstep=False, transport=lossy, stepsize=0.02)
    for agent in agents:
        agent.start(0.0)
    fly(agents, 900)
    np.testing.assert_allclose(decisions(agents), LIMITS, atol=1e-3)


class Dying(AggregativeGuidance):
    """Raises in the middle of the flight."""

    def get_target(self):
        if self.agent_id == 2 and self.now > 2.0:
            raise ValueError("out of targets")
        return super().get_target()


def test_a_guidance_that_raises_stops_its_own_drone_only():
    agents = team(Dying, stepsize=0.02, takeoff_time=1.0)
    backend = IntegratorBackend([f"agent_{i}" for i in range(3)], STARTS)
    experiment = Experiment(
        backend, [Agent(i, f"agent_{i}", agents[i], SplinePosition()) for i in range(3)], [], rate=100
    )
    experiment.takeoff()
    experiment.run(1.0)
    experiment.start()
    experiment.run(7.0)
    assert [one.failure is None for one in experiment.agents] == [True, True, False]
    assert "out of targets" in experiment.agents[2].failure
    assert any(happening.kind == "lost" for happening in experiment.events)
    survivors = [agent for agent in agents[:2] if agent.algorithm.rounds > 550]
    np.testing.assert_allclose(decisions(survivors), LIMITS[: len(survivors)], atol=1e-3)
    assert len(survivors) == 2


@pytest.mark.parametrize(
    ("options", "kind", "sentence"),
    [
        ({"stepsize": 0.0}, RangeError, "stepsize is 0"),
        ({"iterations_per_second": 200.0}, RangeError, "at most 100"),
        ({"freq_reference": -1.0}, RangeError, "freq_reference is -1"),
        ({"max_iterations": 0}, RangeError, "max_iterations is 0"),
        ({"references": "velocity"}, UnknownNameError, "trajectory, position"),
        ({"optimizer": "Gradient"}, UnknownNameError, "AggregativeTracking"),
        ({"gamma_shape": -1.0}, RangeError, "gamma_shape"),
        ({"target": (1.0,)}, RangeError, "target"),
        ({"target": None}, RangeError, "neither intruder nor target"),
        ({"target": None, "intruder_id": 0}, RangeError, "intruder_id is 0"),
    ],
)
def test_what_cannot_be_is_refused(options, kind, sentence):
    communicator = TimeVaryingCommunicator(0, 2, [1], transport=InProcessTransport())
    with pytest.raises(kind, match=sentence):
        AggregativeGuidance(0, communicator, **{"target": (0.0, 0.0), **options})


def test_lock_step_is_asked_for_where_it_is_needed():
    with pytest.raises(RangeError, match="asynchronous mode: RobustAggregativeTracking"):
        team(lockstep=False)


def test_an_optimizer_may_be_a_class():
    class Mine(AggregativeTracking):
        pass

    agents = team(optimizer=Mine)
    for agent in agents:
        agent.start(0.0)
    fly(agents, 3)
    assert type(agents[0].algorithm) is Mine
