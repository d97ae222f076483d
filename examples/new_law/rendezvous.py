"""Drones meet: a guidance law of your own, in one file. See docs/guidance.md#a-law-of-your-own."""

import numpy as np

from crazychoir_fw.guidance import CFDistributedFeedback, Metrics, Needs, criterion, option
from crazychoir_fw.recording.marks import Mark


class Meeting(Metrics):
    """How near the drones are to their middle."""

    curve_label, curve_limit = "distance from the middle (m)", "meeting_m"

    def errors(self, flown):
        """Return the distances over time (m), shape (T, N): the picture shows their mean and the largest."""
        away = np.linalg.norm(flown.at - flown.at.mean(axis=1, keepdims=True), axis=2)
        return np.where(flown.up, away, np.nan)

    @criterion("the middle of all", "m")
    def meeting_m(self, flown):
        """Return the distance of each drone at the end (m), shape (N,)."""
        return self.errors(flown)[flown.final].mean(axis=0)

    def marks(self, end):
        """Mark the middle at the end."""
        return [] if end is None else [Mark(end.mean(axis=0), kind="target")]


class Rendezvous(CFDistributedFeedback):
    """Each drone is pulled to its neighbors, down to a distance, and keeps the height of its take-off."""

    needs = Needs(graph=True)
    metrics = Meeting

    gap = option(0.5, "distance that neighbors keep", "m", above=0)
    pull = option(0.8, "acceleration per distance", "1/s^2", low=0, high=10)
    brake = option(2.5, "acceleration per speed", "1/s", low=0, high=10)

    def evaluate_input(self, neigh_data):
        """Return the acceleration (m/s^2, world), shape (3,)."""
        own = self.current_pose
        u = -self.brake * own.velocity
        u[2] -= 4.0 * (own.position[2] - self.height)
        for pose in neigh_data.values():
            offset = pose.position - own.position
            distance = max(np.hypot(*offset[:2]), 1e-3)
            u[:2] += self.pull * (1.0 - self.gap / distance) * offset[:2]
        return u
