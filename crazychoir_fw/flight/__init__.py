"""Missions are flown, in one process, by drones that are simulated, integrated or real."""

from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.backend import Backend
from crazychoir_fw.flight.control_group import ControlGroup
from crazychoir_fw.flight.experiment import Experiment

__all__ = [
    "Agent",
    "Backend",
    "ControlGroup",
    "DronePhase",
    "Experiment",
    "FlightResult",
    "HardwareBackend",
    "IntegratorBackend",
    "SimBackend",
    "fly",
    "make_experiment",
]

_LATER = {
    "FlightResult": "flight_result",
    "HardwareBackend": "hardware_backend",
    "IntegratorBackend": "integrator_backend",
    "SimBackend": "sim_backend",
    "fly": "engine",
    "make_experiment": "engine",
}


def __getattr__(name: str) -> object:
    """Import a backend or the engine when it is asked for: each brings much that the others do not need."""
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
