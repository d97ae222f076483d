"""Formation by distances: the law, its rates, what it conserves, and the loss of an agent."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from integrators import Integrators

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import (
    FormationControl,
    FormationControlGuidance,
    Graph,
    InProcessTransport,
    TimeVaryingCommunicator,
)
from crazychoir_fw.guidance.distance_formation import distance_errors, fitted

TETRAHEDRON = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) * 0.5 + (0.0, 0.0, 1.5)
COMPLETE = Graph.complete(4)
PAIRS = list(COMPLETE.pairs)


def swarm(starts, graph=COMPLETE, formation=TETRAHEDRON, **options):
    made = Integrators(FormationControl, graph, starts, formation=formation, **options)
    made.press("start")
    return made


def shaken(seed, size, formation=TETRAHEDRON):
    return formation + size * np.random.default_rng(seed).uniform(-1.0, 1.0, formation.shape)


def lonely(size):
    others = list(range(1, size))
    return TimeVaryingCommunicator(0, size, others, others, transport=InProcessTransport())


def test_law_is_that_of_the_original():
    agent = FormationControlGuidance(0, lonely(3), weights=[0.0, 1.0, 2.0])
    agent.set_pose(Pose(position=np.array([0.0, 0.0, 1.0])))
    there = {1: np.array([1.5, 0.0, 1.0]), 2: np.array([0.0, 1.0, 2.0])}
    u = agent.evaluate_input({j: Pose(position=p) for j, p in there.items()})
    np.testing.assert_allclose(u, 0.1 * ((2.25 - 1.0) * np.array([1.5, 0, 0]) + (2.0 - 4.0) * np.array([0, 1, 1])))


@settings(max_examples=4)
@given(seed=st.integers(0, 10_000))
def test_a_shape_is_found_again_and_its_middle_stays(seed):
    made = swarm(shaken(seed, 0.2), max_speed=np.inf, k=0.3)
    middle = made.position.mean(axis=0)
    made.run(8.0)
    assert np.abs(distance_errors(made.position, TETRAHEDRON, PAIRS)).max() < 5e-3
    np.testing.assert_allclose(made.position.mean(axis=0), middle, atol=1e-9)


def test_errors_fall_as_the_linear_law_says():
    # squared lengths: ds/dt = -2 k R R' s, R with rows of edges
    made = swarm(shaken(3, 0.01), max_speed=np.inf)
    R = np.zeros((6, 12))
    for row, (i, j) in enumerate(PAIRS):
        edge = TETRAHEDRON[i] - TETRAHEDRON[j]
        R[row, 3 * i : 3 * i + 3], R[row, 3 * j : 3 * j + 3] = edge, -edge

    before = distance_errors(made.position, TETRAHEDRON, PAIRS)
    made.run(4.0)
    rates, modes = np.linalg.eigh(R @ R.T)
    expected = modes @ (np.exp(-2.0 * 0.1 * rates * 4.0) * (modes.T @ before))
    assert np.abs(expected).max() < 0.3 * np.abs(before).max()
    np.testing.assert_allclose(
        distance_errors(made.position, TETRAHEDRON, PAIRS), expected, atol=0.03 * np.abs(before).max()
    )


def test_the_potential_never_rises_though_speeds_are_bounded():
    made = swarm(shaken(5, 0.8), max_speed=0.2)

    def potential():
        lengths = distance_errors(made.position, TETRAHEDRON * 0.0, PAIRS)
        wanted = distance_errors(TETRAHEDRON, TETRAHEDRON * 0.0, PAIRS)
        return np.sum((lengths**2 - wanted**2) ** 2)

    before = potential()
    for _ in range(60):
        made.step()
        after = potential()
        assert after <= before + 1e-9
        before = after
        assert (np.linalg.norm(made.velocity, axis=1) <= 0.2 + 1e-12).all()


def test_heights_are_those_of_the_places_and_may_be_kept():
    flat = TETRAHEDRON * (1, 1, 0) + (0, 0, 0.9)
    made = swarm(shaken(1, 0.1) * (1, 1, 0), formation=flat, keeps_height=True, k=0.3)
    assert made.agents[0].takeoff_height == pytest.approx(0.9)
    made.press("takeoff")
    made.run(6.0)
    np.testing.assert_allclose(made.position[:, 2], 0.9, atol=1e-9)
    made.press("start")
    made.run(8.0)
    np.testing.assert_allclose(made.position[:, 2], 0.9, atol=1e-9)
    assert np.abs(distance_errors(made.position, flat, PAIRS)).max() < 5e-3
    made.press("land")
    made.run(6.0)
    assert (made.position[:, 2] < 0.05).all()


def test_who_dies_is_left_out_and_the_others_take_their_shape():
    made = swarm(shaken(2, 0.3), k=0.3).run(1.0)
    made.kill(3)
    made.run(10.0)
    assert all(3 in made.agents[i].lost for i in range(3))
    left = [pair for pair in PAIRS if 3 not in pair]
    assert np.abs(distance_errors(made.position, TETRAHEDRON, left)).max() < 5e-3
    assert np.isfinite(made.position).all()


def test_nobody_asks_for_the_floor():
    low = TETRAHEDRON - (0.0, 0.0, 0.7)
    made = swarm(low - np.array([0.0, 0.0, 0.05]), formation=low * 2.0, lowest=0.2).run(5.0)
    assert made.position[:, 2].min() >= 0.2 - 1e-9


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_a_formation_is_fitted_however_it_is_moved_turned_and_mirrored(seed):
    dice = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(dice.standard_normal((3, 3)))
    moved = TETRAHEDRON @ turn + dice.standard_normal(3)
    np.testing.assert_allclose(fitted(TETRAHEDRON, moved), moved, atol=1e-9)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "give one of formation and weights"),
        ({"formation": TETRAHEDRON, "weights": np.ones(4)}, "give one of"),
        ({"formation": TETRAHEDRON[:3]}, r"allowed: \(4, 3\)"),
        ({"weights": [0, 1, 1, 0]}, "the distance to agent 3 is 0.0"),
        ({"weights": [0, 1, 1]}, r"allowed: \(4,\)"),
        ({"formation": TETRAHEDRON, "k": 0.0}, "k is 0.0"),
        ({"formation": TETRAHEDRON, "max_speed": 0.0}, "max_speed is 0.0"),
        ({"formation": TETRAHEDRON, "leash": -1.0}, "leash is -1.0"),
        ({"formation": TETRAHEDRON, "lowest": np.nan}, "lowest is nan"),
    ],
)
def test_bad_values_are_refused(options, says):
    with pytest.raises(RangeError, match=says):
        FormationControl(0, lonely(4), **options)
