"""Where poses of real bodies come from: motion-capture systems, or datagrams of UDP."""

from __future__ import annotations

import importlib
import json
import math
import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from crazychoir_fw.common.errors import MissingLibraryError, StateError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.common.user_code import installed

GROUP = "crazychoir.pose_sources"
"""Entry points by which installed packages offer sources of poses."""

LOOPBACK = "127.0.0.1"

_MAX_DATAGRAMS = 1000  # read at once: a flood must not hold up a round
_LARGEST_DATAGRAM = 65_507
_FARTHEST = 1e4  # [m], no motion capture is that large


class PoseSource(Protocol):
    """Tells where bodies are that it sees."""

    def latest(self) -> dict[str, Pose]:
        """Return the newest pose of each body that was ever seen, without waiting.

        Poses have position, maybe orientation, and the time of their arrival (s), by the clock of the source.
        """

    def close(self) -> None:
        """Stop looking for poses."""


def installed_source(name: str) -> Callable[[Sequence[Any]], PoseSource]:
    """Return a source of poses that an installed package offers as an entry point of group `GROUP`.

    Args:
        name: Of the entry point. Ours is ``ros``: poses of topics.

    Returns:
        What makes the source of a list of bodies.

    Raises:
        MissingLibraryError: If no package offers it, or what it needs is not installed.
    """
    return installed(GROUP, name, f"poses of '{name}'")


class UdpPoses:
    """Poses as JSON in UDP datagrams, such as ``{"cf1": [1.0, 0.0, 0.5]}``.

    A datagram is an object from names to three numbers, x, y, z (m, world), or seven, with the quaternion x, y, z, w.
    What is none is counted and left out.
    """

    def __init__(self, port: int, host: str = LOOPBACK, clock: Callable[[], float] = time.monotonic) -> None:
        """Listen.

        Args:
            port: UDP port; 0 takes a free one.
            host: Address to listen on.
            clock: Time of arrival (s).

        Raises:
            StateError: If the port is taken.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise StateError(f"poses by UDP: cannot listen on {host}:{port}: {error.strerror}") from None
        self._socket.setblocking(False)
        self._clock = clock
        self._lock = threading.Lock()
        self._latest: dict[str, Pose] = {}
        self.refused = 0
        """Datagrams and bodies that were no poses."""

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._socket.getsockname()[1])

    def latest(self) -> dict[str, Pose]:
        """See `PoseSource`."""
        with self._lock:
            for _ in range(_MAX_DATAGRAMS):
                try:
                    data = self._socket.recv(_LARGEST_DATAGRAM)
                except OSError:  # nothing there, or what the network says about packets before
                    break
                self._take(data)
            return dict(self._latest)

    def _take(self, data: bytes) -> None:
        try:
            bodies = json.loads(data)
        except (ValueError, RecursionError):
            bodies = None
        if not isinstance(bodies, dict):
            self.refused += 1
            return
        for name, numbers in bodies.items():
            pose = _pose(numbers, self._clock())
            if pose is None:
                self.refused += 1
            else:
                self._latest[name] = pose

    def close(self) -> None:
        """See `PoseSource`."""
        self._socket.close()


class MotionCapture:
    """Poses of Vicon, OptiTrack, Qualisys, NOKOV or VRPN, by the package ``motioncapture`` (extra ``mocap``)."""

    def __init__(self, system: str, host: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Connect.

        Args:
            system: As that package calls it, such as ``vicon`` or ``optitrack``.
            host: Computer of the motion-capture system.
            clock: Time of arrival (s).

        Raises:
            MissingLibraryError: If the package is not there.
            StateError: If the system is not.
        """
        try:
            package = importlib.import_module("motioncapture")
        except ImportError:
            raise MissingLibraryError(
                "motion capture needs motioncapture: run pip install 'crazychoir-fw[mocap]'"
            ) from None
        try:
            self._system: Any = package.connect(system, {"hostname": host})
        except Exception as error:  # what a driver raises is its own affair
            raise StateError(f"motion capture {system} at {host}: {error}") from None
        self._clock = clock
        self._latest: dict[str, Pose] = {}
        self._lock = threading.Lock()
        self._ends = threading.Event()
        self.failure: str | None = None
        """Why no more frames arrive."""
        threading.Thread(target=self._listen, name="motion capture", daemon=True).start()

    def _listen(self) -> None:
        while not self._ends.is_set():
            try:
                self._system.waitForNextFrame()
                bodies = dict(self._system.rigidBodies)
            except Exception as error:
                self.failure = f"motion capture: {error}"
                return
            now = self._clock()
            for name, body in bodies.items():
                turn = body.rotation
                pose = _pose([*map(float, body.position), turn.x, turn.y, turn.z, turn.w], now)
                if pose is not None:
                    with self._lock:
                        self._latest[name] = pose

    def latest(self) -> dict[str, Pose]:
        """See `PoseSource`."""
        with self._lock:
            return dict(self._latest)

    def close(self) -> None:
        """See `PoseSource`."""
        self._ends.set()


def _pose(numbers: Any, now: float) -> Pose | None:
    """Return the pose of three or seven numbers; None for what is none, such as the zeros of an occluded body."""
    if not isinstance(numbers, list) or len(numbers) not in (3, 7):
        return None
    if not all(isinstance(one, int | float) and not isinstance(one, bool) for one in numbers):
        return None
    try:
        values = [float(one) for one in numbers]
    except OverflowError:
        return None
    if not all(math.isfinite(one) and abs(one) < _FARTHEST for one in values):
        return None
    turn = np.array(values[3:] or (0.0, 0.0, 0.0, 1.0))
    length = float(np.linalg.norm(turn))
    if not 0.8 <= length <= 1.25:  # docs/reference/crazychoir.md#10
        return None
    return Pose(position=np.array(values[:3]), orientation=turn / length, time=now)
