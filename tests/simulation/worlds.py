"""Worlds for the tests of the simulation."""

from crazychoir_fw.simulation import DroneConfig, World


def make_world(count=1, **options):
    """Return a world with drones half a meter apart."""
    places = [(0.5 * i, 0.0) for i in range(count)]
    return World([DroneConfig(f"cf{i + 1}", place) for i, place in enumerate(places)], **options)
