"""A mission as processes that wait for buttons, and a page among them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.ros.manager import RosOptions, fly_as_processes, hosting

PAGE = "page"


def open_as_processes(mission: LayeredMission, options: RosOptions, page: Callable[[RosOptions], int]) -> int:
    """Start the processes of a mission, as `fly_as_processes` does, but nothing flies until somebody presses a button.

    Args:
        mission: The mission; its `flight` is not flown.
        options: How it becomes processes.
        page: What shows the flight, in a process of its own; when it returns, all processes end.

    Returns:
        The exit code of whichever of page and host ended first.
    """
    return fly_as_processes(mission, options, lambda ready: _host(mission, ready), watchers={PAGE: page})


def _host(mission: LayeredMission, options: RosOptions) -> int:
    """Be the process that has the drones, until it is interrupted."""
    from crazychoir_fw.flight.backends import make_backend

    try:
        backend = make_backend(mission)
        # the log of a flight that has no end would fill the memory
        backend.record = _forget  # type: ignore[method-assign]
        try:
            with hosting(options) as make:
                experiment = make(mission, backend)
                while True:
                    experiment.step()
        finally:
            backend.close()
    except CrazychoirError as error:
        print(f"host: {error}", flush=True)
        return 1


def _forget(extra: Any) -> None:
    del extra
