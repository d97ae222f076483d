"""`CFGuidance`: what guidance of any kind has in common, its buttons and its phases."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference, TrajectoryPoint
from crazychoir_fw.guidance.formation_metrics import BearingMetrics
from crazychoir_fw.guidance.law import POSES, LawContext, Needs, NodeFace, option, options_of
from crazychoir_fw.guidance.metrics import Metrics
from crazychoir_fw.guidance.outputs import Outputs

Array = NDArray[np.float64]

TOUCHDOWN_HEIGHT = 0.01
"""Height at which landings end (m), as in the original."""

STANDS_AT_START = 0.05
"""Distance (m) up to which a drone stands at its start: poses of real ones scatter, and it climbs above the start."""

_AFTER_LANDING = 1.0  # [s] after the end of a landing, before the motors are turned off


class Phase(enum.Enum):
    """What the guidance is doing."""

    IDLE = "idle"
    """On the ground: nothing is asked for."""
    TAKEOFF = "takeoff"
    """Climbing to the height, and staying there."""
    FLIGHT = "flight"
    """What the START button begins: the formation, the list of goals."""
    LANDING = "landing"
    STOPPED = "stopped"
    """By the STOP button, until take-off or `resume`."""


class CFGuidance(Stateful):
    """Takes off, lands and stops; by itself it flies on trajectories, and its flight is to stay where it is.

    Subclasses override `flight`, and may override how they take off and land.
    """

    unkept = ("on_change", "on_lost", "on_rejoined")
    kind = "acceleration"
    """What `Outputs.reference` is: acceleration, position or fullstate."""
    references_itself: ClassVar[bool] = False
    """Whether drones that do not lead follow its references, and no trajectory handler."""
    needs: ClassVar[Needs] = Needs()
    """What a mission must say."""
    metrics: ClassVar[type[Metrics]] = BearingMetrics
    """How flights are judged and drawn."""
    node: ClassVar[NodeFace] = NodeFace(positional=(*POSES, "takeoff_time", "height"))
    """How it looks as a ROS 2 node."""

    init_pos: Any = option(
        None,
        "start, above which the drone hovers after its take-off, if it stands there; None, and for drones that stand "
        "elsewhere: where it is at the take-off; shape (2,) or (3,)",
        "m, world",
    )
    height: float = option(1.0, "height of the take-off", "m", above=0)
    takeoff_time: float = option(5.0, "duration of take-off and landing", "s", above=0)
    update_frequency: float = option(100.0, "steps per second", "Hz", above=0)

    def __init__(self, agent_id: int = 0, **options: Any) -> None:
        """Prepare.

        Args:
            agent_id: Number of this drone.
            options: Those that the class and its bases declare, see `options_of`.

        Raises:
            RangeError: If a number is outside its range.
            UnknownNameError: If a word is none of those that an option allows.
        """
        self.agent_id = agent_id
        for name, declared in options_of(type(self)).items():
            setattr(self, name, declared.checked(f"agent {agent_id}", name, options.pop(name, declared.default)))
        if options:
            raise TypeError(f"{type(self).__name__} has no option {', '.join(options)}")
        self.init_pos = None if self.init_pos is None else self._checked("init_pos", self.init_pos, (2, 3))
        self.current_pose: Pose | None = None
        self.on_change: Callable[[], None] | None = None
        """Callback for changes of phase or wanted trajectory: a `GuidanceGroup` looks at each agent only after one."""
        self._phase = Phase.IDLE
        self._begin = 0.0  # of the phase [s]
        self._trajectory: list[TrajectoryPoint] | None = None
        self._stands: Array | None = None  # at the latest take-off

    @classmethod
    def check(cls, context: LawContext) -> None:
        """Refuse a mission in which the law cannot work, beyond `needs`.

        Raises:
            CrazychoirError: With a sentence that continues the place of the law in the mission.
        """

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any], size: int) -> dict[str, Any]:
        """Return the options that the parameters of a node stand for.

        Args:
            values: Options and `node.parameters`, by name.
            size: Number of agents.
        """
        del size
        return {name: value for name, value in values.items() if name in options_of(cls)}

    @classmethod
    def has_start(cls) -> bool:
        """Return whether START begins something of its own: otherwise the drone stays where it is."""
        return any(
            getattr(cls, name) is not getattr(CFGuidance, name) for name in ("start", "begin_flight", "flight", "step")
        )

    def _checked(self, what: str, values: ArrayLike, sizes: Sequence[int] = (3,)) -> Array:
        vector = np.asarray(values, dtype=np.float64)
        if vector.ndim != 1 or vector.size not in sizes or not np.isfinite(vector).all():
            raise RangeError(f"agent {self.agent_id}: {what} is {values}, allowed: {sizes[-1]} finite numbers")
        return vector

    @property
    def phase(self) -> Phase:
        """What the guidance is doing."""
        return self._phase

    @property
    def phase_begin(self) -> float:
        """Since when (s)."""
        return self._begin

    def set_pose(self, pose: Pose) -> None:
        """Take the newest pose of this drone.

        Raises:
            RangeError: If it has a position or velocity that is not three finite numbers.
        """
        for vector in (pose.position, pose.velocity):
            # three additions instead of isfinite().all(), which costs ten times as much
            if vector is not None and not (vector.shape == (3,) and math.isfinite(vector[0] + vector[1] + vector[2])):
                self._checked("the pose", vector)
        self.current_pose = pose

    # ---------------------------------------------------------------- buttons

    def takeoff(self, now: float) -> None:
        """Climb to the height, straight up from wherever the drone stands. Also ends a stop."""
        self._enter(Phase.TAKEOFF, now)
        self._stands = self._where_it_stands()
        self.begin_takeoff(now)

    def start(self, now: float) -> None:
        """Begin the flight; without effect while stopped."""
        if self._phase is not Phase.STOPPED:
            self._enter(Phase.FLIGHT, now)
            self.begin_flight(now)

    def land(self, now: float) -> None:
        """Descend; without effect on the ground and while stopped."""
        if self._phase in (Phase.TAKEOFF, Phase.FLIGHT):
            self._enter(Phase.LANDING, now)
            self.begin_landing(now)

    def stop(self, now: float) -> None:
        """Ask for nothing any more: motors off at once. Holds until take-off or `resume`."""
        self._enter(Phase.STOPPED, now)

    def resume(self, now: float) -> None:
        """End a stop: the drone is idle again."""
        if self._phase is Phase.STOPPED:
            self._enter(Phase.IDLE, now)

    def _enter(self, phase: Phase, now: float) -> None:
        self._phase = phase
        self._begin = now
        self._trajectory = None
        if self.on_change is not None:
            self.on_change()

    # ---------------------------------------------------------------- to be overridden

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb."""
        del now
        self.go_to(self._above_start(), self.takeoff_time)

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""
        del now
        x, y = self._position()[:2]
        self.go_to(np.array([x, y, TOUCHDOWN_HEIGHT]), self.takeoff_time)

    def begin_flight(self, now: float) -> None:
        """Called when the flight begins."""

    def flight(self, now: float) -> Reference | None:
        """Return the reference of the flight."""
        del now
        return None

    def has_landed(self, now: float) -> bool:
        """Return whether the landing is over."""
        return now - self._begin >= self.takeoff_time + _AFTER_LANDING

    # ---------------------------------------------------------------- a step

    def step(self, now: float) -> Outputs:
        """Return what to ask for at a time (s)."""
        return self.outputs(now, self.flight(now) if self._phase is Phase.FLIGHT else None)

    def silent_until(self, now: float) -> float:
        """Return the time (s) before which steps ask for nothing, whatever the pose is, unless `on_change` is called.

        A caller may leave such steps out, and must hand over the pose before the next one. A law of your own is
        stepped each time unless it overrides this.
        """
        del now
        cls = type(self)
        is_silent = cls.step is CFGuidance.step and cls.flight is CFGuidance.flight and self._keeps_quiet
        return math.inf if is_silent else -math.inf

    @property
    def _keeps_quiet(self) -> bool:
        """Whether a trajectory is flown, and none waits for the next step."""
        return self._trajectory is None and (self._phase is Phase.TAKEOFF or self._phase is Phase.FLIGHT)

    def outputs(self, now: float, reference: Reference | None) -> Outputs:
        """Return a reference together with what the phase asks for."""
        if self._phase is Phase.LANDING and self.has_landed(now):
            self._enter(Phase.IDLE, now)
        if self._phase is Phase.IDLE or self._phase is Phase.STOPPED:
            return _IDLE
        trajectory = self._trajectory
        self._trajectory = None
        return Outputs(reference, trajectory)

    def go_to(self, position: Array, duration: float) -> None:
        """Ask the trajectory handler for a way to a position (m) that takes a time (s), with the next step."""
        self.fly([TrajectoryPoint(float(duration), position)])

    def fly(self, trajectory: Sequence[TrajectoryPoint]) -> None:
        """Ask the trajectory handler for a trajectory, with the next step."""
        self._trajectory = list(trajectory)
        if self.on_change is not None:
            self.on_change()

    @property
    def asks_nothing(self) -> bool:
        """Whether no trajectory waits for the next step."""
        return self._trajectory is None

    def _position(self) -> Array:
        """Return where the drone is, or began."""
        if self.current_pose is not None and self.current_pose.position is not None:
            return self.current_pose.position
        if self.init_pos is not None:
            return np.append(self.init_pos[:2], TOUCHDOWN_HEIGHT)
        raise RangeError(f"agent {self.agent_id}: neither a pose nor init_pos is known")

    def _where_it_stands(self) -> Array:
        """Return the start, or where the drone is if that is elsewhere: by then others may stand at its start."""
        if self.init_pos is None:
            return self._position()
        here = self._position()
        is_at_start = math.hypot(here[0] - self.init_pos[0], here[1] - self.init_pos[1]) <= STANDS_AT_START
        return self.init_pos if is_at_start else here

    def _above_start(self) -> Array:
        place = self._where_it_stands() if self._stands is None else self._stands
        return np.array([place[0], place[1], self.height])


_IDLE = Outputs(idle=True)
