"""What real drones are: their firmware, self-test and decks, and what their health tests say."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from crazychoir_fw.crtp.services.platform import FIRMWARE_RELEASE, firmware_version
from crazychoir_fw.onboard.variables import parameter_table
from crazychoir_fw.preflight.check import Check, check
from crazychoir_fw.preflight.readings import Readings
from crazychoir_fw.radio.identity import firmware_of
from crazychoir_fw.radio.parameters import element_of, set_parameters

if TYPE_CHECKING:
    from crazychoir_fw.radio import RadioDrone
    from crazychoir_fw.simulation.drone import Drone

Wait = Callable[[Callable[[], bool], float], bool]
"""Waits until something holds, at most so long (s); returns whether it does."""

_TIMEOUT_S = 5.0
_TEST_S = 15.0
_ALL_MOTORS = 0b1111


def firmware_check(drones: Mapping[str, RadioDrone], likenesses: Mapping[str, Drone]) -> Check:
    """Return whether drones fly the revision of the firmware that was simulated."""
    problems, told = [], set()
    for name, drone in drones.items():
        version = firmware_of(drone.cf) or "unknown"
        tested = firmware_version(likenesses[name].provider_number)
        told.add(version)
        if not is_same_firmware(version, tested, _revision(drone)):
            problems.append(f"{name} flies {version}, tested was {tested}")
        elif _read(drone, "firmware.modified") and "dirty" not in tested:
            problems.append(f"{name} flies {version} with sources that were changed after that revision")
    return check("firmware", problems, ", ".join(sorted(told)))


def is_same_firmware(version: str, tested: str, revision: str) -> bool:
    """Tell whether a drone has the firmware that was tested.

    Args:
        version: What the drone calls it.
        tested: What the provider of the simulated drone calls it: a release and what is ours, or as git describes it.
        revision: First digits of the commit, as the drone has them in its parameters; empty if it does not say.
    """
    if version == tested:
        return True
    commit = re.search(r"-g([0-9a-f]{7,40})(-dirty)?$", tested)
    if commit is not None:
        length = min(len(commit[1]), len(revision))
        return length > 0 and commit[1][:length] == revision[:length]
    # the built-in provider follows a release; another build of it is not the one that was tested
    return tested.startswith(FIRMWARE_RELEASE) and version == FIRMWARE_RELEASE


def _revision(drone: RadioDrone) -> str:
    first, second = _read(drone, "firmware.revision0"), _read(drone, "firmware.revision1")
    return f"{first:08x}{second:04x}" if first else ""


def _read(drone: RadioDrone, name: str) -> int:
    """Return a parameter, 0 where the drone has none of that name."""
    return int(drone.get_parameter(name)) if element_of(drone.cf.param.toc, name) is not None else 0


def self_tests(drones: Mapping[str, RadioDrone]) -> Check:
    """Return whether the tests of drones at their start were good."""
    name = "system.selftestPassed"
    failed = [
        f"{one}: its self-test at the start failed"
        for one, drone in drones.items()
        if element_of(drone.cf.param.toc, name) is not None and not drone.get_parameter(name)
    ]
    return check("self-test", failed, "passed")


def decks(drones: Mapping[str, RadioDrone], likenesses: Mapping[str, Drone]) -> Check:
    """Return whether drones carry the decks of the mission; others are named, because they weigh something."""
    problems, more = [], []
    for name, drone in drones.items():
        likeness = likenesses[name]
        for deck in parameter_table(likeness.provider_number):
            if not deck.startswith("deck.bc"):
                continue
            is_there, is_meant = bool(_read(drone, deck)), bool(likeness.param[deck])
            if is_meant and not is_there:
                problems.append(f"{name} has no {deck.removeprefix('deck.')}")
            elif is_there and not is_meant:
                more.append(f"{name} carries {deck.removeprefix('deck.')}, which the mission does not know")
    return check("decks", problems, "; ".join(more[:3]) or "those of the mission")


def health_tests(drones: Mapping[str, RadioDrone], wait: Wait) -> list[Check]:
    """Turn the motors of all drones, one after the other and then together; returns what their tests say."""
    return [
        _tested("propellers", drones, wait, "health.startPropTest", _PROPELLERS, _are_propellers_over, _propellers),
        _tested("battery sag", drones, wait, "health.startBatTest", _BATTERY, _is_battery_over, _battery),
    ]


_PROPELLERS = ("health.motorPass", "health.motorTestCount")
_BATTERY = ("health.batteryPass", "health.batterySag")


def _are_propellers_over(before: Mapping[str, float], now: Mapping[str, float]) -> bool:
    return before["health.motorTestCount"] != now["health.motorTestCount"]


def _is_battery_over(before: Mapping[str, float], now: Mapping[str, float]) -> bool:
    return any(before[name] != now[name] for name in _BATTERY)


def _propellers(values: Mapping[str, float]) -> str | None:
    bad = [f"M{motor + 1}" for motor in range(4) if not int(values["health.motorPass"]) >> motor & 1]
    return f"{', '.join(bad)} shake, or do not turn" if int(values["health.motorPass"]) != _ALL_MOTORS else None


def _battery(values: Mapping[str, float]) -> str | None:
    sag = values["health.batterySag"]
    return None if values["health.batteryPass"] == 1 else f"the voltage sags by {sag:.2f} V under load"


def _tested(
    title: str,
    drones: Mapping[str, RadioDrone],
    wait: Wait,
    start: str,
    logs: Sequence[str],
    is_over: Callable[[Mapping[str, float], Mapping[str, float]], bool],
    complaint: Callable[[Mapping[str, float]], str | None],
) -> Check:
    able = {name: one for name, one in drones.items() if all(element_of(one.cf.log.toc, log) for log in logs)}
    problems = [f"{name} has no such test" for name in drones if name not in able]
    with ExitStack() as stack:
        heard = {name: stack.enter_context(Readings(drone, logs)) for name, drone in able.items()}
        wait(lambda: all(one.is_complete for one in heard.values()), _TIMEOUT_S)
        before = {name: dict(one.latest) for name, one in heard.items() if one.is_complete}
        for name in before:
            set_parameters(able[name].cf, name, {start: 1}, _TIMEOUT_S)
        wait(lambda: all(is_over(before[name], heard[name].latest) for name in before), _TEST_S)
        ended = {name for name in before if is_over(before[name], heard[name].latest)}
        problems += _complaints({name: one.latest for name, one in heard.items()}, ended, complaint)
    return check(title, problems, "good")


def _complaints(
    heard: Mapping[str, Mapping[str, float]],
    ended: Container[str],
    complaint: Callable[[Mapping[str, float]], str | None],
) -> Iterable[str]:
    """Say of each drone what is wrong with its test."""
    for name, values in heard.items():
        if name not in ended:
            yield f"{name} did not end its test within {_TEST_S:g} s"
        elif (text := complaint(values)) is not None:
            yield f"{name}: {text}"
