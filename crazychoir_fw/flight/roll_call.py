"""Before drones over the radio fly: does the one that was meant answer, and stand where the mission says?"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.agents import starts_of

if TYPE_CHECKING:
    from crazychoir_fw.flight.hardware_backend import HardwareBackend
    from crazychoir_fw.mission.schema import LayeredMission

Part = tuple[Sequence[int], "HardwareBackend"]
"""Numbers of drones in the mission, and the backend that flies them."""

NOTHING_FLIES = "nothing flies: "
"""How the sentence begins that says what is wrong."""

_LISTED = 4
_SETTLE_S = 3.0
_BATTERY_S = 2.0
_NAME_BYTES = 29  # of a packet


def roll_call(
    mission: LayeredMission,
    parts: Sequence[Part],
    drones: Collection[int] | None = None,
    placed: Collection[int] | None = None,
    settle_s: float = _SETTLE_S,
) -> None:
    """Check the drones that are flown over the radio, all of them, before the first one moves.

    Args:
        mission: Says which drones it means, and where they stand.
        parts: The drones over the radio.
        drones: Numbers of those that shall fly, otherwise all.
        placed: Numbers of those that shall stand where the mission says, otherwise those that shall fly.
        settle_s: How long estimators may take to know where they are (s).

    Raises:
        StateError: With what is wrong with which drones, and how to accept it.
    """
    found = problems_of(mission, parts, drones, placed, settle_s)
    problems = [problem for kind in found.values() for problem in kind]
    if problems:
        raise StateError(f"{NOTHING_FLIES}{'; '.join(problems)}")


def problems_of(
    mission: LayeredMission,
    parts: Sequence[Part],
    drones: Collection[int] | None = None,
    placed: Collection[int] | None = None,
    settle_s: float = _SETTLE_S,
) -> dict[str, list[str]]:
    """Return what keeps drones on the floor, by what was looked at; nothing of what the mission accepts.

    Arguments are those of `roll_call`.
    """
    accepted = mission.hardware.accept
    names = {i: mission.fleet[i].id for numbers, _ in parts for i in numbers}
    who = {i: name for numbers, backend in parts for i, name in zip(numbers, backend.simulated_names(), strict=True)}
    meant = names if drones is None else drones
    standing = meant if placed is None else placed
    return {
        "conditions": list(_conditions(mission, parts, meant, settle_s)),
        "names": [] if "names" in accepted else list(_strangers(mission, who)),
        "mixture": [] if "mixture" in accepted else list(_mixture(names, who)),
        "places": [] if "places" in accepted else list(_places(mission, parts, standing, settle_s)),
    }


def _strangers(mission: LayeredMission, who: Mapping[int, str | None]) -> Iterable[str]:
    """Name drones of a served simulation that are not those of the mission."""
    wrong = []
    for i, name in who.items():
        drone = mission.fleet[i]
        if name is not None and name != "?" and name != _as_told(drone.id):
            wrong.append(f"at {drone.uri} answers '{name}' of a served simulation, and not {drone.id}")
    if wrong:
        more = "does another program serve drones there? hardware.accept: [names] flies them"
        yield f"{_listed(wrong)}; {more}"


def _as_told(name: str) -> str:
    return name.encode()[:_NAME_BYTES].decode("utf-8", "replace")


def _mixture(names: Mapping[int, str], who: Mapping[int, str | None]) -> Iterable[str]:
    simulated = [names[i] for i, name in who.items() if name is not None]
    real = [names[i] for i, name in who.items() if name is None]
    if simulated and real:
        yield (
            f"{_listed(real)}: real, but simulations answer for {_listed(simulated)}; simulated drones see no real "
            "ones, take backend mixed, or hardware.accept: [mixture]"
        )


def _places(mission: LayeredMission, parts: Sequence[Part], drones: Collection[int], settle_s: float) -> Iterable[str]:
    starts, limit, wrong = starts_of(mission), mission.hardware.start_tolerance_m, []
    for numbers, backend in parts:
        chosen = [k for k, i in enumerate(numbers) if i in drones]
        # the estimator of a drone that has just been switched on begins at the origin
        backend.wait_until(partial(_are_near, backend, chosen, starts[[numbers[k] for k in chosen]], limit), settle_s)
        positions = backend.true_positions()
        for k in chosen:
            at, i = positions[k], numbers[k]
            away = float(np.linalg.norm((at - starts[i])[:2]))
            if away > limit:
                wrong.append(
                    f"{mission.fleet[i].id} stands at {_place(at)}, {away:.2f} m from its start {_place(starts[i])}"
                )
    if wrong:
        yield (
            f"{_listed(wrong)}; allowed: {limit:g} m (hardware.start_tolerance_m); put them there, or let them take "
            "off where they stand by --set hardware.accept=[places]"
        )


def _are_near(backend: HardwareBackend, chosen: Sequence[int], starts: NDArray[np.float64], limit: float) -> bool:
    return bool((np.linalg.norm((backend.true_positions()[chosen] - starts)[:, :2], axis=1) <= limit).all())


def _place(at: NDArray[np.float64]) -> str:
    return f"({at[0]:.2f}, {at[1]:.2f})"


def _conditions(
    mission: LayeredMission, parts: Sequence[Part], drones: Collection[int], settle_s: float
) -> Iterable[str]:
    """Say which drones cannot fly: no position, an empty battery, a supervisor that does not let the motors run."""
    least = mission.hardware.least_battery_v
    for numbers, backend in parts:
        unknown = np.isnan(backend.true_positions()[:, 0])
        for i, is_unknown, voltage, reason in zip(
            numbers, unknown, backend.batteries(min(settle_s, _BATTERY_S)), backend.grounded(), strict=True
        ):
            name = mission.fleet[i].id
            if i not in drones:
                continue
            if is_unknown:
                yield f"{name} does not say where it is"
            if voltage < least:
                yield f"{name} has {voltage:.2f} V, allowed: {least:g} V or more (hardware.least_battery_v)"
            if reason is not None:
                yield f"{name}: {reason}"


def _listed(words: Sequence[Any]) -> str:
    more = f" and {len(words) - _LISTED} more" if len(words) > _LISTED else ""
    return ", ".join(map(str, words[:_LISTED])) + more
