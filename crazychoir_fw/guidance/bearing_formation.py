"""`BearingFormation`: a formation given by the directions between neighbors (docs/reference/crazychoir.md#8.2).

Followers ask for the acceleration

    u_i = -sum over neighbors j of P_ij [k_p e_ij + k_v de_ij/dt + k_i integral of e_ij],    e_ij = p_i - p_j

with P_ij = I - g_ij g_ij'. Leaders fly trajectories. Where gains differ between axes, P_ij stands on both sides of
them, so that the law rests exactly where the bearings are right; for formations at one height both forms are the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.guidance.bearing import check_formation, projections, projections_of_ort_proj
from crazychoir_fw.guidance.cf_guidance import TOUCHDOWN_HEIGHT, Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.distributed_feedback import CFDistributedFeedback
from crazychoir_fw.guidance.gains import gains_named
from crazychoir_fw.guidance.graph import Graph
from crazychoir_fw.guidance.law import POSES, LawContext, Needs, NodeFace, Option, option

Array = NDArray[np.float64]

_LEGACY_STEP = 0.001  # [s], which the original's integrals take for the time between ticks, whatever it is
LONGEST_STEP = 0.1  # [s], that an integral covers, so that an input does not leap after a pause between rounds
_LANDED = 0.05  # [m] above where landings end
_UNDETERMINED = 0.05  # of the sum of P_ij: below, bearings are so nearly parallel that they determine nothing
_STILL = np.zeros(3)
_STILL.flags.writeable = False


@dataclass(frozen=True)
class Law:
    """The formation law for one set of neighbors: matrices that act on what is stacked from their messages."""

    feedback: Array
    """On positions (n + 1, 3) and velocities (n + 1, 3), the own ones last, flat: shape (3, 6 (n + 1))."""
    integral: Array
    """On the positions: the rate of the trim, shape (3, 3 (n + 1))."""
    undetermined: Array | None
    """Projection on what the bearings to these neighbors leave open; None: nothing."""
    lost_damping: Array | None
    """On the own velocity, for neighbors that are lost, shape (3, 3); None: none is."""


class BearingFormation(CFDistributedFeedback):
    """Leaders fly trajectories; followers take their places by the directions to their neighbors."""

    unkept = (*CFDistributedFeedback.unkept, "_projections", "_laws")
    needs = Needs(graph=True, leaders=True, formation=True)
    node = NodeFace(
        positional=("update_frequency", *POSES, "input_topic"),
        parameters={
            "dd": Option(None, "spatial dimension, for compatibility: always 3", kind=int),
            "vicon": Option(False, "whether the gains are those for motion capture"),
        },
    )

    is_leader: bool = option(False, "whether it follows its own trajectory and not the formation")
    formation: Any = option(None, "desired positions of all, up to where and how large, shape (N, 3)", "m")
    ort_proj: Any = option(None, "in place of it, this agent's row of projections, 9 N numbers", kind=list[float])
    gains: Any = option("webots", "set of gains, by name or as FormationGains")
    trajectory: Any = option(None, "points that a leader flies along from START on; None: it stays")
    legacy: bool = option(False, "whether integrals are those of the original: 0.001 s per tick, one for all neighbors")

    def __init__(self, agent_id: int, communicator: TopicCommunicator, **options: Any) -> None:
        """Prepare; arguments are those of `RoundGuidance`.

        Raises:
            RangeError: If a value is outside its range, or there is neither formation nor ort_proj.
            UnknownNameError: If there is no such set of gains.
        """
        super().__init__(agent_id, communicator, **options)
        self.gains = gains_named(self.gains)
        self.trajectory = None if self.trajectory is None else list(self.trajectory)
        self._projections = {} if self.is_leader else self._own_projections(self.formation, self.ort_proj)
        self._laws: dict[tuple[tuple[int, ...], tuple[int, ...]], Law] = {}
        self.integrates = bool(np.any(self.gains.k_i) or np.any(self.gains.takeoff_k_i))
        """Whether trims are learned."""
        self._start: Array | None = None
        self._hold: Array | None = None
        self._trim = np.zeros(3)
        self._shared_integral = np.zeros(3)

    @classmethod
    def check(cls, context: LawContext) -> None:
        """Refuse a formation that leaders and bearings do not determine."""
        names, members = context.names, context.members
        places = {i: k for k, i in enumerate(members)}
        for i, j in context.graph.edges:
            if (i in places) != (j in places):
                raise RangeError(f"{names[i]} talks to {names[j]}, but only one of them is in this formation")
        edges = [(places[i], places[j]) for i, j in context.graph.edges if i in places]
        own = Graph.directed(len(members), edges, [names[i] for i in members])
        check_formation(context.formation[list(members)], own, [places[i] for i in context.leaders])  # type: ignore[index]

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any], size: int) -> dict[str, Any]:
        """Return options; the parameter ``vicon`` chooses gains where none are given."""
        options = super().from_parameters(values, size)
        if options["gains"] in (None, "webots"):
            options["gains"] = "vicon" if values["vicon"] else "webots"
        return options

    def _own_projections(self, formation: ArrayLike | None, ort_proj: ArrayLike | None) -> dict[int, Array]:
        communicator = self.communicator
        if (formation is None) == (ort_proj is None):
            raise RangeError(f"agent {self.agent_id}: give one of formation and ort_proj")
        if formation is None:
            return projections_of_ort_proj(ort_proj, communicator.size, communicator.in_neighbors)
        if np.shape(formation)[:1] != (communicator.size,):
            raise RangeError(
                f"agent {self.agent_id}: formation has shape {np.shape(formation)}, allowed: ({communicator.size}, 3)"
            )
        return projections(formation, self.agent_id, communicator.in_neighbors)

    # ---------------------------------------------------------------- phases

    def begin_takeoff(self, now: float) -> None:
        """Ask for the climb: leaders by a trajectory, followers by a reference that rises."""
        self._start_phase()
        if self.is_leader:
            super().begin_takeoff(now)
        else:
            self._trim[:] = 0.0

    def begin_landing(self, now: float) -> None:
        """Ask for the descent."""
        self._start_phase()
        if self.is_leader:
            super().begin_landing(now)

    def begin_flight(self, now: float) -> None:
        """Begin the formation."""
        self._start_phase()
        self._shared_integral[:] = 0.0
        if self.is_leader and self.trajectory is not None:
            self.fly(self.trajectory)

    def _start_phase(self) -> None:
        self._start = None
        self._hold = None

    def has_landed(self, now: float) -> bool:
        """Return whether the landing is over."""
        if self.is_leader or self._start is None:
            return super().has_landed(now)
        # the reference falls with a constant speed, so that a high drone needs longer
        at_bottom = (self._start[2] - TOUCHDOWN_HEIGHT) * self.takeoff_time / self.height
        down = self._position()[2] < TOUCHDOWN_HEIGHT + _LANDED
        return now - self._begin >= at_bottom + (0.0 if down else self.takeoff_time)

    def respond(self, neigh_data: dict[int, Pose], now: float) -> Reference | None:
        """Return what a follower asks for."""
        period = self.period(now)
        self.previous_round = now
        if self.is_leader:
            return None
        if self.legacy:
            period = _LEGACY_STEP
        u = self._formation(neigh_data, period) if self._phase is Phase.FLIGHT else self._vertical(now, period)
        return Reference(acceleration=self.limited(u))

    def period(self, now: float) -> float:
        """Return how long it is since the round before (s)."""
        previous = self.previous_round
        return 0.0 if previous is None else min(max(now - previous, 0.0), LONGEST_STEP)

    def limited(self, u: Array) -> Array:
        """Return an acceleration that is no larger than allowed (m/s^2), shape (3,)."""
        largest = self.gains.largest_acceleration
        if largest < math.inf:
            size = math.sqrt(u @ u)
            if size > largest:
                return u * (largest / size)
        return u

    # ---------------------------------------------------------------- take-off and landing

    def begin_way(self) -> Array:
        """Return where the climb or descent begins (m, world): where the drone is when it is first asked for."""
        if self._start is None:
            self._start = self._position().copy()
        return self._start

    def _vertical(self, now: float, period: float) -> Array:
        """Follow a reference that rises or falls with a constant speed."""
        position = self._position()
        reference = self.begin_way().copy()
        end = self.height if self._phase is Phase.TAKEOFF else TOUCHDOWN_HEIGHT
        speed, left = self.height / self.takeoff_time, end - reference[2]
        way = speed * (now - self._begin)
        velocity = self.own_velocity
        if self.gains.takeoff_follows_speed and way < abs(left):
            velocity = velocity - np.array([0.0, 0.0, math.copysign(speed, left)])
        reference[2] += math.copysign(min(way, abs(left)), left)
        return self._toward(position - reference, velocity, period, None)

    def _toward(self, error: Array, velocity: Array, period: float, within: Array | None) -> Array:
        """Return the acceleration that takes errors of position and velocity back, all of them or a part."""
        gains = self.gains
        feedback = gains.takeoff_k_p * error + gains.takeoff_k_d * velocity
        rate = gains.takeoff_k_i * error
        if within is not None:
            feedback, rate = within @ feedback, within @ rate
        self._integrate(-rate, period)
        return (self._trim if within is None else 0.0) - feedback

    def _integrate(self, rate: Array, period: float) -> None:
        if period == 0.0 or not self.integrates:
            return
        trim, largest = self._trim, self.gains.largest_trim
        trim += rate * period
        np.clip(trim, -largest, largest, out=trim)

    @property
    def own_velocity(self) -> Array:
        """Velocity of the drone (m/s, world), zero where none is known."""
        velocity = self.current_pose.velocity  # type: ignore[union-attr]
        return _STILL if velocity is None else velocity

    # ---------------------------------------------------------------- formation

    def evaluate_input(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the formation law without integrals (m/s^2), shape (3,)."""
        return self.law_of(neigh_data).feedback @ self._stacked(neigh_data)

    def _formation(self, neigh_data: dict[int, Pose], period: float) -> Array:
        law = self.law_of(neigh_data)
        stacked = self._stacked(neigh_data)
        u = law.feedback @ stacked
        rate = law.integral @ stacked[: law.integral.shape[1]]
        if self.legacy:
            return u + self._legacy_integral(neigh_data)
        self._integrate(rate, period)
        if law.lost_damping is not None:
            u = u - law.lost_damping @ self.own_velocity
        if law.undetermined is not None:
            if self._hold is None:
                self._hold = self._position().copy()
            u = u + self._toward(self._position() - self._hold, self.own_velocity, period, law.undetermined)
        else:
            self._hold = None
        return u + self._trim

    def keep_trim_in(self, array: Array) -> None:
        """Keep the sum of the integrals (m/s^2) in an array of the caller, shape (3,)."""
        array[:] = self._trim
        self._trim = array

    def _legacy_integral(self, neigh_data: dict[int, Pose]) -> Array:
        """Return the part of the one integral that the original keeps for all neighbors."""
        position = self._position()
        for pose in neigh_data.values():
            self._shared_integral += _LEGACY_STEP * (position - pose.position)
        blocks = sum((self._projections[one] for one in neigh_data), np.zeros((3, 3)))
        return -blocks @ (self.gains.k_i * self._shared_integral)

    def _stacked(self, neigh_data: dict[int, Pose]) -> Array:
        own = self.current_pose
        poses = [*neigh_data.values(), own]
        vectors = [pose.position for pose in poses]  # type: ignore[union-attr]
        vectors += [_STILL if pose.velocity is None else pose.velocity for pose in poses]  # type: ignore[union-attr]
        return np.concatenate(vectors)

    def law_of(self, neigh_data: Iterable[int]) -> Law:
        """Return the law for the neighbors whose poses arrive."""
        neighbors = tuple(neigh_data)
        # Lost neighbors are those missing from the graph as it is now: an edge that a schedule removes is no loss.
        lost = () if len(neighbors) == len(self._neighbors) else tuple(set(self._neighbors).difference(neighbors))
        law = self._laws.get((neighbors, lost))
        if law is None:
            if len(self._laws) > 256:  # graphs that change at random
                self._laws.clear()
            law = self._laws[neighbors, lost] = self._made_law(neighbors, lost)
        return law

    def _made_law(self, neighbors: tuple[int, ...], lost: tuple[int, ...]) -> Law:
        gains = self.gains
        share = 1.0 / max(1, len(neighbors)) if gains.per_neighbor else 1.0
        blocks = np.array([self._projections[one] for one in neighbors]).reshape(-1, 3, 3)
        feedback = np.hstack([_row(blocks, share * gain, self.legacy) for gain in (gains.k_p, gains.k_v)])
        integral = _row(blocks, share * gains.k_i, False)
        if self.legacy or not lost:
            return Law(feedback, integral, None, None)
        damping = sum(self._projections[one] * gains.k_v @ self._projections[one] for one in lost)
        values, vectors = np.linalg.eigh(blocks.sum(axis=0))
        open_ways = vectors[:, values < _UNDETERMINED]
        undetermined = open_ways @ open_ways.T if open_ways.size else None
        return Law(feedback, integral, undetermined, share * damping)


def _row(blocks: Array, gain: Array, legacy: bool) -> Array:
    """Return the matrix of -sum P_ij gain P_ij (own - other), for stacked vectors (n + 1, 3), the own one last."""
    weighted = blocks * gain if legacy else blocks * gain @ blocks
    own = -weighted.sum(axis=0)
    return np.hstack([*weighted, own])
