"""Model predictive control: one problem against a solver, many agents against one, and agents that stop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator
from crazychoir_fw.guidance.schemes import MPCGuidance, MPCProblem
from crazychoir_fw.guidance.schemes.mpc_problem import lqr

cp = pytest.importorskip("cvxpy")

BOTH = np.array([[1.0], [-1.0]])


def line(horizon=10, speed=0.5):
    return MPCProblem(1.0, 1.0, 1.0, 1.0, horizon, E=BOTH, f=[10.0, 10.0], G=BOTH, h=[speed, speed])


def test_regulator_of_one_integrator():
    # P = 1 + P / (1 + P): the golden ratio
    P, K = lqr(*(np.eye(1),) * 4)
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    assert P[0, 0] == pytest.approx(golden)
    assert K[0, 0] == pytest.approx(-golden / (1.0 + golden))


@settings(max_examples=4)
@given(seed=st.integers(0, 10_000))
def test_one_problem_is_solved_as_by_a_solver(seed):
    dice = np.random.default_rng(seed)
    A = np.array([[1.0, 0.2], [0.0, 1.0]])
    B = np.array([[0.02], [0.2]])
    problem = MPCProblem(A, B, np.eye(2), [[0.5]], 8, G=BOTH, h=[2.0, 2.0])
    start, bound = dice.uniform(-1.0, 1.0, 2), dice.uniform(0.3, 1.0)
    plan = problem.solve(start, [[0.0, 1.0]], np.full((8, 1), bound + 0.5))
    x, u = cp.Variable((9, 2)), cp.Variable((8, 1))
    cost = sum(cp.sum_squares(x[t]) + 0.5 * cp.sum_squares(u[t]) for t in range(8)) + cp.quad_form(x[8], problem.P)
    rules = [x[0] == start, x[1:, 1] <= bound + 0.5, cp.abs(u) <= 2.0]
    rules += [x[t + 1] == A @ x[t] + B @ u[t] for t in range(8)]
    best = cp.Problem(cp.Minimize(cost), rules).solve(solver="CLARABEL")
    if plan.violation == 0.0:
        assert problem.cost(plan) == pytest.approx(best, rel=1e-5)


def test_what_cannot_be_kept_is_exceeded_as_little_as_possible():
    plan = line().solve([3.0], [[1.0]], np.full((10, 1), 1.0))
    assert plan.violation == pytest.approx(1.5, abs=1e-3)
    np.testing.assert_allclose(plan.inputs[:4], -0.5, atol=1e-6)
    with pytest.raises(RangeError, match="b has 3 numbers"):
        line().solve([0.0], [[1.0]], [1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((np.eye(2), np.eye(1), np.eye(1), np.eye(1), 5), r"A has shape \(2, 2\)"),
        ((1.0, 1.0, 1.0, 1.0, 0), "horizon is 0"),
        ((2.0, 0.0, 1.0, 1.0, 5), "no regulator"),
    ],
)
def test_bad_problems_are_refused(arguments, says):
    with pytest.raises(RangeError, match=says):
        MPCProblem(*arguments)


class Line:
    """Drones on a line that are where their references are."""

    def __init__(self, starts, dt=0.1, **options):
        self.n, self.dt, self.round = len(starts), dt, 0
        self.position = np.column_stack([starts, np.arange(self.n), np.ones(self.n)]).astype(float)
        graph, transport = Graph.complete(self.n), InProcessTransport()
        self.agents = []
        for i in range(self.n):
            communicator = TimeVaryingCommunicator(
                i, self.n, graph.in_neighbors(i), graph.out_neighbors(i), transport=transport
            )
            self.agents.append(MPCGuidance(i, communicator, update_frequency=1.0 / dt, **options))
        self.alive = set(range(self.n))
        self.history = [self.position[:, 0].copy()]
        for agent in self.agents:
            agent.set_pose(self.pose(agent.agent_id))
            agent.start(0.0)

    def pose(self, i):
        return Pose(position=self.position[i].copy(), velocity=np.zeros(3))

    def run(self, seconds):
        for _ in range(round(seconds / self.dt)):
            now = self.round * self.dt
            up = [self.agents[i] for i in sorted(self.alive)]
            for agent in up:
                agent.set_pose(self.pose(agent.agent_id))
                agent.begin_round(now)
            for agent in up:
                done = agent.round_open and agent.is_complete(now)
                out = agent.finish_round(now) if done else agent.step(now)
                if out.reference is not None:
                    self.position[agent.agent_id] = out.reference.position
            self.round += 1
            self.history.append(self.position[:, 0].copy())
        return self


def spread(history):
    history = np.array(history)
    return np.ptp(history, axis=1).max()


def test_the_line_of_the_original_reaches_the_origin_without_breaking_a_rule():
    swarm = Line([3.8, 2.6, 2.1, 3.3], largest_input=[0.2, 0.5, 0.5, 0.5], margin=0.0).run(28.0)
    assert np.abs(swarm.position[:, 0]).max() < 0.02
    assert spread(swarm.history) <= 2.0 + 1e-6
    # the fast ones had to wait, so that the rule did bind
    assert spread(swarm.history) > 1.95
    speeds = np.abs(np.diff(swarm.history, axis=0)) / swarm.dt
    assert (speeds.max(axis=0) <= np.array([0.2, 0.5, 0.5, 0.5]) + 1e-6).all()
    assert all(agent.violations == 0 for agent in swarm.agents)
    np.testing.assert_array_equal(swarm.position[:, 1:], [[i, 1.0] for i in range(4)])


@settings(max_examples=4)
@given(seed=st.integers(0, 10_000), free=st.booleans())
def test_one_round_costs_as_much_as_one_solution_for_all_or_hardly_more(seed, free):
    dice = np.random.default_rng(seed)
    starts = dice.uniform(0.5, 2.4, 3)
    speeds = [0.1, 0.5, 0.5]
    coupling = 5.0 if free else max(1.0, float(np.ptp(starts)) + 0.1)
    swarm = Line(starts, largest_input=speeds, coupling=coupling, margin=0.0).run(1.2)
    problem = [line(10, speed) for speed in speeds]
    found = sum(one.cost(agent.plan) for one, agent in zip(problem, swarm.agents, strict=True))

    x, u = cp.Variable((11, 3)), cp.Variable((10, 3))
    cost = cp.sum_squares(x[:10]) + cp.sum_squares(u) + problem[0].P[0, 0] * cp.sum_squares(x[10])
    rules = [x[0] == starts, x[1:] == x[:10] + u, cp.abs(u) <= np.tile(speeds, (10, 1))]
    rules += [cp.abs(x[:, i] - x[:, j]) <= coupling for i in range(3) for j in range(i)]
    best = cp.Problem(cp.Minimize(cost), rules).solve(solver="CLARABEL")
    assert found >= best - 1e-4 * best
    assert found <= best * (1.0 + 1e-5 if free else 1.25)


@pytest.mark.parametrize("dead", [0, 2])
def test_who_dies_is_awaited_for_a_while_and_then_left_out(dead):
    swarm = Line([3.0, 2.0, 2.5], coupling=1.5).run(2.0)
    swarm.alive.discard(dead)
    swarm.run(12.0)
    left = sorted(swarm.alive)
    assert all(dead in swarm.agents[i].lost for i in left)
    assert np.abs(swarm.position[left, 0]).max() < 0.05
    assert spread(np.array(swarm.history)[:, left]) <= 1.5


def test_drones_that_are_too_far_apart_come_together():
    swarm = Line([4.0, 0.0], coupling=2.0, goal=2.0).run(10.0)
    assert np.abs(swarm.position[:, 0] - 2.0).max() < 0.02


def test_nonsense_of_a_neighbor_is_ignored():
    swarm = Line([1.0, 0.5]).run(0.5)
    for told in (None, 3, {"period": 1}, {"period": 1, "states": np.zeros((2, 1))}, {"period": "a", "states": 1}):
        assert swarm.agents[0]._read(told) is None
    nan = {"period": 1, "states": np.full((11, 1), np.nan)}
    assert swarm.agents[0]._read(nan) is None


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"axes": "xx"}, "axes are 'xx'"),
        ({"axes": "w"}, "axes are 'w'"),
        ({"coupling": 0.0}, "coupling is 0.0"),
        ({"margin": 2.0}, "margin is 2.0"),
        ({"goal": [0.0, 1.0]}, "goal is"),
        ({"largest_input": [0.1, 0.2, 0.3]}, "one number or 2"),
        ({"horizon": 0}, "horizon is 0"),
        ({"sampling_period": -1.0}, "sampling_period is -1.0"),
    ],
)
def test_bad_guidance_is_refused(options, says):
    with pytest.raises(RangeError, match=says):
        Line([0.0, 1.0], **options)
