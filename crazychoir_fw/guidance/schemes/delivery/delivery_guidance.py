"""`DeliveryGuidance`: pickup and delivery with routes that all drones agree on."""

from __future__ import annotations

from typing import Any

from crazychoir_fw.guidance.cf_guidance import Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.law import Needs, option
from crazychoir_fw.guidance.optimization import LinearProblem
from crazychoir_fw.guidance.schemes.delivery.delivery_request import DeliveryRequest
from crazychoir_fw.guidance.schemes.delivery.partition import Partition, partition_problem
from crazychoir_fw.guidance.schemes.delivery.routes import Route, Stop, best_routes
from crazychoir_fw.guidance.schemes.tasks.dispatch_guidance import DispatchGuidance, LabeledSimplex
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import Offer
from crazychoir_fw.guidance.schemes.tasks.task_metrics import DeliveryMetrics


class DeliveryGuidance(DispatchGuidance):
    """Shares out the requests of a `DeliveryTable` at the least sum of ways, and flies its route stop by stop."""

    needs = Needs(graph=True, table="delivery")
    metrics = DeliveryMetrics

    slots: int = option(1, "how many requests the table has in all", low=1)
    capacity: float = option(2.0, "sum of the loads that the drone can carry at a time", low=0, is_finite=False)
    most: int = option(3, "largest number of requests to pick up on one route", low=1)
    return_home: bool = option(False, "whether routes end where the drone started")
    dwell: float = option(1.0, "how long it hovers at a stop", "s", low=0)

    def __init__(self, agent_id: int, communicator: TopicCommunicator, slots: int, **options: Any) -> None:
        """Prepare; arguments and errors are those of `RoundGuidance`, and the number of requests of the table."""
        super().__init__(agent_id, communicator, slots=slots, **options)
        self.stops: list[Stop] = []
        """Stops that remain of its route."""
        self._said: set[tuple[int, bool]] = set()  # stops that the table knows to be done
        self._routes: dict[frozenset[int], Route] = {}
        self._partition = Partition(communicator.size, self.slots)
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

    def conclude(self, simplex: LabeledSimplex, now: float) -> bool:
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
            return  # a landing was commanded while an optimization ran
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
