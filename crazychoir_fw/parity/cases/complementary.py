"""The complementary estimator: recorded samples of the inertial sensors, the barometer and the range finder."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.cases.kalman import measurement_types
from crazychoir_fw.parity.inputs import FlightInputs, Inputs
from crazychoir_fw.parity.structs import columns, dtype_of, pointer, zeros

_SAMPLES = {
    "gyro": (lib.MeasurementTypeGyroscope, "Axis3f"),
    "acc": (lib.MeasurementTypeAcceleration, "Axis3f"),
    "baro": (lib.MeasurementTypeBarometer, "baro_t"),
    "tof": (lib.MeasurementTypeTOF, "tofMeasurement_t"),
}


def complementary_cases(inputs: Inputs) -> list[Case]:
    """Return the cases of the estimator: flights with a range finder, with the barometer alone, and a second start."""
    cases = []
    for name, about, restart in (
        ("complementary", "range and barometer", False),
        ("flow", "range and barometer, measured while the Kalman filter flew", False),
        ("pid", "barometer alone, every kind of set-point", False),
        ("position", "barometer alone, and a new start in the middle", True),
    ):
        if name in inputs.flights:
            cases.append(
                Case(
                    group="complementary",
                    name=f"flight {name}" + (", restarted" if restart else ""),
                    about=about,
                    run=functools.partial(_replay, flight=inputs.flights[name], is_restarted=restart),
                    needs=("complementary_init", "complementary"),
                    log_groups=("sensfusion6", "posEstAlt"),
                )
            )
    return cases


def latest_samples(flight: FlightInputs) -> NDArray[Any]:
    """Return what the estimator looks at in each tick: the latest sample of each sensor, shape (T,)."""
    ticks = flight.tracks["tick"]
    kinds = measurement_types(flight)
    offset = ffi.offsetof("measurement_t", "data")
    found = zeros("cf_latest_samples_t", len(ticks))
    for name, (kind, c_type) in _SAMPLES.items():
        mine = flight.measurements[kinds == kind]
        size = ffi.sizeof(c_type)
        values = np.ascontiguousarray(mine["measurement"][:, offset : offset + size]).view(dtype_of(c_type))[:, 0]
        latest = np.searchsorted(mine["tick"], ticks, "right") - 1
        found[name][latest >= 0] = values[latest[latest >= 0]]
    return found


def _replay(request: CaseRequest, flight: FlightInputs, is_restarted: bool) -> Outcome:
    ticks = flight.tracks["tick"]
    samples = latest_samples(flight)
    block = request.boot(flight)
    functions, state = block.functions, block.state
    functions["complementary_init"](state)
    logs = request.gatherer(block, len(ticks))
    estimates = zeros("state_t", len(ticks))
    latest, kept = pointer(samples, "cf_latest_samples_t"), pointer(estimates, "state_t")
    estimate = ffi.new("state_t *")  # one, which keeps what is not written
    update = functions["complementary"]
    steps = flight.tracks["step"].tolist()
    with logs:
        for i, now in enumerate(ticks.tolist()):
            if is_restarted and i == len(ticks) // 2:
                functions["complementary_init"](state)
            update(state, latest + i, estimate, steps[i], now)
            kept[i] = estimate[0]
            logs.take(i)
    return Outcome(ticks, {**columns(estimates, "estimate"), **logs.signals()}, block.failure)
