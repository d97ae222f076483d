"""Curves as pure values, and how they are found."""

from crazychoir_fw.planning.curves.cubic_spline import cubic_spline
from crazychoir_fw.planning.curves.minimum_snap import minimum_snap
from crazychoir_fw.planning.curves.point_to_point import point_to_point, septic, through_states
from crazychoir_fw.planning.curves.polynomial import Polynomial
from crazychoir_fw.planning.curves.state import State

__all__ = ["Polynomial", "State", "cubic_spline", "minimum_snap", "point_to_point", "septic", "through_states"]
