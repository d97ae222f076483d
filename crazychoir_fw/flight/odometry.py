"""Poses as a motion-capture system would tell them, with velocities out of a filter."""

from __future__ import annotations

from collections.abc import Callable

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator, MocapConfig, SimulatedMocap


def through_mocap(truth: Callable[[], Pose], seed: int, config: MocapConfig | None = None) -> Callable[[], Pose]:
    """Return what reads the poses of all drones as seen by a simulated motion-capture system.

    Args:
        truth: Reads the true poses, arrays of shape (N, ...).
        seed: Seed of noise and losses.
        config: How well the system sees; None has the numbers of the vehicle model.
    """
    system, estimator = SimulatedMocap(config, seed=seed), Estimator()
    latest: list[Pose] = []

    def read() -> Pose:
        true = truth()
        now = float(true.time)  # type: ignore[arg-type]
        if latest and latest[0].time == now:
            return latest[0]
        for sample in system.step(now, true):
            estimator.update(sample)
        seen = estimator.estimate
        if seen.position is None:
            seen = true  # before the first frame has arrived
        latest[:] = [Pose(seen.position, seen.orientation, seen.velocity, seen.angular, now)]
        return latest[0]

    return read
