"""DISROPT itself over a communicator of ours; what needs the package is skipped where it is not installed."""

import importlib.util
import sys
import threading

import numpy as np
import pytest

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.guidance import InProcessTransport, StaticCommunicator
from crazychoir_fw.guidance.optimization import disropt_bridge, graphs

HAS_DISROPT = importlib.util.find_spec("disropt") is not None
needs_disropt = pytest.mark.skipif(not HAS_DISROPT, reason="disropt is not installed")


@pytest.fixture(params=["missing", "without a library"])
def no_mpi(request, monkeypatch, tmp_path):
    """MPI is not there: neither the package, or only the library that it loads."""
    for name in [one for one in sys.modules if one.split(".")[0] == "mpi4py"]:
        monkeypatch.delitem(sys.modules, name)
    if request.param == "missing":
        monkeypatch.setitem(sys.modules, "mpi4py", None)
    else:
        (tmp_path / "mpi4py").mkdir()
        (tmp_path / "mpi4py" / "__init__.py").touch()
        (tmp_path / "mpi4py" / "MPI.py").write_text("raise RuntimeError('cannot load MPI library')")
        monkeypatch.syspath_prepend(tmp_path)


def test_stand_in_for_mpi_is_there_for_the_block_only(no_mpi):
    before = {name: module for name, module in sys.modules.items() if name.startswith("mpi4py")}
    with disropt_bridge.without_mpi():
        from mpi4py import MPI

        with pytest.raises(StateError, match="there is no MPI here"):
            _ = MPI.COMM_WORLD
        assert not hasattr(MPI, "__wrapped__")
    after = {name: module for name, module in sys.modules.items() if name.startswith("mpi4py")}
    assert {**after, "mpi4py": None} == {**before, "mpi4py": None}
    with pytest.raises((ImportError, RuntimeError)):
        import mpi4py.MPI  # noqa: F401


def test_real_mpi_is_left_alone(monkeypatch):
    real, package = type(sys)("mpi4py.MPI"), type(sys)("mpi4py")
    package.MPI = real
    monkeypatch.setitem(sys.modules, "mpi4py", package)
    monkeypatch.setitem(sys.modules, "mpi4py.MPI", real)
    with disropt_bridge.without_mpi():
        assert sys.modules["mpi4py.MPI"] is real


@pytest.mark.skipif(HAS_DISROPT, reason="disropt is installed")
def test_missing_disropt_is_one_sentence():
    with pytest.raises(StateError, match=r"disropt is missing: run pip install 'crazychoir-fw\[disropt\]'"):
        disropt_bridge.import_disropt()


def run_four(make, **arguments):
    """Run an algorithm of DISROPT with four agents on a ring, each in a thread; return them."""
    disropt = disropt_bridge.import_disropt()
    ring = graphs.ring_graph(4)
    weights = graphs.metropolis_hastings(ring)
    transport = InProcessTransport(serialize=True)
    algorithms, errors = {}, []
    agents = []
    for i in range(4):
        neighbors = np.flatnonzero(ring[i]).tolist()
        communicator = StaticCommunicator(
            i, 4, neighbors, differentiated_topics=True, transport=transport, deadline=30.0
        )
        agents.append(
            disropt.agents.Agent(neighbors, neighbors, disropt_bridge.adapted(communicator), weights[i].tolist())
        )

    def run(agent):
        try:
            algorithms[agent.id] = make(disropt, agent)
            algorithms[agent.id].run(**arguments)
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=run, args=(agent,)) for agent in agents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    return [algorithms[i] for i in range(4)]


@needs_disropt
def test_consensus_of_disropt():
    algorithms = run_four(
        lambda disropt, agent: disropt.algorithms.Consensus(agent, np.array([[float(agent.id)]])), iterations=60
    )
    np.testing.assert_allclose([one.get_result().item() for one in algorithms], 1.5, atol=1e-6)


@needs_disropt
def test_distributed_simplex_of_disropt():
    costs = np.array([[4.0, 1.0, 3.0, 2.0], [2.0, 0.0, 5.0, 3.0], [3.0, 2.0, 2.0, 1.0], [1.0, 3.0, 4.0, 2.0]])

    def make(disropt, agent):
        x = disropt.functions.Variable(4)
        rows = np.zeros((8, 4))
        rows[agent.id] = 1.0
        rows[4:] = np.eye(4)
        problem = disropt.problems.LinearProblem(costs[agent.id][:, None] @ x, [rows.T @ x == np.ones((8, 1))])
        agent.set_problem(problem)
        return disropt.algorithms.DistributedSimplex(agent)

    algorithms = run_four(make, iterations=10)
    # 0 does 3, 1 does 1, 2 does 2, 3 does 0
    np.testing.assert_allclose([float(np.squeeze(one.J)) for one in algorithms], 5.0)


@needs_disropt
def test_gradient_tracking_and_admm_of_disropt():
    def problem(disropt, agent):
        x = disropt.functions.Variable(2)
        agent.set_problem(
            disropt.problems.Problem(
                disropt.functions.QuadraticForm(x, np.eye(2), -2.0 * agent.id * np.ones((2, 1))),
                [x >= -10.0 * np.ones((2, 1)), x <= 10.0 * np.ones((2, 1))],
            )
        )

    def tracking(disropt, agent):
        problem(disropt, agent)
        return disropt.algorithms.GradientTracking(agent, np.zeros((2, 1)))

    def admm(disropt, agent):
        problem(disropt, agent)
        zeros = {one: np.zeros((2, 1)) for one in [*agent.in_neighbors, agent.id]}
        return disropt.algorithms.ADMM(agent, zeros, np.zeros((2, 1)))

    for one in run_four(tracking, iterations=200, stepsize=0.1):
        np.testing.assert_allclose(one.get_result(), 1.5, atol=1e-3)
    for one in run_four(admm, iterations=50):
        np.testing.assert_allclose(one.get_result()[0], 1.5, atol=1e-2)


@needs_disropt
def test_a_silent_neighbor_ends_the_run_with_a_sentence():
    disropt = disropt_bridge.import_disropt()
    communicator = StaticCommunicator(0, 2, [1], transport=InProcessTransport())
    agent = disropt.agents.Agent([1], [1], disropt_bridge.adapted(communicator, timeout=0.05), [0.5, 0.5])
    with pytest.raises(StateError, match="agent 0: no message of agent 1 in time"):
        disropt.algorithms.Consensus(agent, np.zeros((1, 1))).run(iterations=1)


@needs_disropt
def test_weights_are_those_of_disropt():
    theirs = disropt_bridge.import_disropt().utils.graph_constructor
    for seed in range(5):
        for kind in ("undirected", "directed"):
            drawn = graphs.binomial_random_graph(5, 0.3, seed, kind)
            np.testing.assert_array_equal(drawn, theirs.binomial_random_graph(5, 0.3, seed, kind))
            for name in ("row_stochastic_matrix", "column_stochastic_matrix"):
                ours, others = getattr(graphs, name)(drawn), np.array(getattr(theirs, name)(drawn))
                # theirs leave the own weights to the agents
                np.testing.assert_allclose(ours * (1.0 - np.eye(5)), others * (1.0 - np.eye(5)), err_msg=name)
        np.testing.assert_allclose(
            graphs.metropolis_hastings(graphs.ring_graph(5)), theirs.metropolis_hastings(theirs.ring_graph(5))
        )
