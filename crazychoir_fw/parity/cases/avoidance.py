"""Collision avoidance: recorded encounters, and peers at random places."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.inputs import FlightInputs, Inputs
from crazychoir_fw.parity.structs import columns, pointer, zeros

_NEEDS = ("collision_avoidance", "collision_avoidance_is_enabled")
_MADE_UP = 1500


def avoidance_cases(inputs: Inputs) -> list[Case]:
    """Return the cases of collision avoidance."""
    common = {"group": "collision avoidance", "needs": _NEEDS, "log_groups": ("colAv",)}
    cases = [
        Case(
            name=f"flight {flight.name}",
            about="two drones that want each other's place",
            run=functools.partial(_recorded, flight=flight),
            **common,
        )
        for flight in inputs.flights.values()
        if "peers" in flight.tracks
    ]
    for name, parameters in (
        ("off", {}),
        ("on", {"colAv.enable": 1}),
        ("on, in a box", {"colAv.enable": 1, "colAv.bboxMinX": -0.5, "colAv.bboxMaxX": 0.5, "colAv.bboxMaxZ": 1.0}),
    ):
        run = functools.partial(_made_up, parameters=parameters)
        cases.append(
            Case(name=f"made up: {name}", about="ten peers at random places", run=run, by_number=True, **common)
        )
    return cases


def _recorded(request: CaseRequest, flight: FlightInputs) -> Outcome:
    tracks = flight.tracks
    outcome = _run(
        request, tracks["commanded"], tracks["peers"], tracks["sensors"], tracks["estimate"], tracks["tick"], flight, {}
    )
    outcome.ticks = tracks["tick"]
    return outcome


def _made_up(request: CaseRequest, parameters: dict[str, float]) -> Outcome:
    dice = np.random.default_rng(21)
    ticks = np.arange(1000, 1000 + _MADE_UP)
    setpoints, sensors, estimates = (zeros(name, _MADE_UP) for name in ("setpoint_t", "sensorData_t", "state_t"))
    for axis in "xyz":
        estimates["position"][axis] = dice.normal(0.0, 0.3, _MADE_UP)
        estimates["velocity"][axis] = dice.normal(0.0, 0.3, _MADE_UP)
        setpoints["position"][axis] = dice.normal(0.0, 0.6, _MADE_UP)
        setpoints["velocity"][axis] = dice.normal(0.0, 0.6, _MADE_UP)
        setpoints["mode"][axis] = 1 + np.arange(_MADE_UP) % 2
    peers = zeros("cf_peer_localization_t", _MADE_UP)
    table = peers["peers"]
    table["id"] = np.arange(lib.PEER_LOCALIZATION_MAX_NEIGHBORS) * (dice.random((_MADE_UP, 10)) < 0.6)
    for axis in "xyz":
        table["pos"][axis] = dice.normal(0.0, 0.8, (_MADE_UP, 10))
    table["pos"]["timestamp"] = ticks[:, None] - dice.integers(0, 6000, (_MADE_UP, 10)).clip(max=ticks[:, None] - 1)
    return _run(request, setpoints, peers, sensors, estimates, ticks, None, parameters)


def _run(
    request: CaseRequest,
    commanded: NDArray[Any],
    peers: NDArray[Any],
    sensors: NDArray[Any],
    estimates: NDArray[Any],
    ticks: NDArray[Any],
    flight: FlightInputs | None,
    parameters: dict[str, float],
) -> Outcome:
    block = request.boot(flight)
    for name, value in parameters.items():
        if name in request.side.parameter_table:
            block.set_parameter(name, value)
    functions, state = block.functions, block.state
    bend, is_enabled = functions["collision_avoidance"], functions["collision_avoidance_is_enabled"]
    bent, enabled = commanded.copy(), np.zeros(len(ticks), bool)
    setpoint, sensor = pointer(bent, "setpoint_t"), pointer(sensors, "sensorData_t")
    table, estimate = pointer(peers, "cf_peer_localization_t"), pointer(estimates, "state_t")
    for i, now in enumerate(ticks.tolist()):
        bend(state, setpoint + i, ffi.addressof(table[i], "peers")[0], sensor + i, estimate + i, now)
        enabled[i] = is_enabled(state)
    signals = {f"setpoint.{name}": values for name, values in columns(bent).items()}
    return Outcome(np.arange(len(ticks)), {**signals, "is_enabled": enabled}, block.failure)
