"""What can be chosen for a handler."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import platformdirs

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.radio.agents import AgentId
from crazychoir_fw.radio.connection import ReconnectPolicy
from crazychoir_fw.radio.parameters import ParameterValue
from crazychoir_fw.radio.safety_area import SafetyArea

ON_SILENCE = ("hover", "level", "land", "stop", "repeat", "nothing")
ON_CLOSE = ("land", "stop", "leave")


def default_cache() -> Path:
    """Return the folder where tables of contents are kept for the next connection."""
    return Path(platformdirs.user_cache_dir("crazychoir_fw")) / "radio_tables"


@dataclass(frozen=True, kw_only=True)
class Options:
    """What can be chosen for a handler; its class has other defaults for some.

    Raises:
        RangeError: If a value is out of its range.
    """

    # ---------------------------------------------------------------- drone
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)
    """Parameters that are written after connecting, after the handler's own, by ``group.name``."""
    agent_parameters: Mapping[AgentId, Mapping[str, ParameterValue]] = field(default_factory=dict)
    """The same for single drones."""
    presets: bool = True
    """Whether the handler writes the parameters that its set-points need."""
    reset_estimator: bool = True
    """Whether handlers that need a position reset the Kalman filter after connecting, on the floor."""
    arms: bool = True
    """Whether a drone that must be armed is armed before it flies."""

    # ---------------------------------------------------------------- logs
    logger: bool = True
    """False logs nothing at all."""
    log: Mapping[str, float] | None = None
    """Rate (Hz, up to 100) by log variable; None takes roll, pitch and yaw at 5 Hz."""
    odometry_hz: float = 0.0
    """Rate of `Odometry` out of the drone's own estimate (Hz, up to 100); 0 is none."""

    # ---------------------------------------------------------------- external pose
    forwards_poses: bool = True
    """Whether `external_pose` sends anything; drones that position themselves do not need it."""
    pose_hz: float = 50.0
    """External poses per second and drone, at most."""

    # ---------------------------------------------------------------- set-points
    keep_alive_hz: float = 10.0
    """How often a set-point that is not replaced is repeated per second; the drone levels out after 0.5 s without."""
    max_rate_hz: float = 100.0
    """Set-points per second and drone at most; of more, the newest is taken."""
    command_timeout_s: float = 1.0
    """Max age of a set-point that is still repeated (s)."""
    on_silence: str = "hover"
    """What then happens: ``hover`` (zero velocity; needs a position on board), ``level`` (level attitude and a thrust a
    little below the weight for `level_s`, then motors off), ``land`` (by the planner on board), ``stop`` (motors off),
    ``repeat`` (the last command, without end), ``nothing`` (the drone levels out after 0.5 s, and locks after 2 s)."""
    level_s: float = 2.0
    """How long ``level`` lasts (s)."""

    # ---------------------------------------------------------------- safety
    safety_area: SafetyArea | None = None
    """The box that drones are kept in."""
    on_close: str = "land"
    """What `close` does with drones that fly: ``land`` (by the planner on board; a thrust drone whose position is not
    known sinks as for ``level``), ``stop`` (motors off) or ``leave``."""
    ready_timeout_s: float = 5.0
    """How long a drone may take to become ready to fly (s): boot, self-test, arming."""

    # ---------------------------------------------------------------- link
    answer_timeout_s: float = 5.0
    """How long a drone may be silent when it is called (s)."""
    connect_timeout_s: float = 60.0
    """How long connecting may take (s)."""
    confirm_timeout_s: float = 5.0
    """How long a drone may take to confirm a parameter or a log block (s)."""
    reconnect: ReconnectPolicy | None = field(default_factory=ReconnectPolicy)
    """What is done after a loss; None does nothing."""
    cache: Path | str | None = field(default_factory=default_cache)
    """Folder for tables of contents; None reads them from the drone each time."""

    # ---------------------------------------------------------------- time
    clock: Callable[[], float] = time.monotonic
    """Returns the time (s)."""
    threaded: bool = True
    """Whether a thread per drone sends; otherwise call `tick`, at least `keep_alive_hz` times per second."""

    def __post_init__(self) -> None:
        for name in ("pose_hz", "keep_alive_hz", "max_rate_hz", "command_timeout_s", "connect_timeout_s"):
            self._check(name, above=0.0)
        for name in ("answer_timeout_s", "confirm_timeout_s"):
            self._check(name, above=0.0)
        for name in ("odometry_hz", "level_s", "ready_timeout_s"):
            self._check(name)
        if self.odometry_hz > 100.0:
            raise RangeError(f"odometry_hz is {self.odometry_hz!r}, allowed: 0 to 100")
        if self.keep_alive_hz <= 2.0:
            raise RangeError(f"keep_alive_hz is {self.keep_alive_hz!r}, allowed: above 2, drones level out after 0.5 s")
        if self.on_silence not in ON_SILENCE:
            raise RangeError(f"on_silence is {self.on_silence!r}, allowed: {', '.join(ON_SILENCE)}")
        if self.on_close not in ON_CLOSE:
            raise RangeError(f"on_close is {self.on_close!r}, allowed: {', '.join(ON_CLOSE)}")

    def _check(self, name: str, above: float | None = None) -> None:
        value = getattr(self, name)
        is_number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        if not is_number or value < 0.0 or (above is not None and value <= above):
            raise RangeError(f"{name} is {value!r}, allowed: a number {'above' if above is not None else 'from'} 0")
