"""What tells real drones where they are, as motion capture sees them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap.sources import PoseSource

_LOOK_EVERY = 0.005  # [s]


class PoseForwarder:
    """A thread that hands new poses on, also while other threads wait for drones to get ready."""

    def __init__(self, source: PoseSource, receivers: Mapping[str, Callable[[Any, Any], object]]) -> None:
        """Begin.

        Args:
            source: Where poses come from.
            receivers: By name of the body, what takes its position (3,) (m) and quaternion x, y, z, w (4,).
        """
        self._source, self._receivers = source, dict(receivers)
        self._handed_on: dict[str, Pose] = {}
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="motion capture to drones", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ends.wait(_LOOK_EVERY):
            self.forward()

    def forward(self) -> None:
        """Hand on what is new."""
        for name, pose in self._source.latest().items():
            if name in self._receivers and self._handed_on.get(name) is not pose:
                self._handed_on[name] = pose
                self._receivers[name](pose.position, pose.orientation)

    def close(self) -> None:
        """End; the source is left open."""
        self._ends.set()
        self._thread.join()
