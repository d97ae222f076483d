"""Time as the drones count it."""

TICKS_PER_SECOND = 1000
"""Ticks of vehicle and onboard software in a simulated second."""
