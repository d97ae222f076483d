"""Missions and logs to test with."""

from types import SimpleNamespace

import numpy as np
import pytest


@pytest.fixture
def make_log():
    """Return a log of drones that are exactly where *path(t)*, shape (N, 3), says, under a steady thrust."""

    def make(path, seconds, estimate_error=0.0, tracking_error=0.0, thrust=39000.0, landed_after=1e9):
        time = np.arange(0.0, seconds + 0.005, 0.01)
        true = np.stack([path(t) for t in time])
        signals = {}
        for axis, name in enumerate("xyz"):
            shift = [1.0, 0.0, 0.0][axis]
            signals[f"sim.{name}"] = true[:, :, axis]
            signals[f"stateEstimate.{name}"] = true[:, :, axis] + shift * estimate_error
            signals[f"ctrltarget.{name}"] = true[:, :, axis] - shift * tracking_error
        drones = true.shape[1]
        signals["stabilizer.thrust"] = np.full((len(time), drones), thrust)
        flies = np.where(time < landed_after, 0x0018, 0x0008).astype(np.uint16)
        signals["supervisor.info"] = np.repeat(flies[:, None], drones, axis=1)
        return SimpleNamespace(time=time, signals=signals, metadata={})

    return make
