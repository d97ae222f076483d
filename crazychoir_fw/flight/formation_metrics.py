"""What formations of any kind come down to: where drones shall be, and how far from it they are.

Plain arrays in and out: positions of all drones over time (m), shape (T, N, 3).
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.flight.agents import formation_of, graph_of, guidance_class, leads
from crazychoir_fw.guidance.bearing import bearing_laplacian
from crazychoir_fw.guidance.containment import Containment, distance_from_hull, equilibrium
from crazychoir_fw.guidance.distance_formation import FormationControl, distance_errors, fitted
from crazychoir_fw.guidance.graph import Graph
from crazychoir_fw.guidance.schemes.mpc import MPCGuidance

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission

Array = NDArray[np.float64]

KINDS = ("bearing", "distance", "containment", "together")


@dataclass(frozen=True)
class Formation:
    """Who shall stand how to whom."""

    places: Array  # (N, 3) [m]
    graph: Graph
    leaders: tuple[int, ...]
    kind: str = "bearing"
    """What counts: bearings or distances between the places; to be among the leaders; or to come to the places without
    ever being too far from neighbors."""
    plane: bool = False
    """Whether only distances in the plane count."""
    coupling: float = np.inf
    """Largest difference of a coordinate between neighbors (m)."""
    axes: tuple[int, ...] = ()
    """Along which that counts, and along which there are places."""

    @property
    def followers(self) -> list[int]:
        """Numbers of those who do not lead."""
        return [i for i in range(self.graph.size) if i not in self.leaders]


def shape_of(mission: LayeredMission) -> Formation | None:
    """Return what the drones of a mission shall form, if all follow one guidance that forms something."""
    if len(mission.layers.guidances) != 1:
        return None
    cls, places, graph = guidance_class(mission), formation_of(mission), graph_of(mission)
    leaders = tuple(i for i in range(graph.size) if leads(mission, i))
    if issubclass(cls, Containment):
        return Formation(np.zeros((graph.size, 3)), graph, leaders, "containment")
    if issubclass(cls, MPCGuidance):
        return _together(mission, graph)
    if places is None:
        return None
    if issubclass(cls, FormationControl):
        in_plane = bool(mission.layers.guidance.options.get("keeps_height", False))
        return Formation(places, graph, leaders, "distance", in_plane)
    return Formation(places, graph, leaders)


def _together(mission: LayeredMission, graph: Graph) -> Formation:
    options = mission.layers.guidance.options
    axes = tuple("xyz".index(axis) for axis in options.get("axes", "x"))
    places = np.full((graph.size, 3), np.nan)
    places[:, axes] = options.get("goal", 0.0)
    return Formation(places, graph, (), "together", coupling=float(options.get("coupling", 2.0)), axes=axes)


def places_of(formation: Formation, at: Array, wanted: Array) -> Array:
    """Return where all drones shall be (m), shape (N, 3); NaN where nobody knows.

    Args:
        formation: The formation.
        at: Where they are (m), shape (N, 3).
        wanted: Where they are told to be (m), NaN for who is told nothing, shape (N, 3).
    """
    if formation.kind == "distance":
        return fitted(formation.places, at)
    if formation.kind == "together":
        return np.where(np.isnan(formation.places), at, formation.places)
    leaders = list(formation.leaders)
    places = np.full(at.shape, np.nan)
    places[leaders] = np.where(np.isfinite(wanted[leaders]), wanted[leaders], at[leaders])
    with contextlib.suppress(np.linalg.LinAlgError, RangeError):  # the leaders leave them a choice
        if formation.kind == "containment":
            return equilibrium(formation.graph, leaders, places)
        followers = formation.followers
        laplacian = bearing_laplacian(formation.places, formation.graph)
        rows = [3 * i + k for i in followers for k in range(3)]
        columns = [3 * i + k for i in leaders for k in range(3)]
        right = -laplacian[np.ix_(rows, columns)] @ places[leaders].ravel()
        places[followers] = np.linalg.solve(laplacian[np.ix_(rows, rows)], right).reshape(-1, 3)
    return places


def errors_over_time(formation: Formation, at: Array, up: NDArray[np.bool_]) -> Array:
    """Return the errors that count of distances or of places over time (m), NaN while a drone does not fly.

    Args:
        formation: A formation by distances, errors of shape (T, edges), or containment, shape (T, followers).
        at: Positions over time (m), shape (T, N, 3).
        up: Whose motors turn, shape (T, N).
    """
    if formation.kind == "distance":
        pairs = np.array(formation.graph.pairs, int).reshape(-1, 2)
        errors = np.abs(shape_errors(formation, at))
        return np.where(up[:, pairs].all(axis=2), errors, np.nan)
    if formation.kind == "together":
        away = np.linalg.norm((at - formation.places)[:, :, formation.axes], axis=2)
        return np.where(up, away, np.nan)
    # the places of followers are linear in those of leaders: one matrix serves all times
    leaders, followers, n = list(formation.leaders), formation.followers, formation.graph.size
    unit = np.zeros((n, n))
    unit[leaders, leaders] = 1.0
    try:
        share = np.array([equilibrium(formation.graph, leaders, unit[:, [k]])[:, 0] for k in leaders]).T[followers]
    except RangeError:
        return np.full((len(at), len(followers)), np.nan)
    errors = np.linalg.norm(at[:, followers] - share @ at[:, leaders], axis=2)
    return np.where(up[:, followers] & up[:, leaders].all(axis=1, keepdims=True), errors, np.nan)


def shape_errors(formation: Formation, at: Array) -> Array:
    """Return the signed errors of all distances (m), shape (..., edges)."""
    pairs = list(formation.graph.pairs)
    if not formation.plane:
        return distance_errors(at, formation.places, pairs)
    flat = np.array([1.0, 1.0, 0.0])
    return distance_errors(at * flat, formation.places * flat, pairs)


def coupling_errors(formation: Formation, at: Array) -> Array:
    """Return by how much neighbors were farther apart than allowed (m), negative for nearer, shape (T, edges)."""
    i, j = np.array(formation.graph.pairs, int).reshape(-1, 2).T
    apart = np.abs((at[:, i] - at[:, j])[:, :, formation.axes]).max(axis=2)
    return apart - formation.coupling


def hull_distances(formation: Formation, at: Array) -> Array:
    """Return how far each drone is from the hull of the leaders (m), shape (N,); zero for leaders.

    Args:
        formation: The formation.
        at: Where drones are (m), shape (N, 3).
    """
    distances = np.zeros(len(at))
    for i in formation.followers:
        distances[i] = distance_from_hull(at[i], at[list(formation.leaders)])
    return distances
