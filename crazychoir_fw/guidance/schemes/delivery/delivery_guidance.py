"""`DeliveryGuidance`: pickup and delivery with routes that all drones agree on."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.optimization import LinearProblem
from crazychoir_fw.guidance.schemes.delivery.delivery_request import DeliveryRequest
from crazychoir_fw.guidance.schemes.delivery.partition import Partition, partition_problem
from crazychoir_fw.guidance.schemes.delivery.routes import Route, Stop, best_routes
from crazychoir_fw.guidance.schemes.tasks.dispatch_guidance import DispatchGuidance, LabeledSimplex
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import Offer
from crazychoir_fw.guidance.schemes.tasks.position_task_executor import PositionTaskExecutor


class DeliveryGuidance(DispatchGuidance):
    """Shares out the requests of a `DeliveryTable` at the least sum of ways, and flies its route stop by stop."""

    def __init__(
        self,
        agent_id: int,
        communicator: TopicCommunicator,
        slots: int,
        *,
        init_pos: ArrayLike | None = None,
        height: float = 0.5,
        height_step: float = 0.15,
        takeoff_time: float = 5.0,
        update_frequency: float = 100.0,
        deadline: float = 0.05,
        max_iterations: int = 20,
        tolerance: float = 0.05,
        speed: float = 0.5,
        duration: float | None = None,
        big_M: float = 500.0,
        capacity: float = 2.0,
        most: int = 3,
        return_home: bool = False,
        dwell: float = 1.0,
    ) -> None:
        """Prepare.

        Args:
            agent_id: As of `DispatchGuidance`, like the following ones.
            communicator: Carries bases to and from neighbors.
            slots: How many requests the table has in all.
            init_pos: Start (m, world), shape (2,) or (3,).
            height: At which drone 0 flies (m).
            height_step: So much higher flies each further drone (m).
            takeoff_time: Of take-off and landing (s).
            update_frequency: Steps per second (Hz).
            deadline: How long a round may take (s).
            max_iterations: Rounds of an optimization, at least twice the longest way between two drones in the graph.
            tolerance: Level distance from a stop at which it is reached (m).
            speed: Mean speed of flights (m/s).
            duration: Duration of every flight (s), instead of the speed.
            big_M: What a request costs that nobody serves: more than any way is long (m).
            capacity: Sum of the loads that the drone can carry at a time.
            most: Largest number of requests to pick up on one route.
            return_home: Whether routes end where the drone started.
            dwell: How long it hovers at a stop (s).

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(
            agent_id,
            communicator,
            init_pos=init_pos,
            height=height,
            height_step=height_step,
            takeoff_time=takeoff_time,
            update_frequency=update_frequency,
            deadline=deadline,
            max_iterations=max_iterations,
            big_M=big_M,
        )
        if slots < 1:
            raise RangeError(f"agent {agent_id}: slots is {slots}, allowed: 1 or more")
        if not capacity >= 0.0:
            raise RangeError(f"agent {agent_id}: capacity is {capacity}, allowed: 0 or more")
        if most < 1:
            raise RangeError(f"agent {agent_id}: most is {most}, allowed: 1 or more")
        if not (math.isfinite(dwell) and dwell >= 0.0):
            raise RangeError(f"agent {agent_id}: dwell is {dwell}, allowed: 0 s or more")
        self.slots = slots
        self.capacity = capacity
        self.most = most
        self.return_home = return_home
        self.dwell = dwell
        self.executor = PositionTaskExecutor(self.height, tolerance=tolerance, speed=speed, duration=duration)
        self.stops: list[Stop] = []
        """What is left of its route."""
        self._said: set[tuple[int, bool]] = set()  # stops that the table knows to be done
        self._routes: dict[frozenset[int], Route] = {}
        self._partition = Partition(communicator.size, slots)
        self._there_since: float | None = None

    # ---------------------------------------------------------------- what is shared out

    def problem(self, offer: Offer, now: float) -> LinearProblem:
        """Return its columns: one per set of requests that it can serve, which costs the route (m)."""
        del now
        size = self.communicator.size
        self._partition = Partition(size, self.slots)
        self._routes = self._routes_of(offer.items) if offer.items else {frozenset(): Route(0.0, ())}
        return partition_problem(self.agent_id, size, self.slots, self._routes)

    def _routes_of(self, requests: tuple[DeliveryRequest, ...]) -> dict[frozenset[int], Route]:
        x, y = self._position()[:2]
        home = None
        if self.return_home and self.init_pos is not None:
            home = (float(self.init_pos[0]), float(self.init_pos[1]))
        return best_routes(
            (float(x), float(y)),
            [request for request in requests if request.carrier is None],
            [request for request in requests if request.carrier is not None],
            capacity=self.capacity,
            most=self.most,
            home=home,
        )

    def decide(self, simplex: LabeledSimplex, now: float) -> bool:
        """Take its route, or go on until all have one."""
        if not self._partition.take(simplex):
            return False
        numbers, cost = self._partition.chosen.get(self.agent_id, (frozenset(), 0.0))
        route = self._routes.get(numbers, Route(0.0, ()))
        self.stops = [stop for stop in route.stops if (stop.number, stop.is_delivery) not in self._said]
        takes = sorted({stop.number for stop in route.stops})
        upcoming = [2 * stop.number + int(stop.is_delivery) for stop in self.stops]
        self._tell(takes, upcoming, cost=cost, bound=self._partition.bound, stages=self._partition.stages)
        self._move(now)
        return True

    def next_problem(self) -> LinearProblem:
        """Return what it can still choose from."""
        left = self._partition.routes_left(self.agent_id, self._routes)
        return partition_problem(self.agent_id, self.communicator.size, self.slots, left)

    # ---------------------------------------------------------------- what is flown

    def _move(self, now: float) -> None:
        if self._phase is not Phase.FLIGHT:
            return  # it was told to land while an optimization ran
        here = self._position()
        if self.stops:
            way = self.executor.go(self.stops[0].position, here, now)
        elif self.return_home and self.init_pos is not None:
            way = self.executor.go(self.init_pos[:2], here, now)
        else:
            way = self.executor.stay(here)
        if way is not None:
            self._there_since = None
            self.go_to(*way)

    def work(self, now: float) -> None:
        """See whether it is at its stop and has dwelt there, and say so."""
        if not self.stops or self._desk is None or self.is_deciding:
            return
        if self.executor.has_arrived(self._position()):
            if self._there_since is None:
                self._there_since = now
            if now - self._there_since >= self.dwell - 1e-9:
                stop = self.stops.pop(0)
                self._said.add((stop.number, stop.is_delivery))
                self._desk.complete(self.agent_id, 2 * stop.number + int(stop.is_delivery))
                self._move(now)
        elif self.executor.is_late(now):
            x, y = self.stops[0].position
            self.stops = []
            self._give_up(f"did not reach the stop at ({x:.2f}, {y:.2f})")

    # ---------------------------------------------------------------- buttons

    def forget_what_was_said(self) -> None:
        """See `DispatchGuidance`."""
        self._said.clear()

    def drop(self) -> None:
        """See `DispatchGuidance`."""
        self.stops = []
        self.executor.goal = None
        self._there_since = None
