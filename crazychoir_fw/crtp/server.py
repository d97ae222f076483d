"""The server of a world: every drone on a UDP port of its own, for the unmodified cflib."""

from __future__ import annotations

import queue
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.crtp.client_session import SILENCE_S, ClientSession
from crazychoir_fw.crtp.drone_radio import DroneRadio
from crazychoir_fw.crtp.link_model import Link, PerfectLink
from crazychoir_fw.crtp.pacing import SLICE_S, Clock, TickPacer
from crazychoir_fw.crtp.radio_thread import Radio, report
from crazychoir_fw.crtp.server_statistics import Statistics
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services import Service
from crazychoir_fw.crtp.sockets import open_sockets
from crazychoir_fw.crtp.station import SERVICES, Station

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone
    from crazychoir_fw.simulation.world import World

HOST, PORT = "127.0.0.1", 19850
"""Where a scan of cflib looks first."""
_REST_MS = 200
"""A drone whose motors have not turned for so long (ms, simulated) does not fly, though its supervisor waits 2 s: the
next script may want to take off before."""

_SWITCH_S = 0.0005
"""So soon (s) simulation and radio hand the interpreter to each other. With the usual 5 ms, 30 drones that send 6000
log packets a second on a busy machine fell behind real time."""

Observer = Callable[["Server"], None]


class Server:
    """Serves the drones of a world; use it as a context manager, see `World.serve`.

    Either `run` drives the world at the pace of the clock on the wall, or the caller steps the world, in lockstep: then
    what clients asked for is carried out at the end of every tick, sessions and links go by simulated time, and between
    two calls of `World.step` clients are answered, but nothing of what they ask for happens. Packets that were sent
    before `World.step` act at the end of its first tick, every time.
    """

    def __init__(
        self,
        world: World,
        host: str = HOST,
        port: int = PORT,
        speed: float | None = 1.0,
        link: Link | None = None,
        *,
        newest_client_wins: bool = False,
        relax_after_session: bool = True,
        silence: float = SILENCE_S,
        storage: str | Path | None = None,
        reads_ahead: bool = True,
        services: Sequence[Callable[[ServiceContext], Service]] = SERVICES,
    ) -> None:
        """Get ready; no port is opened before `start`.

        Each drone has its own UDP port: `port`, the next one, and so on in the order of `World.drones`
        (``udp://127.0.0.1:19850``).

        Args:
            world: The world.
            host: Address of this machine to listen at; whatever client reaches it can fly the drones.
            port: Port of the first drone; 0 takes any free ones, see `uris`.
            speed: Simulated seconds per second in `run`; 0 or None is as fast as possible.
            link: What packets go through; by default nothing is late or lost.
            newest_client_wins: Whether a second client takes a drone from the first, instead of waiting for it.
            relax_after_session: Whether the high-level commander has a drone back when its client has gone.
            silence: Time (s) without a packet after which a client has gone.
            storage: Folder of the parameters that clients store on their drones; None keeps them for as long as the
                world lives.
            reads_ahead: Whether a client that downloads a table of contents is sent the next items unasked, and drones
                are read in turns, which halves the time that a swarm takes to connect; never through a link.
            services: What drones offer.

        Raises:
            RangeError: If a value is outside its range.
            StateError: If the world is flown from a journal.
        """
        if world.is_replay:
            raise StateError("a world that is flown from a journal cannot be served: its requests are known")
        if not 0.01 <= silence <= 3600.0:
            raise RangeError(f"silence is {silence!r}, allowed: 0.01 to 3600 s")
        self.world = world
        self.host = host
        self.port = port
        ticks_per_step = max(1, round(world.model.opt.timestep * TICKS_PER_SECOND))
        self._pace = TickPacer(speed, ticks_per_step)
        self._link = None if type(link) is PerfectLink else link
        self._newest_client_wins = newest_client_wins
        self._relax_after_session = relax_after_session
        self._silence_s = silence
        self._storage = storage
        # a link has its bandwidth, and loses things: there it is as with a vehicle
        self._reads_ahead = reads_ahead and self._link is None
        self._services = services
        self._radios: list[DroneRadio] = []
        self._radio: Radio | None = None
        self._errands: queue.SimpleQueue[None] = queue.SimpleQueue()  # may be put to from a signal handler
        self._has_errand = False
        self._is_asleep = False  # for longer than a change of a client shall wait
        self._is_running = self._is_paused = self._is_stopping = False
        self._world_time = world.time  # at the last stop
        self._clock = Clock(self._read_world_time)
        self._link_clock = Clock(self._read_world_time)
        self._leave_lockstep: Callable[[], None] = lambda: None
        self._reported: set[tuple[str, str]] = set()
        self._began = (0.0, 0.0)  # wall and processor time

    # ---------------------------------------------------------------- from start to end

    def __enter__(self) -> Server:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self) -> None:
        """Open the ports and answer.

        Raises:
            RangeError: If there are not so many ports, the host is none of this machine, or what drones have stored
                cannot be read.
            StateError: If a port is taken, or the server has been started.
        """
        if self._radio is not None:
            raise StateError("the server has been started already")
        drones = self.world.drones
        sockets = open_sockets(self.host, self.port, len(drones))
        self._radios = []
        for drone, opened in zip(drones, sockets, strict=True):
            station = Station(self.world, drone, services=self._services, storage=self._storage)
            station.context.wake_simulation = self._wake_if_it_sleeps
            station.context.reads_ahead = self._reads_ahead
            self._radios.append(
                DroneRadio(station, opened, ClientSession(self._silence_s, newest_wins=self._newest_client_wins))
            )
        self._radio = Radio(self._radios, self._link, self._clock, self._link_clock, self._silence_s)
        self._radio.when_a_session_ended = self._wake
        self._enter_lockstep()
        self.world.agenda.when_sought.append(self._jump)
        self._began = time.perf_counter(), time.process_time()
        self._radio.start()

    def close(self) -> None:
        """Close the ports; clients on the same machine notice at once."""
        self._is_stopping = True
        if self._radio is None:
            return
        self._leave_lockstep()
        if self._jump in self.world.agenda.when_sought:
            self.world.agenda.when_sought.remove(self._jump)
        self._radio.close()
        # what clients asked for last, and that they are gone
        self.carry_out()
        for radio in self._radios:
            radio.station.context.wake_simulation = lambda: None
            radio.station.close()
        self._radio = None

    @property
    def uris(self) -> dict[str, str]:
        """Where cflib finds every drone of a server that has been started, by its id."""
        host = "127.0.0.1" if self.host in ("", "0.0.0.0") else self.host
        return {radio.name: f"udp://{host}:{self._port_of(radio)}" for radio in self._radios}

    def _port_of(self, radio: DroneRadio) -> int:
        number = radio.socket.getsockname()[1] if radio.socket.fileno() >= 0 else 0
        return int(number)

    @property
    def speed(self) -> float | None:
        """Simulated seconds per second in `run`; None is as fast as possible."""
        return self._pace.speed

    @property
    def clients(self) -> int:
        """How many drones have a client now."""
        return sum(radio.is_open for radio in self._radios)

    # ---------------------------------------------------------------- real time

    def run(self, seconds: float | None = None, observe: Observer | None = None, every: float = 0.05) -> None:
        """Let the world go on in this thread, at `speed` times the pace of the clock on the wall.

        Args:
            seconds: Simulated time (s); None goes on until `stop`.
            observe: Called between two steps, to show something.
            every: How often (s, on the wall) that is.

        Raises:
            RangeError: If the time is negative.
            StateError: If the server has not been started, or runs in another thread.
        """
        if seconds is not None and not 0.0 <= seconds < 1e9:
            raise RangeError(f"run({seconds!r}): allowed: 0 s or more, or None")
        world, pace = self.world, self._pace
        end = None if seconds is None else world.tick + pace.whole_steps(seconds * TICKS_PER_SECOND)
        next_look = time.perf_counter()
        with self._driving():
            while not self._is_stopping:
                self.carry_out()
                now, tick = time.perf_counter(), world.tick
                if end is not None and tick >= end:
                    break
                if observe is not None and now >= next_look:
                    next_look = now + every
                    observe(self)
                    now = time.perf_counter()
                look_s = next_look - now if observe is not None else 1.0
                if self._is_paused:
                    self._wait(look_s)
                    pace.begin(time.perf_counter(), world.tick)
                elif ticks := pace.due(now, tick):
                    world.step(ticks if end is None else min(ticks, end - tick))
                    self._world_time = world.time
                else:
                    self._wait(min(look_s, pace.wait_s(now, tick)))

    @contextmanager
    def _driving(self) -> Iterator[None]:
        """Go by the clock on the wall meanwhile."""
        if self._radio is None:
            raise StateError("the server has not been started: use it in a with statement")
        if self._is_running:
            raise StateError("the server runs already")
        self._is_running = True
        self._leave_lockstep()
        self._clock.follow(time.perf_counter)
        self._let_link_follow()
        self._pace.begin(time.perf_counter(), self.world.tick)
        interval = sys.getswitchinterval()
        sys.setswitchinterval(min(interval, _SWITCH_S))
        try:
            yield
        finally:
            sys.setswitchinterval(interval)
            self._pace.end(time.perf_counter(), self.world.tick)
            self._is_running = False
            if not self._is_stopping:
                self._enter_lockstep()

    def _let_link_follow(self) -> None:
        """Let the link go by the wall while it can; a world that is as fast as possible has a time of its own."""
        radio = self._radio
        if radio is None:
            return
        radio.link_rate = self._pace.speed or 1.0
        self._link_clock.follow(time.perf_counter, radio.link_rate)
        radio.wake()

    def pause(self) -> None:
        """Let simulated time stand still in `run`; clients are answered, and what they ask for happens. Thread safe."""
        self._is_paused = True
        self._wake()

    def resume(self) -> None:
        """Let time go on. Thread safe."""
        self._is_paused = False
        self._wake()

    @property
    def is_paused(self) -> bool:
        """Whether `run` lets time stand still."""
        return self._is_paused

    def stop(self) -> None:
        """End `run`, now and in the future; also from a signal handler or another thread."""
        self._is_stopping = True
        self._wake()

    def _wake(self) -> None:
        if not self._has_errand:
            self._has_errand = True
            self._errands.put(None)

    def _wake_if_it_sleeps(self) -> None:
        # hundreds of set-points a second would wake it for each, and it is never late by more than a slice
        if self._is_asleep:
            self._wake()

    def _wait(self, seconds: float) -> None:
        """Wait until something is to be carried out, or the time is over."""
        self._is_asleep = seconds > SLICE_S
        try:
            # what came just before it fell asleep did not wake it
            if not (self._is_asleep and any(radio.station.context.has_changes for radio in self._radios)):
                self._errands.get(timeout=max(0.0, seconds))
        except queue.Empty:
            return
        finally:
            self._is_asleep = False
        # before looking what it is: what comes later wakes again
        self._has_errand = False

    # ---------------------------------------------------------------- lockstep

    def _enter_lockstep(self) -> None:
        self._world_time = self.world.time
        self._clock.follow(self._read_world_time)
        self._link_clock.follow(self._read_world_time)
        if self._radio is not None:
            self._radio.link_rate = 0.0
            self._radio.wake()  # in lockstep no question waits for a turn
        self._leave_lockstep = self.world.agenda.every(1, self._keep_lockstep)

    def _keep_lockstep(self) -> None:
        if self._radio is not None:
            self._radio.turn(self._look_at_world_time)
        self.carry_out()

    def _look_at_world_time(self) -> None:
        self._world_time = self.world.time

    def _read_world_time(self) -> float:
        return self._world_time

    def _jump(self, tick: int) -> None:
        """Go on from where the world was taken to."""
        self._world_time = tick / TICKS_PER_SECOND
        if self._is_running:
            self._pace.begin(time.perf_counter(), tick)
        else:
            self._clock.follow(self._read_world_time)
            self._link_clock.follow(self._read_world_time)

    def carry_out(self) -> None:
        """Do what clients have asked for, without a step; only the thread that steps the world calls this."""
        for radio in self._radios:
            owes_relax = radio.owes_relax
            while radio.station.context.has_changes:
                try:
                    radio.station.context.carry_out()
                    break
                except Exception as error:  # a defect of a service, and not the end of the flight
                    radio.counts.errors += 1
                    report(self._reported, radio.name, "what a client asked for was not done", error)
            if owes_relax:
                self._relax(radio)

    def _relax(self, radio: DroneRadio) -> None:
        """Let the high-level commander have a drone back whose client has gone, as soon as it does not fly.

        Every cflib session ends with a set-point of zeros, after which the firmware takes no high-level command until
        it gets the notification that set-points have ended (docs/reference/planner-commander.md#18).
        """
        drone = radio.station.context.drone
        if not self._relax_after_session:
            radio.owes_relax = False
        elif not drone.is_flying or _has_rested(drone):
            radio.owes_relax = False
            drone.uplink.dispatch("cf_notify_setpoint_stop")

    # ---------------------------------------------------------------- figures

    def statistics(self) -> Statistics:
        """Return how the server does; counters go on while you look at them."""
        pace = self._pace
        link_figures = getattr(self._link, "statistics", None)
        wall, processor = time.perf_counter() - self._began[0], time.process_time() - self._began[1]
        return Statistics(
            sim_seconds=pace.ticks / TICKS_PER_SECOND,
            wall_seconds=pace.wall_seconds,
            real_time_factor=pace.real_time_factor,
            recent_real_time_factor=pace.recent_real_time_factor,
            worst_lag_s=pace.worst_lag_s,
            dropped_lag_s=pace.dropped_lag_s,
            resyncs=pace.resyncs,
            cpu_share=processor / wall if wall > 0.0 else 0.0,
            drones={radio.name: radio.counts for radio in self._radios},
            link=link_figures() if link_figures is not None else {},
        )


def _has_rested(drone: Drone) -> bool:
    """Tell whether no motor has turned faster than idle lately."""
    onboard = drone.struct.onboard
    return int(onboard.tick) - int(onboard.supervisor.thrust_tick) > _REST_MS
