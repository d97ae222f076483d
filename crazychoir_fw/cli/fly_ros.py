"""`crazychoir fly MISSION.yaml --ros`: the mission as ROS 2 processes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from crazychoir_fw.cli.attempt import FlightRequest, attempt
from crazychoir_fw.cli.console import BAD_INPUT, complain, complain_of


def fly_as_nodes(request: FlightRequest, processes: str, domain: int | None, pace: float | None, restart: bool) -> int:
    """Fly a mission as processes; returns the exit code.

    Args:
        request: What to fly, as without ROS.
        processes: ``per-node``, ``per-drone`` or ``one``.
        domain: ROS domain; None takes a free one.
        pace: Simulated seconds per second; None is lockstep.
        restart: Whether processes that end are started again.
    """
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.mission.loader import load_mission

    try:
        from crazychoir_fw.ros.manager import RosOptions, check, fly_as_processes, hosting
    except ImportError as error:
        complain(f"--ros: {error}")
        return BAD_INPUT
    try:
        options = RosOptions(processes, domain, pace, lockstep=pace is None, restart=restart)
        mission = check(load_mission(request.mission, request.uri_base, **request.overrides), options)
        folder = request.out if request.out is not None else Path("out") / mission.name
        folder.mkdir(parents=True, exist_ok=True)
        options = replace(options, folder=folder)
        return fly_as_processes(
            mission, options, lambda ready: attempt(replace(request, hosting=partial(hosting, ready)))
        )
    except CrazychoirError as error:
        complain_of(error)
        return BAD_INPUT
