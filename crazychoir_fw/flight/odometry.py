"""Poses as a motion-capture system would tell them, with velocities out of a filter."""

from __future__ import annotations

from collections.abc import Callable

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator, MocapConfig, SimulatedMocap


class MocapPoses:
    """Reads the poses of all drones as seen by a simulated motion-capture system."""

    def __init__(self, truth: Callable[[], Pose], seed: int, config: MocapConfig | None = None) -> None:
        """Look at drones.

        Args:
            truth: Reads the true poses, arrays of shape (N, ...).
            seed: Seed of noise and losses.
            config: How well the system sees; None has the numbers of the vehicle model.
        """
        self._truth = truth
        self._system, self._estimator = SimulatedMocap(config, seed=seed), Estimator()
        self._latest: Pose | None = None

    def __call__(self) -> Pose:
        """Return the poses that are known now."""
        true = self._truth()
        now = float(true.time)  # type: ignore[arg-type]
        if self._latest is None or self._latest.time != now:
            for sample in self._system.step(now, true):
                self._estimator.update(sample)
            seen = self._estimator.estimate
            if seen.position is None:
                seen = true  # before the first frame has arrived
            self._latest = Pose(seen.position, seen.orientation, seen.velocity, seen.angular, now)
        return self._latest
