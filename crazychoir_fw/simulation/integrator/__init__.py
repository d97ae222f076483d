"""Crazyflies without MuJoCo and firmware: a point with an attitude, integrated at 100 Hz, many at a time."""

from crazychoir_fw.simulation.integrator.integrator import CrazyflieIntegrator
from crazychoir_fw.simulation.integrator.stepping import Odometry, RandomForce

__all__ = ["CrazyflieIntegrator", "Odometry", "RandomForce"]
