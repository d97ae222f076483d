"""`Session`: one flight in a thread of its own. Browsers come and go, and the flight goes on.

Everything that touches the flight happens in that thread, between two rounds: commands wait in a queue for it. What
browsers are shown are copies that it lays out.
"""

from __future__ import annotations

import queue
import threading
import time as wall
from collections import OrderedDict, deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.checkpoint import Checkpoint
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.common.user_code import USER_ERRORS
from crazychoir_fw.flight.access import Access, open_access
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.agents import graph_of
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.gui.branches import Branches, Moment, Sample, SampleStream
from crazychoir_fw.gui.feed import FRAME_S, PHASES, Feed, Frame
from crazychoir_fw.gui.room import Room

if TYPE_CHECKING:
    from crazychoir_fw.flight.experiment import Experiment
    from crazychoir_fw.flight.start_transit import StartTransit
    from crazychoir_fw.gui.flying import Flying
    from crazychoir_fw.gui.mission_run import MissionRun
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.preflight.check import Check

Array = NDArray[np.float64]

SAMPLE_S = 0.1
"""Between two samples of the past (s, of the flight)."""
MOMENT_S = 0.5
"""Least time between two moments to go back to (s, of the flight)."""
MOMENT_SHARE = 0.02
"""Part of the time that moments may take."""
_MAX_COMMANDS = 10_000  # whose answers are kept
_BEHIND_S = 0.2  # a flight that is later than this does not try to catch up
_WAIT_S = 0.05
_STILL_S = 0.5  # between two frames of a pause, unless something is asked for
_TOLD = ("takeoff", "start", "land", "stop")  # by the command that asked for it


class Session(Feed):
    """A flight that waits for commands."""

    def __init__(
        self,
        mission: LayeredMission,
        speed: float = 1.0,
        make: Callable[[LayeredMission], Experiment] = make_experiment,
        tested: Check | None = None,
    ) -> None:
        """Prepare; `open` begins.

        Args:
            mission: What flies.
            speed: Simulated seconds per second at first; 0 is a pause.
            make: Makes the flight, in its thread.
            tested: What a campaign says of the mission, for drones over the radio.
        """
        super().__init__([drone.id for drone in mission.fleet])
        self.mission = mission
        self.graph = [(int(i), int(j)) for i, j in graph_of(mission).pairs]
        self.speed = speed
        self.error: str | None = None
        """Why there is no flight, or no longer, a sentence."""
        self.is_ready = False
        self.experiment: Experiment | None = None
        self.access: Access | None = None
        self.branches = Branches()
        self.stream: SampleStream | None = None
        """Where the flight is written while it flies."""
        self.flying: Flying | StartTransit | MissionRun | None = None
        self.dry_share: float | None = None
        """Which share of a dry run is flown, 0 to 1, while there is one."""
        self.room = Room(None)
        """What stands around the drones."""
        self.no_rewind: str | None = None
        """Why the flight cannot be rewound, a sentence."""
        self.tested = tested
        self.radio_checks: list[Check] | None = None
        """What was found at drones over the radio, once they were looked at."""
        self._make = make
        self._queue: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._answers: OrderedDict[str, Future[Any]] = OrderedDict()
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._seen_happenings = 0
        self._next_frame = self._next_sample = self._next_moment = self._next_plot = -np.inf
        self._remembered = -np.inf
        self._due: float | None = None
        self._pace: deque[tuple[float, float]] = deque(maxlen=30)
        self._console: dict[int, str] = {}
        self._shown = 0

    # ---------------------------------------------------------------- for all threads

    def open(self) -> Session:
        """Begin the flight in its thread; drones of a simulation need a moment until they are ready."""
        self._thread = threading.Thread(target=self._run, name="flight", daemon=True)
        self._thread.start()
        return self

    def close(self) -> None:
        """End the flight, and release the drones."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join(timeout=20.0)

    @property
    def is_closing(self) -> bool:
        """Whether `close` was called."""
        return self._closing.is_set()

    def __enter__(self) -> Session:
        return self.open()

    def __exit__(self, *exc: object) -> None:
        self.close()

    def wait_until_ready(self, timeout_s: float = 60.0) -> None:
        """Wait until the drones are ready.

        Raises:
            StateError: If they are not in time, or cannot be.
        """
        end = wall.monotonic() + timeout_s
        while not self.is_ready:
            if self.error is not None:
                raise StateError(self.error)
            if wall.monotonic() > end:
                raise StateError(f"the drones were not ready within {timeout_s:g} s")
            wall.sleep(0.01)

    def call_roll(self, drones: Sequence[int], settle_s: float | None = None) -> None:
        """Check drones over the radio as `crazychoir fly` does; those that flew already may stand anywhere.

        Args:
            drones: Numbers of those whose motors shall turn.
            settle_s: How long estimators may take to know where they are (s), if not as long as there.

        Raises:
            StateError: With what is wrong, a sentence.
        """
        check = getattr(self.experiment.backend, "before_flight", None)
        if check is not None:
            agents = [self.experiment.agents[i] for i in drones]
            placed = [agent.index for agent in agents if agent.phase is DronePhase.GROUND and not agent.has_flown]
            check(drones=drones, placed=placed, **({} if settle_s is None else {"settle_s": settle_s}))

    def ask(self, action: Callable[[], Any]) -> Future[Any]:
        """Have something done between two rounds; returns what will hold the answer."""
        future: Future[Any] = Future()
        if self.error is not None or self._closing.is_set():
            future.set_exception(StateError(self.error or "the flight is over"))
        else:
            self._queue.put((action, future))
        return future

    def once(self, command_id: str, action: Callable[[], Future[Any]]) -> Future[Any]:
        """Return the answer to a command; `action` is called only if there was none of this id."""
        with self._lock:
            if command_id in self._answers:
                return self._answers[command_id]
            future = self._answers[command_id] = action()
            while len(self._answers) > _MAX_COMMANDS:
                self._answers.popitem(last=False)
            return future

    # ---------------------------------------------------------------- the thread of the flight

    def _run(self) -> None:
        try:
            self.experiment = self._make(self.mission)
            self.access = open_access(self.experiment.backend)
            self.room = Room(getattr(self.experiment.backend, "world", None), self.names)
            # a log of everything grows by megabytes a second, and the page needs none
            self.experiment.backend.record = lambda extra: None  # type: ignore[method-assign]
            self.no_rewind = self.access.no_rewind or self.experiment.no_rewind
            # a rewind can go back to before the first command
            self._keep_moment(self.experiment.time)
            self._publish()
            self.is_ready = True
            self.say("ready", f"{len(self.names)} drones are ready, backend {self.mission.backend}")
            while not self._closing.is_set():
                self._round()
        except CrazychoirError as error:
            self._end(str(error))
        except USER_ERRORS as error:  # a user's code may raise anything while it is made
            self._end(f"the flight has ended: {type(error).__name__}: {error}")
        finally:
            if self.experiment is not None:
                self.experiment.backend.close()
            self._refuse_all()

    def _end(self, sentence: str) -> None:
        self.error = sentence
        self.say("error", sentence)

    def _refuse_all(self) -> None:
        while not self._queue.empty():
            _, future = self._queue.get()
            future.set_exception(StateError(self.error or "the flight is over"))

    def _round(self) -> None:
        self._answer(_WAIT_S if self.is_paused else 0.0)
        if not self.is_paused:
            self.experiment.step()
            now = self.experiment.time
            if self.flying is not None:
                self.flying.step(now)
                while self.flying.problems:
                    self.say("error", self.flying.problems.pop(0))
                if self.flying.is_over:
                    self.say("flown", f"'{self.flying.name}' has been flown")
                    self.flying = None
            self._sample_plots(now)
            self._remember(now)
        self._hear()
        clock = wall.perf_counter()
        if clock >= self._next_frame:
            self._next_frame = clock + (_STILL_S if self.is_paused else FRAME_S)
            self._publish()
        self._keep_pace()

    @property
    def is_paused(self) -> bool:
        """Whether time stands still."""
        return self.speed == 0.0 and not self.experiment.backend.is_real_time

    def _answer(self, patience_s: float) -> None:
        """Run the queued actions."""
        while True:
            try:
                action, future = self._queue.get(timeout=patience_s) if patience_s else self._queue.get_nowait()
            except queue.Empty:
                return
            patience_s = 0.0
            try:
                future.set_result(action())
            except Exception as error:
                future.set_exception(error)
            self._next_frame = -np.inf

    def _keep_pace(self) -> None:
        """Let simulated time wait for the clock on the wall: here alone it does."""
        if self.experiment.backend.is_real_time or self.is_paused:
            self._due = None
            return
        clock = wall.perf_counter()
        self._due = (clock if self._due is None else self._due) + self.experiment.period / self.speed
        if self._due > clock:
            # a command that arrives meanwhile is run within a round
            wall.sleep(self._due - clock)
        else:
            if clock - self._due > _BEHIND_S:
                self._due = clock
            wall.sleep(0)  # others want to have their turn

    def _remember(self, now: float) -> None:
        if now < self._remembered:  # another flight has begun where this one was
            self._next_sample = self._next_moment = self._next_plot = -np.inf
        self._remembered = now
        if now >= self._next_sample:
            self._next_sample = now + SAMPLE_S - 1e-6
            sample = self._sample(now)
            self.branches.present.sample(now, sample)
            if self.stream is not None:
                self.stream.sample(self, now, sample)
        if now >= self._next_moment:
            self._keep_moment(now)

    def _keep_moment(self, now: float) -> None:
        if self.no_rewind is not None:
            return
        begin = wall.perf_counter()
        try:
            self.branches.present.add(self.take_moment())
        except Exception as error:  # a user's objects may be of any kind
            self.no_rewind = f"time cannot be turned back here: {type(error).__name__}: {error}"
        cost = wall.perf_counter() - begin
        self._next_moment = now + min(max(MOMENT_S, cost / MOMENT_SHARE * max(self.speed, 1.0)), 4 * MOMENT_S)

    def _sample(self, now: float) -> Sample:
        """Return what the drones do, small enough for hours of it."""
        pose = self.access.true_pose()
        velocity = np.full_like(pose.position, np.nan) if pose.velocity is None else pose.velocity
        watched = None
        if self.watched and self.plotted and self.plotted[-1][0] > now - SAMPLE_S:
            watched = self.plotted[-1][1]
        parts = (pose.position, pose.orientation, velocity, self._references())
        return Sample(*(part.astype(np.float32) for part in parts), watched)

    def _references(self) -> Array:
        """Return the reference positions of the drones (m, world), shape (N, 3); NaN where there is none."""
        reference = self.access.references()
        if reference is None:
            reference = np.full((len(self.names), 3), np.nan)
        for agent in self.experiment.agents:
            given = None if agent.reference is None else agent.reference.position
            if agent.is_up and given is not None:
                reference[agent.index] = given
            elif not agent.is_up:
                reference[agent.index] = np.nan
        return reference

    def take_moment(self) -> Moment:
        """Return this instant."""
        layers = [self.experiment] if self.flying is None else [self.experiment, self.flying]
        return Moment(self.experiment.time, Checkpoint(layers), self.flying)

    def go_back(self, number: int | None, time: float) -> float:
        """Make everything what it was, and begin a new branch there; returns when that is (s).

        Args:
            number: Of the branch; otherwise the one that flies now.
            time: When (s).

        Raises:
            StateError: If the flight cannot be rewound.
        """
        if self.no_rewind is not None:
            raise StateError(self.no_rewind)
        if number is None:
            number = self.branches.present.number
        if number == self.branches.present.number:
            self.branches.present.add(self.take_moment())
        parent, moment = self.branches.find(number, time)
        moment.checkpoint.restore()
        self.flying = moment.flying
        self.branches.leave(parent, moment)
        if self.stream is not None:
            self.stream.begin_again(zip(*self.branches.lineage(self.branches.present.number), strict=True))
        self._remembered = now = self.experiment.time
        self._next_sample = self._next_plot = -np.inf
        self._next_moment = now + MOMENT_S
        self._seen_happenings = len(self.experiment.events)
        self.plotted.clear()
        self._pace.clear()
        return now

    def _sample_plots(self, now: float) -> None:
        if not self.watched or now < self._next_plot:
            return
        self._next_plot = now + 0.05 - 1e-6
        values = {}
        for chosen in list(self.watched.values()):
            for drone, name in chosen:
                if (drone, name) not in values:
                    try:
                        values[drone, name] = self.access.log_value(drone, name)
                    except CrazychoirError:
                        values[drone, name] = float("nan")
        self.plotted.append((now, values))

    def _hear(self) -> None:
        """Take what happened to the console."""
        happened = self.experiment.events
        for happening in happened[self._seen_happenings :]:
            if happening.kind in _TOLD:
                continue
            details = happening.details
            if not isinstance(details, str):
                details = f"{happening.kind}: " + ", ".join(
                    f"{name} {_brief(value)}" for name, value in details.items()
                )
            text = details or happening.kind
            self.say(happening.kind, text, happening.drone, happening.time)
        self._seen_happenings = len(happened)

    def _publish(self) -> None:
        experiment, access = self.experiment, self.access
        now, clock = experiment.time, wall.perf_counter()
        self._pace.append((now, clock))
        (t0, c0), elapsed = self._pace[0], clock - self._pace[0][1]
        pose = access.true_pose()
        phase = np.array([PHASES.index(agent.phase.value) for agent in experiment.agents], np.int8)
        self._shown += 1
        rate = (now - t0) / elapsed if elapsed > 0.0 else 0.0
        del c0
        self.frame = Frame(
            self._shown, now, rate, pose.position.copy(), pose.orientation.copy(), self._references(), phase,
            self.room.poses(),
        )  # fmt: skip

    def listen_to_consoles(self) -> None:
        """Take what the onboard software printed to the console; called between rounds."""
        for i, name in enumerate(self.names):
            text, before = self.access.console(i), self._console.get(i, "")
            if text != before:
                self._console[i] = text
                # what is kept is the end: what is new comes after the longest part that is known
                known = next((k for k in range(len(before)) if text.startswith(before[k:])), len(before))
                for line in text[len(before) - known :].splitlines():
                    if line.strip():
                        self.say("onboard", line.strip(), name)


def _brief(value: Any) -> str:
    """Return a value of an event in few words."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        if value and isinstance(value[0], (list, tuple)):  # a table
            return f"({len(value)})"
        return " ".join(map(_brief, value[:10])) or "none"
    return str(value)
