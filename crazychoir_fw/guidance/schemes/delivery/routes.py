"""The shortest routes of one drone: for each set of requests that it could serve, in which order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from crazychoir_fw.guidance.schemes.delivery.delivery_request import DeliveryRequest

Point = tuple[float, float]

_SLACK = 1e-9  # of capacities


@dataclass(frozen=True)
class Stop:
    """A point of a route."""

    number: int
    """Of the request."""
    is_delivery: bool
    """Otherwise something is picked up."""
    position: Point
    """Where (m, world)."""


@dataclass(frozen=True)
class Route:
    """The shortest way to serve some requests."""

    cost: float
    """Its length (m)."""
    stops: tuple[Stop, ...]
    """In order."""


def best_routes(
    start: Point,
    requests: Sequence[DeliveryRequest],
    aboard: Sequence[DeliveryRequest] = (),
    *,
    capacity: float = math.inf,
    most: int = 3,
    home: Point | None = None,
) -> dict[frozenset[int], Route]:
    """Return the shortest route of each set of requests, by their numbers; what is on board is delivered in any.

    Exact, by dynamic programming over the requests that are untouched, on board or delivered, and the place of the
    drone. The work grows as the number of requests to the power of `most`.

    Args:
        start: Where the drone is (m), shape (2,).
        requests: What it could pick up.
        aboard: What it has already.
        capacity: Sum of the loads that it can have on board at a time.
        most: Largest number of requests to pick up on a route.
        home: Where the route ends (m), shape (2,); None is the last stop.
    """
    carried = frozenset(request.number for request in aboard)
    by_number = {request.number: request for request in (*requests, *aboard)}
    free = sorted(request.number for request in requests if request.load <= capacity + _SLACK)
    # a state is the requests on board, those picked up on the way, and the last stop
    state = tuple[frozenset[int], frozenset[int], Stop | None]
    layer: dict[state, tuple[float, tuple[Stop, ...]]] = {(carried, frozenset(), None): (0.0, ())}
    best: dict[frozenset[int], Route] = {}
    while layer:
        following: dict[state, tuple[float, tuple[Stop, ...]]] = {}
        for (loaded, taken, last), (cost, stops) in layer.items():
            here = start if last is None else last.position
            if not loaded:
                whole = cost + (0.0 if home is None else math.dist(here, home))
                if taken not in best or whole < best[taken].cost - _SLACK:
                    best[taken] = Route(whole, stops)
            room = capacity + _SLACK - sum(by_number[number].load for number in loaded)
            new = free if len(taken) < most else []
            for reached in _onward(loaded, taken, new, room, by_number):
                _better(following, reached, cost + math.dist(here, reached[2].position), stops)
        layer = following
    return best


def _onward(
    loaded: frozenset[int],
    taken: frozenset[int],
    new: Sequence[int],
    room: float,
    requests: Mapping[int, DeliveryRequest],
) -> Iterator[tuple[frozenset[int], frozenset[int], Stop]]:
    """Yield the states that one more stop leads to: deliveries, then pickups of new requests that there is room for."""
    for number in sorted(loaded):
        yield loaded - {number}, taken, Stop(number, True, requests[number].delivery)
    for number in new:
        if number not in taken and requests[number].load <= room:
            yield loaded | {number}, taken | {number}, Stop(number, False, requests[number].pickup)


def _better(layer: dict[Any, Any], state: tuple[Any, ...], cost: float, stops: tuple[Stop, ...]) -> None:
    if state not in layer or cost < layer[state][0]:
        layer[state] = (cost, (*stops, state[2]))
