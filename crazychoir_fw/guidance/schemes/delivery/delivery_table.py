"""`DeliveryTable`: requests to bring something from here to there, and what has become of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.guidance.schemes.delivery.delivery_request import DeliveryRequest
from crazychoir_fw.guidance.schemes.tasks.dispatch_table import DispatchTable


class DeliveryTable(DispatchTable):
    """Requests that turn up at given times, each served by one drone.

    Agents say of each stop when they were there: number 2 k is the pickup of request k, 2 k + 1 its delivery. What is
    on board of an agent that is gone is lost, and said to be.
    """

    def __init__(
        self,
        N: int,
        requests: Sequence[DeliveryRequest],
        *,
        deadline: float = 1.0,
        patience: float = 30.0,
        start_delay: float = 0.5,
    ) -> None:
        """Prepare.

        Args:
            N: Number of agents.
            requests: All of them, numbered from 0.
            deadline: As of `DispatchTable`.
            patience: As of `DispatchTable`.
            start_delay: As of `DispatchTable`.

        Raises:
            RangeError: If a number is outside its range.
        """
        super().__init__(N, deadline=deadline, patience=patience, start_delay=start_delay)
        for k, request in enumerate(requests):
            numbers = (*request.pickup, *request.delivery, request.load, request.at)
            if request.number != k or not all(math.isfinite(number) for number in numbers):
                raise RangeError(f"delivery table: request {k} is {request}, allowed: number {k} and finite numbers")
            if request.load < 0.0 or request.at < 0.0:
                raise RangeError(
                    f"delivery table: request {k} has load {request.load} at {request.at} s, allowed: 0 or more"
                )
        self._coming = list(requests)
        self.requests: dict[int, DeliveryRequest] = {}
        """Open requests by number."""
        self.lost: set[int] = set()
        """Numbers of the requests that were on board of a drone that is gone."""
        self._first = 0.0

    def step(self, now: float) -> None:
        """Look at the time (s): new requests make a new list."""
        super().step(now)
        if self.label and self._release():
            self.announce()

    def _begin(self) -> None:
        self._first = self._now
        self._release()

    def _release(self) -> bool:
        due = [request for request in self._coming if request.at <= self._now - self._first + 1e-9]
        if not due:
            return False
        self._coming = [request for request in self._coming if request not in due]
        for request in due:
            self.requests[request.number] = request
        made = [[one.number, *one.pickup, *one.delivery, one.load] for one in due]
        self.note("requests", None, {"label": self.label + 1, "requests": made})
        return True

    def _items_of(self, agent: int) -> list[DeliveryRequest]:
        return [request for _, request in sorted(self.requests.items()) if request.carrier in (None, agent)]

    def _finish(self, agent: int, number: int) -> bool:
        k, is_delivery = divmod(number, 2)
        request = self.requests.get(k)
        if request is None or request.carrier != (agent if is_delivery else None):
            self.announce()  # the list of the agent was out of date
            return False
        if is_delivery:
            del self.requests[k]
            self.finished += 1
            self.note("completed", agent, {"number": k, "position": list(request.delivery)})
            if self._left:
                self.announce()  # the drone has room again
        else:
            self.requests[k] = dataclasses.replace(request, carrier=agent)
            self.note("picked", agent, {"number": k, "position": list(request.pickup)})
        return True

    def _take_back(self) -> bool:
        gone = sorted(k for k, request in self.requests.items() if request.carrier in self.gone)
        if not gone:
            return False
        for k in gone:
            del self.requests[k]
        self.lost |= set(gone)
        self.note("lost_loads", None, {"numbers": gone})
        return True

    def _memory(self) -> dict[str, Any]:
        return {
            "open": [[number, request.carrier] for number, request in self.requests.items()],
            "coming": [request.number for request in self._coming],
            "lost": sorted(self.lost),
            "first": self._first,
        }

    def _remember(self, memory: Mapping[str, Any]) -> None:
        known = {request.number: request for request in self._coming}
        requests = {}
        for number, carrier in memory["open"]:
            if carrier is not None and carrier not in range(self.agents):
                raise ValueError(f"carrier {carrier}")
            requests[number] = dataclasses.replace(known[number], carrier=carrier)
        coming, lost, first = [known[k] for k in memory["coming"]], set(memory["lost"]), float(memory["first"])
        if not (lost <= set(known) and math.isfinite(first)):
            raise ValueError(f"lost {sorted(lost)}, first {first}")
        self._coming, self.requests, self.lost, self._first = coming, requests, lost, first

    @property
    def _open(self) -> set[int]:
        return set(self.requests)

    @property
    def is_done(self) -> bool:
        """Whether nothing is left to be done."""
        return super().is_done and not self._coming


def random_requests(
    count: int, seed: int, low: ArrayLike, high: ArrayLike, load: float = 1.0, every: float = 0.0
) -> list[DeliveryRequest]:
    """Return requests with points at random.

    Args:
        count: How many.
        seed: Seed of the draws.
        low: Least x and y (m).
        high: Largest x and y (m).
        load: Of each.
        every: Time between two of them (s); 0: all are there at the start.
    """
    random = np.random.default_rng(seed)
    points: Any = random.uniform(np.array(low, float), np.array(high, float), (count, 2, 2)).tolist()
    return [
        DeliveryRequest(k, tuple(pickup), tuple(delivery), load, at=every * k)
        for k, (pickup, delivery) in enumerate(points)
    ]
