"""Crazyflies without MuJoCo and firmware: a point with an attitude, integrated at 100 Hz, many at a time."""

from crazychoir_fw.simulation.integrator.disturbance import RandomForce
from crazychoir_fw.simulation.integrator.integrator import CrazyflieIntegrator
from crazychoir_fw.simulation.integrator.odometry import Odometry

__all__ = ["CrazyflieIntegrator", "Odometry", "RandomForce"]
