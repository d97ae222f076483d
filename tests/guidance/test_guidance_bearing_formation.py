"""Formations on double integrators: published numbers, laws, phases, and swarms that lose members."""

import numpy as np
import pytest
from guidance_swarm import (
    GRID,
    LETTER_S,
    LETTER_S_GRAPH,
    SQUARE,
    SQUARE_GRAPH,
    SQUARE_STARTS,
    Swarm,
    grid_graph,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.guidance import (
    FORMATION_GAINS,
    BearingFormation,
    FormationGains,
    Graph,
    InProcessTransport,
    Phase,
    RandomEdges,
    TimedGraphs,
    TimeVaryingCommunicator,
)
from crazychoir_fw.guidance.bearing import bearing_error_deg, ort_proj, projections


def square(**options):
    swarm = Swarm(SQUARE, SQUARE_GRAPH, SQUARE_STARTS, **options)
    swarm.measure()
    swarm.press("start")
    return swarm


def error(swarm):
    return bearing_error_deg(swarm.position, swarm.formation, swarm.graph.pairs)


# ------------------------------------------------------------------ docs/reference/crazychoir.md#23


def test_four_drones_are_where_the_reference_says():
    swarm, expected = (
        square(dt=0.01),
        {
            5: [(0.467, 0.288), (-0.604, 0.390)],
            10: [(0.639, 0.564), (-0.667, 0.597)],
            20: [(0.696, 0.820), (-0.739, 0.804)],
            30: [(0.700, 0.733), (-0.710, 0.728)],
        },
    )
    for time, places in expected.items():
        swarm.run(time - swarm.now)
        np.testing.assert_allclose(swarm.position[2:, :2], places, atol=1.5e-3)
    swarm.run(30.0)
    assert np.abs(swarm.position - SQUARE).max() < 0.0072


def test_formation_rviz_settles_on_the_unit_square():
    gains = FormationGains(k_p=1.0, k_v=5.0)
    starts = np.array([(1.0, 0.0, 1.0), (2.0, 0.0, 1.0), (0.8, 1.4, 1.0), (0.3, 0.6, 1.0)])
    square_of_two = np.array([(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
    swarm = Swarm(square_of_two, SQUARE_GRAPH, starts, gains=gains)
    swarm.press("start")
    swarm.run(40.0)
    np.testing.assert_allclose(swarm.position[2:], [(2.0, 1.0, 1.0), (1.0, 1.0, 1.0)], atol=5e-3)


@pytest.mark.parametrize(
    ("name", "k_p", "k_v", "k_i", "takeoff"),
    [
        ("webots", 0.2, 1.0, (0, 0, 0), [(0.4, 0.4, 1.25), (0.2, 0.2, 0.4), (0, 0, 0)]),
        ("huge", 0.07, 0.35, (0, 0, 0), [(0.4, 0.4, 1.25), (0.2, 0.2, 0.4), (0, 0, 0)]),
        ("vicon", (3, 3, 10), 3.0, (0, 0, 1), [(7.2, 7.2, 30), (3.6, 3.6, 12), (0, 0, 1)]),
    ],
)
def test_gains_are_the_originals(name, k_p, k_v, k_i, takeoff):
    gains = FORMATION_GAINS[name]
    for value, expected in [(gains.k_p, k_p), (gains.k_v, k_v), (gains.k_i, k_i)]:
        np.testing.assert_array_equal(value, np.broadcast_to(expected, 3))
    np.testing.assert_array_equal([gains.takeoff_k_p, gains.takeoff_k_d, gains.takeoff_k_i], takeoff)


# ------------------------------------------------------------------ the law


def lone_follower(**options):
    communicator = TimeVaryingCommunicator(2, 4, [1, 3], transport=InProcessTransport())
    return BearingFormation(2, communicator, is_leader=False, formation=SQUARE, **options)


VECTOR = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)


@settings(max_examples=40)
@given(st.lists(VECTOR, min_size=6, max_size=6), st.sampled_from(["webots", "huge", "vicon"]))
def test_the_input_is_the_papers(vectors, gains):
    own, one, other = (Pose(position=vectors[k], velocity=vectors[k + 1]) for k in (0, 2, 4))
    follower, expected = lone_follower(gains=gains), np.zeros(3)
    follower.set_pose(own)
    g = FORMATION_GAINS[gains]
    for neighbor, pose in ((1, one), (3, other)):
        block = projections(SQUARE, 2, [neighbor])[neighbor]
        expected -= block @ (g.k_p * (own.position - pose.position) + g.k_v * (own.velocity - pose.velocity))
    np.testing.assert_allclose(follower.evaluate_input({1: one, 3: other}), expected, atol=1e-12)
    # neither the order of the messages matters, nor that a velocity is unknown and zero
    np.testing.assert_allclose(follower.evaluate_input({3: other, 1: one}), expected, atol=1e-12)


def test_ort_proj_and_formation_give_the_same_input():
    poses = {1: Pose(position=np.array([0.1, 0.2, 0.3])), 3: Pose(position=np.array([-0.4, 0.5, 1.6]))}
    communicator = TimeVaryingCommunicator(2, 4, [1, 3], transport=InProcessTransport())
    first = lone_follower()
    second = BearingFormation(2, communicator, is_leader=False, ort_proj=ort_proj(SQUARE, 2, [1, 3]))
    for follower in (first, second):
        follower.set_pose(Pose(position=np.zeros(3)))
    np.testing.assert_array_equal(first.evaluate_input(poses), second.evaluate_input(poses))


def integral_inputs(steps, period, **options):
    """Inputs of a follower that does not move and whose neighbors do not either."""
    transport = InProcessTransport()
    agents = [
        BearingFormation(
            i,
            TimeVaryingCommunicator(i, 4, SQUARE_GRAPH.in_neighbors(i), transport=transport),
            is_leader=i != 2,
            formation=SQUARE,
            **options,
        )
        for i in (1, 2, 3)
    ]
    inputs = []
    for step in range(steps):
        for agent in agents:
            agent.set_pose(Pose(position=np.array([0.3, 0.2, 0.1]) * agent.agent_id, velocity=np.zeros(3)))
            if step == 0:
                agent.start(0.0)
            agent.begin_round(step * period)
        inputs.append([agent.finish_round(step * period) for agent in agents][1].reference.acceleration)
    return np.array(inputs)


@pytest.mark.parametrize("period", [0.01, 0.025])
def test_integrals_are_those_of_each_neighbor_in_real_time(period):
    k_i = np.array([0.3, 0.3, 1.0])
    inputs = integral_inputs(11, period, gains=FormationGains(k_p=0.0, k_v=0.0, k_i=k_i))
    expected = np.zeros(3)
    for neighbor, block in projections(SQUARE, 2, [1, 3]).items():
        expected -= block @ (k_i * 10 * period * np.array([0.3, 0.2, 0.1]) * (2 - neighbor))
    np.testing.assert_allclose(inputs[-1], expected, atol=1e-12)


def test_legacy_integral_is_shared_and_takes_a_millisecond_per_tick():
    k_i = np.array([0.3, 0.3, 1.0])
    inputs = integral_inputs(11, 0.025, gains=FormationGains(k_p=0.0, k_v=0.0, k_i=k_i), legacy=True)
    # errors against 1 and 3 are opposite here: one accumulator for both holds nothing
    np.testing.assert_allclose(inputs, 0.0, atol=1e-12)


def test_legacy_takeoff_integral_depends_on_the_rate():
    def height(legacy, period):
        follower = lone_follower(gains="vicon", legacy=legacy)
        follower.set_pose(Pose(position=np.zeros(3), velocity=np.zeros(3)))
        follower.takeoff(0.0)
        for step in range(round(1.0 / period) + 1):
            follower.begin_round(step * period)
            u = follower.finish_round(step * period).reference.acceleration
        return u[2] - 30.0 * 0.2

    assert height(False, 0.01) == pytest.approx(0.1, abs=0.002)
    assert height(False, 0.02) == pytest.approx(0.1, abs=0.0021)
    assert height(True, 0.01) == pytest.approx(0.01, abs=0.001)
    assert height(True, 0.02) == pytest.approx(0.005, abs=0.001)


def test_gains_that_differ_between_axes_still_rest_at_the_formation():
    pyramid = np.array([(-1.0, -1.0, 0.5), (1.0, -1.0, 0.5), (1.0, 1.0, 0.5), (0.0, 0.0, 2.0)])
    gains = FormationGains(k_p=(2.0, 3.0, 4.0), k_v=3.0, k_i=(0.0, 0.0, 0.2))
    swarm = Swarm(pyramid, Graph.complete(4), pyramid, gains=gains)
    swarm.position[3] += (0.3, -0.2, 0.4)
    swarm.press("start")
    swarm.run(40.0)
    np.testing.assert_allclose(swarm.position, pyramid, atol=5e-3)


def test_the_input_has_a_limit():
    follower = lone_follower(gains="mujoco")
    follower.set_pose(Pose(position=np.array([50.0, 20.0, 10.0]), velocity=np.zeros(3)))
    follower.start(0.0)
    follower.communicator._boxes[1].put(0, Pose(position=np.zeros(3)), 0)
    follower.begin_round(0.0)
    assert np.linalg.norm(follower.finish_round(0.0).reference.acceleration) == pytest.approx(2.0)


# ------------------------------------------------------------------ 4, 11 and 30 drones


@pytest.mark.parametrize("seed", [0, 1])
def test_mujoco_gains_reach_the_formation_in_spite_of_noise_and_bias(seed):
    starts = SQUARE_STARTS * (1.0, 1.0, 0.015)
    swarm = Swarm(SQUARE, SQUARE_GRAPH, starts, seed=seed, noise=(0.002, 0.02), gains="mujoco", height=1.0)
    swarm.bias[:] = (0.03, -0.02, 0.3)  # attitude and thrust are never exact
    swarm.measure()
    swarm.press("takeoff")
    for _ in range(400):
        # leaders have trajectories of their own
        swarm.position[:2, 2] = min(1.0, 0.2 * swarm.now)
        swarm.step()
    np.testing.assert_allclose(swarm.position[:, 2], 1.0, atol=0.03)
    swarm.press("start")
    swarm.run(25.0)
    assert error(swarm) < 1.0 and np.abs(swarm.position - SQUARE).max() < 0.05
    swarm.run(5.0)
    assert error(swarm) < 1.0 and np.abs(swarm.position - SQUARE).max() < 0.05


def test_eleven_drones_write_the_letter():
    # leaders are in place, the others somewhere near
    starts = LETTER_S + np.r_[np.zeros((2, 3)), np.random.default_rng(2).uniform(-0.3, 0.3, (9, 3))]
    swarm = Swarm(LETTER_S, LETTER_S_GRAPH, starts, gains="webots")
    swarm.press("start")
    before = error(swarm)
    swarm.run(40.0)
    assert before > 10.0 and error(swarm) < 1.0


def test_thirty_drones_make_the_grid():
    starts = GRID + np.r_[np.zeros((2, 3)), np.random.default_rng(2).normal(0.0, 0.15, (28, 3))]
    swarm = Swarm(GRID, grid_graph(), starts, gains="mujoco")
    swarm.press("start")
    before = error(swarm)
    swarm.run(10.0)
    # size comes in hours; directions come soon
    assert before > 10.0 and error(swarm) < before / 4


# ------------------------------------------------------------------ phases


def test_followers_climb_and_land_and_leaders_get_trajectories():
    swarm = Swarm(SQUARE, SQUARE_GRAPH, SQUARE_STARTS * (1, 1, 0.015), gains="mujoco", height=0.8, takeoff_time=4.0)
    swarm.step()
    assert all(out.idle and out.reference is None for out in swarm.outputs.values())
    swarm.press("takeoff")
    swarm.step()
    (point,) = swarm.outputs[0].trajectory
    np.testing.assert_allclose([point.time_s, *point.position], [4.0, -0.7, -0.7, 0.8])
    assert swarm.outputs[0].reference is None and swarm.outputs[2].trajectory is None
    highest = 0.0
    for _ in range(400):
        swarm.step()
        highest = max(highest, swarm.position[2, 2])
    np.testing.assert_allclose(swarm.position[2:], SQUARE_STARTS[2:] * (1, 1, 0.8), atol=0.01)
    assert highest < 0.8 * 1.1  # damped
    swarm.press("land")
    swarm.step()
    np.testing.assert_allclose(swarm.outputs[0].trajectory[0].position, (-0.7, -0.7, 0.01))
    swarm.run(4.5)
    assert all(agent.phase is Phase.IDLE for agent in swarm.agents[2:])
    assert swarm.position[2:, 2].max() < 0.06
    swarm.run(1.0)
    assert all(out.idle and out.reference is None for out in swarm.outputs.values())


def test_the_originals_takeoff_is_lightly_damped():
    swarm = Swarm(SQUARE, SQUARE_GRAPH, SQUARE_STARTS * (1, 1, 0.015), gains="webots")
    swarm.step()
    swarm.press("takeoff")
    heights = []
    for _ in range(500):
        swarm.step()
        heights.append(swarm.position[2, 2])
    assert 1.05 < max(heights) < 1.25


def test_stop_is_latched():
    swarm = square()
    swarm.run(0.1)
    swarm.press("stop")
    swarm.press("start")
    swarm.press("land")
    swarm.run(0.1)
    assert all(out.idle for out in swarm.outputs.values())
    swarm.press("resume")
    swarm.press("start")
    swarm.step()
    assert swarm.outputs[2].reference is not None


def test_a_leader_flies_the_trajectory_it_was_given():
    points = [TrajectoryPoint(5.0, np.array([1.0, 0.0, 1.0])), TrajectoryPoint(9.0, np.array([0.0, 0.0, 1.0]))]
    swarm = square(trajectory=points)
    swarm.step()
    assert swarm.outputs[0].trajectory == points and swarm.outputs[2].trajectory is None
    swarm.step()
    assert swarm.outputs[0].trajectory is None


@pytest.mark.parametrize("leaders", [(0, 1), (0, 1, 2), (1, 3), (0, 1, 2, 3)])
def test_any_number_of_leaders(leaders):
    starts = SQUARE.copy()
    followers = [i for i in range(4) if i not in leaders]
    starts[followers] += (0.2, -0.1, 0.1)
    swarm = Swarm(
        SQUARE, SQUARE_GRAPH if leaders != (1, 3) else Graph.complete(4), starts, leaders=leaders, gains="mujoco"
    )
    swarm.press("start")
    swarm.run(30.0)
    np.testing.assert_allclose(swarm.position, SQUARE, atol=1e-2)


@pytest.mark.parametrize(
    ("make", "failure", "words"),
    [
        (lambda: lone_follower(gains="fast"), UnknownNameError, "webots, huge, vicon, mujoco"),
        (lambda: lone_follower(ort_proj=[0.0] * 36), RangeError, "one of formation and ort_proj"),
        (lambda: lone_follower(deadline=0.0), RangeError, "deadline is 0"),
        (lambda: FormationGains(k_p=-1.0), RangeError, "k_p is -1.0"),
        (lambda: FormationGains(k_p=(1.0, 2.0)), RangeError, "k_p"),
        (
            lambda: BearingFormation(
                1,
                TimeVaryingCommunicator(2, 4, [1], transport=InProcessTransport()),
                is_leader=False,
                formation=SQUARE,
            ),
            RangeError,
            "communicator is that of agent 2",
        ),
        (
            lambda: BearingFormation(
                2,
                TimeVaryingCommunicator(2, 5, [1], transport=InProcessTransport()),
                is_leader=False,
                formation=SQUARE,
            ),
            RangeError,
            r"allowed: \(5, 3\)",
        ),
    ],
)
def test_bad_arguments_are_named(make, failure, words):
    with pytest.raises(failure, match=words):
        make()


# ------------------------------------------------------------------ members that are lost


@pytest.mark.parametrize("victim", [0, 1, 2, 3])
def test_losing_one_is_reported_within_a_second_and_the_rest_goes_on(victim):
    swarm = square(gains="mujoco")
    swarm.run(3.0)
    swarm.kill(victim)
    died = swarm.now
    swarm.run(1.0)
    expected = {("lost", agent, victim) for agent in SQUARE_GRAPH.in_neighbors(victim)}
    assert {event[:3] for event in swarm.events} == expected
    assert all(event[3] - died <= 1.0 for event in swarm.events)
    rounds = swarm.agents[(victim + 1) % 4].communicator.statistics.rounds
    swarm.run(24.0)
    # at full rate again
    assert swarm.agents[(victim + 1) % 4].communicator.statistics.rounds - rounds == 1200
    rest = [pair for pair in SQUARE_GRAPH.pairs if victim not in pair]
    assert bearing_error_deg(swarm.position, SQUARE, rest) < 1.0
    followers = [i for i in sorted(swarm.alive) if i >= 2]
    assert np.abs(swarm.velocity[followers]).max() < 2e-2
    np.testing.assert_allclose(swarm.position[followers, 2], 1.0, atol=0.02)


@pytest.mark.parametrize("victim", [0, 3])
def test_what_is_left_does_not_drift_away(victim):
    swarm = square(gains="mujoco", noise=(0.002, 0.02), seed=5)
    swarm.run(15.0)
    swarm.kill(victim)
    swarm.bias[2:] = (0.003, 0.003, 0.003)
    swarm.run(15.0)
    settled = swarm.position.copy()
    swarm.run(40.0)
    assert np.abs(swarm.position - settled)[sorted(swarm.alive)].max() < 0.15


def test_who_hears_nobody_stays_where_it_is():
    swarm = square(gains="mujoco")
    swarm.run(20.0)
    for victim in (0, 1, 3):
        swarm.kill(victim)
    swarm.velocity[2] = (0.3, -0.2, 0.1)
    swarm.bias[2] = (0.1, 0.0, -0.2)
    swarm.run(1.0)
    begin = swarm.position[2].copy()
    swarm.run(40.0)
    assert np.abs(swarm.position[2] - begin).max() < 0.2 and np.abs(swarm.velocity[2]).max() < 1e-2


def test_a_restarted_member_is_taken_back():
    swarm = square(gains="mujoco")
    swarm.run(3.0)
    swarm.kill(3)
    swarm.run(2.0)
    swarm.agents[3] = swarm.make(3)
    swarm.alive.add(3)
    swarm.measure()
    swarm.agents[3].start(swarm.now)
    swarm.events.clear()
    swarm.run(0.2)
    assert {event[:3] for event in swarm.events} == {("rejoined", agent, 3) for agent in (0, 1, 2)}
    assert {agent.communicator.current_label for agent in swarm.agents} == {swarm.agents[0].communicator.current_label}
    assert not any(agent.lost for agent in swarm.agents)
    swarm.run(20.0)
    assert error(swarm) < 1.0


def test_a_restarted_leader_that_hears_nobody_is_taken_back():
    one_way = Graph.directed(4, [(0, 3), (1, 2), (1, 3), (0, 2), (2, 3), (3, 2)])
    swarm = Swarm(SQUARE, one_way, SQUARE_STARTS, gains="mujoco")
    swarm.press("start")
    swarm.run(3.0)
    swarm.kill(1)
    swarm.run(2.0)
    swarm.agents[1] = swarm.make(1)  # it counts rounds from 0, and receives no messages to correct that
    swarm.alive.add(1)
    swarm.measure()
    swarm.run(1.0)
    assert not swarm.agents[2].lost and not swarm.agents[3].lost
    rounds = swarm.agents[2].communicator.statistics.rounds
    swarm.run(20.0)
    assert swarm.agents[2].communicator.statistics.rounds - rounds == 1000
    assert error(swarm) < 1.0


@pytest.mark.parametrize("loss", [0.05, 0.2])
def test_lost_messages_do_not_matter(loss):
    swarm = square(gains="mujoco", transport=InProcessTransport(loss=loss, seed=1))
    swarm.run(20.0)
    assert error(swarm) < 1.0 and not swarm.events


def test_asynchronous_exchange_flies_as_well():
    swarm = square(gains="mujoco")
    for agent in swarm.agents:
        agent.communicator.synchronous_mode = False
    swarm.run(20.0)
    assert error(swarm) < 1.0


@pytest.mark.parametrize(
    "schedule",
    [
        RandomEdges(SQUARE_GRAPH, 0.8, seed=1, rounds=10),
        TimedGraphs([(0.0, SQUARE_GRAPH), (1.0, Graph.ring(4)), (2.0, Graph.undirected(4, [(0, 2), (1, 3)]))], 3.0),
    ],
    ids=["random", "by time"],
)
def test_graphs_that_change(schedule):
    whole = Graph.complete(4)
    swarm = Swarm(SQUARE, whole, SQUARE_STARTS, gains=FormationGains(k_p=0.5, k_v=2.0), schedule=schedule)
    swarm.press("start")
    swarm.run(60.0)
    assert error(swarm) < 1.0 and not swarm.events


def test_a_pose_that_is_none_is_left_out():
    swarm = square()
    swarm.run(0.5)
    swarm.agents[1].current_pose = Pose(position=np.array([np.nan, 0.0, 0.0]))
    for agent in swarm.agents:
        agent.begin_round(swarm.now)
    out = [agent.finish_round(swarm.now) for agent in swarm.agents]
    assert np.isfinite(out[2].reference.acceleration).all()


def test_a_step_never_waits():
    agents = square().agents[:3]
    for agent in agents:
        agent.set_pose(Pose(position=np.zeros(3), velocity=np.zeros(3)))
    follower = agents[2]
    assert follower.step(0.0).reference is None and follower.round_open
    agents[1].begin_round(0.0)
    assert follower.step(0.04).reference is None
    assert follower.step(0.05).reference is not None and not follower.round_open
    first = follower.step(0.06).reference  # the next round: still the last reference
    assert first is not None and follower.round_open


def test_same_seed_same_bits():
    def fly():
        swarm = square(gains="mujoco", noise=(0.002, 0.02), seed=3, transport=InProcessTransport(loss=0.1, seed=2))
        return swarm.run(5.0).position.tobytes()

    assert fly() == fly()
