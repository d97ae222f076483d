"""Guidance that optimizes: each scheme combines distributed optimization with guidance, one file each."""

from crazychoir_fw.schemes.mpc import MPCGuidance
from crazychoir_fw.schemes.mpc_problem import MPCProblem

__all__ = ["MPCGuidance", "MPCProblem"]
