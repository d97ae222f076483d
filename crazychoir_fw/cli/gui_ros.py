"""`crazychoir gui MISSION.yaml --ros` and `--ros-join`: the page of a flight whose processes talk over ROS 2."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crazychoir_fw.common.errors import CrazychoirError

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.ros.manager import RosOptions


@dataclass(frozen=True)
class OverRos:
    """How the page takes part in a flight over ROS 2."""

    joins: bool
    """Whether another host has started the flight."""
    processes: str = "per-node"
    domain: int | None = None
    speed: float = 1.0
    restart: bool = False


def show_over_ros(mission: LayeredMission, how: OverRos, show: Callable[[Session], None]) -> int:
    """Show the page of a flight over ROS 2 until it is closed; returns the exit code.

    Args:
        mission: The mission.
        how: Whether processes are started, and how.
        show: Serves the page of a session until it is closed.

    Raises:
        CrazychoirError: If rclpy is missing, or the mission cannot be flown so.
    """
    try:
        from crazychoir_fw.ros.manager import RosOptions, check, fly_as_processes
    except ImportError as error:
        raise CrazychoirError(f"--ros: {error}") from None
    # the session of the page paces simulated time; real time goes on by itself
    options = RosOptions(how.processes, how.domain, restart=how.restart, folder=Path("out") / mission.name)
    mission = check(mission, options)
    if how.joins:
        from crazychoir_fw.gui.session import Session
        from crazychoir_fw.ros.joined_flight import JOIN_S, join

        session = Session(mission, make=lambda flown: join(flown, how.domain, JOIN_S, lambda: session.is_closing))
        show(session)
        return 0
    options.folder.mkdir(parents=True, exist_ok=True)  # type: ignore[union-attr]
    return fly_as_processes(mission, options, partial(_host, mission, how.speed, show))


def _host(mission: LayeredMission, speed: float, show: Callable[[Session], None], options: RosOptions) -> int:
    """Be the process that has the drones, and show the page of their flight."""
    from crazychoir_fw.cli.console import BAD_INPUT, complain_of
    from crazychoir_fw.flight.backends import make_backend
    from crazychoir_fw.gui.session import Session
    from crazychoir_fw.ros.manager import hosting

    def make(flown: LayeredMission) -> Any:
        backend = make_backend(flown)
        try:
            return make_flight(flown, backend)
        except BaseException:
            backend.close()
            raise

    try:
        with hosting(options) as make_flight:
            show(Session(mission, speed, make))
    except CrazychoirError as error:
        complain_of(error)
        return BAD_INPUT
    return 0
