"""Distributed optimization: agents that find a common optimum by talking to their neighbors.

Algorithms need a communicator of `crazychoir_fw.guidance` and nothing else of it. Matrices of graphs and weights are
in `crazychoir_fw.guidance.optimization.graphs`, DISROPT's own objects run with
`crazychoir_fw.guidance.optimization.disropt_bridge`.
"""

from crazychoir_fw.guidance.optimization.admm import ADMM
from crazychoir_fw.guidance.optimization.agent import Agent
from crazychoir_fw.guidance.optimization.aggregative_tracking import (
    AggregativeProblem,
    AggregativeTracking,
    RobustAggregativeTracking,
)
from crazychoir_fw.guidance.optimization.algorithm import Algorithm
from crazychoir_fw.guidance.optimization.assignment import assigned_task, assignment_problem, assignments
from crazychoir_fw.guidance.optimization.consensus import Consensus
from crazychoir_fw.guidance.optimization.constraints_consensus import ConstraintsConsensus
from crazychoir_fw.guidance.optimization.directed_gradient_tracking import DirectedGradientTracking
from crazychoir_fw.guidance.optimization.distributed_simplex import DistributedSimplex, LinearProblem
from crazychoir_fw.guidance.optimization.dual_decomposition import DualDecomposition
from crazychoir_fw.guidance.optimization.gradient_tracking import GradientTracking
from crazychoir_fw.guidance.optimization.lexicographic import UnboundedError
from crazychoir_fw.guidance.optimization.max_consensus import MaxConsensus
from crazychoir_fw.guidance.optimization.push_sum_consensus import PushSumConsensus
from crazychoir_fw.guidance.optimization.quadratic import InfeasibleError, QuadraticProblem
from crazychoir_fw.guidance.optimization.resilient_aggregative_tracking import ResilientAggregativeTracking
from crazychoir_fw.guidance.optimization.rounds import run_together
from crazychoir_fw.guidance.optimization.surveillance import SurveillanceProblem

__all__ = [
    "ADMM",
    "Agent",
    "AggregativeProblem",
    "AggregativeTracking",
    "Algorithm",
    "Consensus",
    "ConstraintsConsensus",
    "DirectedGradientTracking",
    "DistributedSimplex",
    "DualDecomposition",
    "GradientTracking",
    "InfeasibleError",
    "LinearProblem",
    "MaxConsensus",
    "PushSumConsensus",
    "QuadraticProblem",
    "ResilientAggregativeTracking",
    "RobustAggregativeTracking",
    "SurveillanceProblem",
    "UnboundedError",
    "assigned_task",
    "assignment_problem",
    "assignments",
    "run_together",
]
