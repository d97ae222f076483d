"""`crazychoir gui MISSION.yaml --ros` and `--ros-join`: the page of a flight whose processes talk over ROS 2."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import CrazychoirError, RangeError

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session
    from crazychoir_fw.mission.schema import LayeredMission

_BOOT_S = 200.0  # [s], wall: the host itself gives up sooner


@dataclass(frozen=True)
class OverRos:
    """How the page takes part in a flight over ROS 2."""

    joins: bool
    """Whether somebody else has started the flight."""
    processes: str = "per-node"
    domain: int | None = None
    speed: float = 1.0
    restart: bool = False


def show_over_ros(mission: LayeredMission, how: OverRos, show: Callable[[Session], None]) -> int:
    """Show the page of a flight over ROS 2 until it is closed; returns the exit code.

    Args:
        mission: The mission.
        how: Whether processes are started, and how.
        show: Serves the page of a session until somebody closes it.

    Raises:
        CrazychoirError: If rclpy is missing, or the mission cannot be flown so.
    """
    try:
        from crazychoir_fw.ros.manager import RosOptions, check
    except ImportError as error:
        raise CrazychoirError(f"--ros: {error}") from None
    if not how.speed > 0.0:
        raise RangeError(f"--speed is {how.speed:g}, allowed with --ros: more than 0, since nobody can pause it")
    speed = None if mission.backend in ("hardware", "mixed") else how.speed
    options = RosOptions(how.processes, how.domain, speed, restart=how.restart, folder=Path("out") / mission.name)
    mission = check(mission, options)
    if how.joins:
        _show_joined(mission, how.domain, None, show)
        return 0
    from crazychoir_fw.ros.open_flight import open_as_processes

    options.folder.mkdir(parents=True, exist_ok=True)  # type: ignore[union-attr]
    return open_as_processes(mission, options, partial(_page, mission, show))


def _page(mission: LayeredMission, show: Callable[[Session], None], options: Any) -> int:
    """Be the process of the page."""
    from crazychoir_fw.cli.console import BAD_INPUT, complain_of

    try:
        _show_joined(mission, options.domain, _BOOT_S, show)
    except CrazychoirError as error:
        complain_of(error)
        return BAD_INPUT
    return 0


def _show_joined(
    mission: LayeredMission, domain: int | None, patience: float | None, show: Callable[[Session], None]
) -> None:
    from crazychoir_fw.gui.session import Session
    from crazychoir_fw.ros.page import JOIN_S, join

    wait = JOIN_S if patience is None else patience

    def make(flown: LayeredMission) -> Any:
        return join(flown, domain, wait, lambda: session.is_closing)

    session = Session(mission, make=make)
    show(session)
