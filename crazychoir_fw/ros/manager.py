"""`crazychoir fly MISSION.yaml --ros`: the processes of a mission, started, watched and ended.

The host process has the drones (simulation, integrator or radio), presses the buttons of `flight`, writes the log and
judges the flight, as the runner in one process does. The layers run in other processes, one per drone and layer or one
per drone, or all in the host.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError, MissionError, RangeError
from crazychoir_fw.common.signals import ignored_signals, unwind_at_signals
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.ros.parts import Part, parts_of
from crazychoir_fw.ros.process import NOT_MADE, run_part
from crazychoir_fw.ros.simulation import Pace
from crazychoir_fw.ros.supervise import Supervisor

PROCESSES = ("per-node", "per-drone", "one")
HOST = "host"

_BOOT_S = 180.0  # [s], wall: until all processes must have found each other
_LARGEST_DOMAIN = 101  # above, ports meet those that Linux hands out


@dataclass(frozen=True)
class RosOptions:
    """How a mission becomes processes."""

    processes: str = "per-node"
    """One of `PROCESSES`."""
    domain: int | None = None
    """ROS domain; None picks one that seems to be free."""
    speed: float | None = None
    """Simulated seconds per second; None is as fast as all can answer."""
    lockstep: bool = True
    """Whether simulated time waits for the answers of all nodes."""
    deadline: float = 2.0
    """Longest wait for an answer (s, wall)."""
    patience: float | None = None
    """Longest wait of a guidance for its neighbors while simulated time stands still (s, wall); None is
    `communication.silence_s` of the mission."""
    restart: bool = False
    """Whether processes that end are started again."""
    folder: Path | None = None
    """Folder of ``processes.json``, which maps names to process ids."""
    parts: tuple[Part, ...] = ()
    """All processes beside the host."""
    deaths: int | None = None
    """File descriptor of a pipe from which the host reads the names of ended processes."""


def free_domain() -> int:
    """Return a ROS domain that seems to be free on this machine."""
    chosen = random.SystemRandom()
    for _ in range(50):
        domain = chosen.randint(1, _LARGEST_DOMAIN)
        # the port at which participants of a domain listen to discovery
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))
            except OSError:
                continue
        return domain
    raise CrazychoirError("no free ROS domain found: give one with --domain")


def check(mission: Any, options: RosOptions) -> LayeredMission:
    """Check that a mission can fly as processes.

    Raises:
        MissionError: If the mission has no layers.
        RangeError: If an option is outside its range.
    """
    if not isinstance(mission, LayeredMission):
        raise MissionError(f"{mission.name}: --ros flies missions with the key layers, see docs/ros.md")
    if options.processes not in PROCESSES:
        raise RangeError(f"--processes is {options.processes}, allowed: {', '.join(PROCESSES)}")
    if options.domain is not None and not 0 <= options.domain <= 232:
        raise RangeError(f"--domain is {options.domain}, allowed: 0 to 232")
    return mission


def fly_as_processes(
    mission: LayeredMission,
    options: RosOptions,
    host: Callable[[RosOptions], int],
    quiet: bool = False,
) -> int:
    """Fly a mission as processes, to its end. Returns the exit code of the host.

    Args:
        mission: The mission.
        options: How.
        host: Flies it where the drones are, its layers by `hosting`; runs in a process of its own.
        quiet: Whether nothing is printed of the processes.

    Raises:
        MissionError: If a process cannot make the nodes of the mission.
    """
    domain = free_domain() if options.domain is None else options.domain
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    parts = parts_of(mission, options.processes)
    options = replace(options, domain=domain, parts=tuple(parts))
    lockstep = options.lockstep and mission.backend not in ("hardware", "mixed")
    options = replace(options, lockstep=lockstep)
    register = None if options.folder is None else options.folder / "processes.json"
    supervisor = Supervisor(quiet, register=register)
    flight = _Flight(supervisor, mission, options, parts)
    if not quiet:
        layers = f"{len(parts)} processes of layers and the host" if parts else "layers and host are one process"
        print(f"ROS domain {domain}: {layers}", flush=True)
    try:
        with unwind_at_signals():
            return flight.run(host)
    except (KeyboardInterrupt, SystemExit):
        print("Interrupted: all processes end", flush=True)
        return 130
    finally:
        with ignored_signals():
            supervisor.stop()


class _Flight:
    """The processes of one flight."""

    def __init__(
        self,
        supervisor: Supervisor,
        mission: LayeredMission,
        options: RosOptions,
        parts: list[Part],
    ) -> None:
        self._supervisor = supervisor
        self._mission = mission
        self._options = options
        self._parts = parts

    def run(self, host: Callable[[RosOptions], int]) -> int:
        reading, writing = os.pipe()
        options, supervisor = replace(self._options, deaths=reading), self._supervisor
        supervisor.start(HOST, partial(host, options), captured=False)
        for part in self._parts:
            work = partial(run_part, self._mission, part, options.lockstep, options.patience)
            supervisor.start(part.name, work)
        began = time.monotonic()
        while True:
            for child in supervisor.watch(1.0):
                if child.name == HOST:
                    return int(child.process.exitcode or 0)
                if child.process.exitcode == NOT_MADE and child.starts == 1:  # on a restart, others fly already
                    raise MissionError(f"{self._mission.name}: {child.name} cannot be made, see what it said")
                os.write(writing, f"{child.name}\n".encode())
                supervisor.say(
                    f"{child.name} ended {how(child.process.exitcode)} after {time.monotonic() - began:.1f} s"
                )
                if options.restart:
                    supervisor.restart(child.name)
                    supervisor.say(f"{child.name} started again")
            is_left = any(child.is_alive for child in supervisor.children.values() if child.name != HOST)
            if self._parts and not is_left:
                supervisor.say("no process of layers is left: the flight ends")
                return 1


def how(code: int | None) -> str:
    """Return how a process ended, in words."""
    if code is not None and code < 0:
        return f"by {signal.Signals(-code).name}"
    return f"with code {code}"


@contextmanager
def hosting(options: RosOptions) -> Iterator[Callable[..., Any]]:
    """Yield a function that makes the experiment of mission, backend and observer, its layers found and warmed up.

    Raises:
        CrazychoirError: If processes are not found before the timeout, or one has ended.
    """
    import rclpy
    from rclpy.context import Context
    from rclpy.signals import SignalHandlerOptions

    from crazychoir_fw.ros.hosting import HostedExperiment, names_from
    from crazychoir_fw.ros.one_process import OneProcessExperiment
    from crazychoir_fw.ros.process import make_executor, take_leave

    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    executor = make_executor(context)
    nodes: list[Any] = []
    pace = Pace(options.speed, options.lockstep, options.deadline, unattended=True)

    def look() -> None:
        """Raise if a process has ended; with `restart` only drain the pipe."""
        ended = [] if options.deaths is None else names_from(options.deaths)
        if ended and not options.restart:
            raise CrazychoirError(f"{ended[0]} has ended before the flight began, see what it said")

    kind = HostedExperiment if options.parts else OneProcessExperiment

    def make(flown: LayeredMission, backend: Any, observe: Any = None) -> HostedExperiment | OneProcessExperiment:
        experiment = kind(flown, backend, executor, pace, observe, context)
        nodes.append(experiment.node)
        experiment.tell_states()
        late = experiment.wait_for([part.name for part in options.parts], _BOOT_S, look)
        if late:
            raise CrazychoirError(
                f"{', '.join(late[:3])}{' and others' if len(late) > 3 else ''}: not found on ROS domain "
                f"{options.domain} within {_BOOT_S:g} s"
            )
        if isinstance(experiment, HostedExperiment):
            experiment.warm_up()
            if options.deaths is not None:
                experiment.watch_deaths(options.deaths, options.parts)
        return experiment

    try:
        yield make
    finally:
        take_leave(executor, nodes, context)
        sys.stdout.flush()
