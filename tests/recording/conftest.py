"""Flights to report on."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

import mujoco
import numpy as np
import pytest

from crazychoir_fw.mujoco_models import model_path
from crazychoir_fw.mujoco_models.stamp import VehicleStamp
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.opengl import RenderingError, rendering_available


@pytest.fixture
def drawing() -> AbstractContextManager:
    """Where there is no OpenGL, drawing must raise `RenderingError`; elsewhere it must not."""
    return nullcontext() if rendering_available() is None else pytest.raises(RenderingError, match="no rendering")


@pytest.fixture
def two_drones() -> mujoco.MjModel:
    """A world with a red and a blue drone, 0.5 m apart."""
    spec = mujoco.MjSpec.from_file(str(model_path("arena")))
    spec.visual.quality.shadowsize = 256
    spec.visual.quality.offsamples = 0
    stamp = VehicleStamp(spec, "cf2")
    stamp.place("red", (0.25, 0.0, 1.0), rgba=(1.0, 0.0, 0.0, 1.0))
    stamp.place("blue", (-0.25, 0.0, 1.0), rgba=(0.0, 0.0, 1.0, 1.0))
    return spec.compile()


def _make_log(drones: int, samples: int = 300) -> FlightLog:
    """Return a flight on circles with everything that a plot can show."""
    time = np.linspace(0.0, 10.0, samples)
    phase = np.arange(drones)
    angle = time[:, None] * 0.8 + phase
    path = {"x": np.cos(angle) + phase, "y": np.sin(angle), "z": 1.0 + 0.05 * phase + 0.0 * angle}
    signals = {f"sim.{axis}": values for axis, values in path.items()}
    signals |= {f"ctrltarget.{axis}": (values + 0.05).astype(np.float32) for axis, values in path.items()}
    signals |= {f"motor.m{k}": np.full((samples, drones), 30000 + 1000 * k, dtype=np.uint16) for k in range(1, 5)}
    metadata = {"mission": "circles", "provider": "builtin", "version": "0.1.0", "seed": 3}
    return FlightLog(time, [f"cf{k}" for k in range(drones)], signals, metadata)


@pytest.fixture
def make_log() -> Callable[..., FlightLog]:
    """Build a flight log: `make_log(drones, samples=300)`."""
    return _make_log
