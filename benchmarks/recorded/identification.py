"""Parameters of the vehicle that recorded flights share: drag, moment of forward flight, inertia, resistance, heat.

Regressions of what the motion demands on what the model says come first, in the air and below about 3 Hz, where the
truth is precise and the logs are not yet late. Where the desired attitude was logged it is the instrument that finds
time constant and inertia. `refine` has the last word on moments and drag. Mass is given. What
differs from flight to flight (thrust scale, trim, voltage) is taken from each flight's hover, and counts for nothing
here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.nanobench import PERIOD, RecordedFlight
from crazychoir_fw.comparison.phases import Phases, find_phases
from crazychoir_fw.comparison.prediction import predict
from crazychoir_fw.comparison.signals import Array, shifted, smooth
from crazychoir_fw.comparison.tuning import GRAVITY, TICKS_PER_ROW, Balance, balance, rotor_history, true_motion, tune
from crazychoir_fw.comparison.vehicle_model import VehicleModel
from crazychoir_fw.onboard import vehicles
from recorded.instrument import Torques, instrumented, torques
from recorded.motor_heat import common_heat, own_heat
from recorded.refinement import check_refinable, refine

MASS = 0.04085
"""Mass (kg) of NanoBench's vehicle with markers and charging deck."""

_WIDTH = 8  # rows, of the smoothing: 3 dB at 1.7 Hz
_ROUNDS = 3
TIME_CONSTANTS = (0.03, 0.04, 0.05, 0.06, 0.07, 0.085, 0.1, 0.13, 0.16)
"""Time constants of the motors to choose from (s)."""

_FIRST_TIME_CONSTANT = 0.07  # [s], when there are several to choose from
_FIRST_TIME, _FIRST_OWN_TIME = 6.0, 1.5  # [s], in which motors get warm
_CLEAR = 0.5  # [s] at both ends of a trajectory that the instrument leaves out


@dataclass(frozen=True)
class _Balanced:
    """One flight beside the model."""

    state: Balance
    rows: NDArray[np.bool_]
    """In the air, clear of the floor."""
    turning: Array
    """Angular acceleration, body (rad/s²), shape (T, 3)."""
    thrusts: Array
    """Of the motors in the model (N), shape (T, 4)."""
    log_lag: float


@dataclass(frozen=True)
class Identified:
    """What some flights say of the vehicle that they have in common."""

    vehicle: dict[str, Any]
    """Parameters that differ from those of platform cf2, by dotted name."""
    flights: tuple[str, ...]
    """What it was identified from."""
    spread: dict[str, tuple[float, ...]]
    """The same parameters from each flight alone, in the order of `flights`; empty where one alone cannot tell."""
    costs: dict[float, float]
    """For each time constant (s) that was tried what speaks against it: the share of the torque that is wrong in the
    direction of the desired attitude, or the tilt error after 0.2 s (deg) where that was not logged."""


def identify(
    flights: Sequence[RecordedFlight],
    mass: float = MASS,
    time_constants: Sequence[float] = TIME_CONSTANTS,
    refines: bool = True,
    report: Callable[[str], None] = lambda sentence: None,
) -> Identified:
    """Identify a vehicle.

    Args:
        flights: Flights of vehicles of one type.
        mass: Their mass (kg).
        time_constants: Time constants of the motors to choose from (s); the first one is used if it is the only one.
        refines: Whether moments and drag are at last those with which predictions come closest, see `refine`.
        report: Told what goes on, in sentences.

    Raises:
        RangeError: If a flight cannot be used.
        StateError: If refining needs something that is not installed.
    """
    if not flights:
        raise RangeError("no flights to identify a vehicle from")
    if refines:
        check_refinable()
    parts = [(flight, find_phases(flight)) for flight in flights]
    platform = vehicles.parameters("cf2")
    scale = mass / platform["mass"].value
    vehicle: dict[str, Any] = {
        "mass": mass,
        "inertia": tuple(float(value * scale) for value in platform["inertia"].value),
        "drag.form": "rotor",
        "drag.body": 0.0,  # at these speeds it cannot be told from the drag of the rotors
        "drag.rotor_xy": platform["drag.rotor_xy"].value,
        "flight_moment.x": platform["flight_moment.x"].value,
        "flight_moment.y": platform["flight_moment.y"].value,
        "flight_moment.thrust": float(round(mass * GRAVITY, 4)),
        **_time_constant(time_constants[0] if len(time_constants) == 1 else _FIRST_TIME_CONSTANT),
        "rotors.heat_loss": 0.0,
        "rotors.heat_time": _FIRST_TIME,
        "rotors.heat_own_loss": 0.0,
        "rotors.heat_own_time": _FIRST_OWN_TIME,
        "rotors.heat_thrust": float(round(mass * GRAVITY / 4, 4)),
    }
    spread: dict[str, tuple[float, ...]] = {}
    costs: dict[float, float] = {}
    for number in range(_ROUNDS):
        vehicle |= _heat(parts, vehicle)
        balances = [_balance(flight, phases, vehicle) for flight, phases in parts]
        changes, spread = _regress(balances, vehicle)
        vehicle |= changes
        report(
            f"round {number + 1}: cold motors deliver {100 * vehicle['rotors.heat_loss']:.1f} % more and get warm in "
            f"{vehicle['rotors.heat_time']:g} s, harder working ones lose "
            f"{100 * vehicle['rotors.heat_own_loss']:.1f} % in {vehicle['rotors.heat_own_time']:g} s, {_words(changes)}"
        )
        if number == 0 and len(time_constants) > 1:
            changes, costs = _choose_time_constant(parts, vehicle, time_constants)
            vehicle |= changes
            report(f"what speaks against a time constant: {', '.join(f'{t:g} s {c:.4g}' for t, c in costs.items())}")
    if (found := _instrumented(parts, vehicle)) is not None:
        vehicle["inertia"] = found[0]
        report(f"by the desired attitude: {_words({'inertia': found[0]})}")
    if refines:
        vehicle |= refine(parts, vehicle, report)
    resistances = [r for flight, phases in parts if (r := _resistance(flight, phases, vehicle)) is not None]
    if resistances:
        slow = platform["battery.slow_resistance"].value
        vehicle["battery.resistance"] = float(max(np.median(resistances) - slow, 0.0))
        spread["battery.resistance"] = tuple(float(r - slow) for r in resistances)
    return Identified(vehicle, tuple(flight.name for flight in flights), spread, costs)


def _words(changes: Mapping[str, Any]) -> str:
    values = {name: value if isinstance(value, tuple) else (value,) for name, value in changes.items()}
    return ", ".join(f"{name} {' '.join(f'{part:.3g}' for part in value)}" for name, value in values.items())


def _time_constant(tau: float) -> dict[str, float]:
    return {"rotors.time_constant_up": float(tau), "rotors.time_constant_down": float(tau)}


def _used(flight: RecordedFlight, phases: Phases) -> Array:
    """Return the rows in the air, clear of the floor."""
    clear = flight.position[:, 2] > np.min(flight.position[:, 2]) + 0.25
    return (flight.time > phases.airborne + 0.5) & (flight.time < phases.end - 0.2) & clear


def _balance(flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any]) -> _Balanced:
    tuning = tune(flight, phases, vehicle)
    model = VehicleModel({**vehicle, **tuning.overrides()})
    history = rotor_history(model, flight, tuning.log_lag)
    motion = true_motion(flight, np.array(tuning.misalignment))
    return _Balanced(
        balance(model, history, motion),
        _used(flight, phases),
        motion.angular_acceleration,
        history.thrusts()[::TICKS_PER_ROW],
        tuning.log_lag,
    )


def _regress(
    balances: Sequence[_Balanced], vehicle: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, tuple[float, ...]]]:
    """Return corrected parameters of all flights together, and of each alone."""
    drags, moments = [], {"x": [], "y": []}
    for balanced in balances:
        state, rows = balanced.state, balanced.rows
        lacking_force = smooth(state.needed_force - state.model_force, _WIDTH)[rows]
        lacking_torque = smooth(state.needed_torque - state.model_torque, _WIDTH)[rows]
        velocity = smooth(state.velocity, _WIDTH)[rows]
        thrust = smooth(state.thrust, _WIDTH)[rows] / vehicle["flight_moment.thrust"]
        turning = smooth(balanced.turning, _WIDTH)[rows]
        speeds = -velocity[:, :2]
        drags.append((lacking_force[:, :2], speeds))
        # with inertia I and I0 in the model: lacking = (I0 - I) a - (k - k0) (...)
        moments["x"].append((lacking_torque[:, 0], np.column_stack([thrust * velocity[:, 1], turning[:, 0]])))
        moments["y"].append((lacking_torque[:, 1], np.column_stack([-thrust * velocity[:, 0], turning[:, 1]])))

    # drag of all rotors per speed, as the model has it: k sum(Omega)
    per_newton = _drag_of_model(vehicle)
    alone = [_pooled([(force[:, i], speed[:, i : i + 1]) for i in (0, 1)])[0] for force, speed in drags]
    both = _pooled([(force[:, i], speed[:, i : i + 1]) for force, speed in drags for i in (0, 1)])[0]
    before = vehicle["drag.rotor_xy"]
    changes: dict[str, Any] = {"drag.rotor_xy": _positive(before + both / per_newton)}
    spread = {"drag.rotor_xy": tuple(float(before + value / per_newton) for value in alone)}
    inertia = list(vehicle["inertia"])
    for axis, name in enumerate("xy"):
        k, excess = _pooled(moments[name])
        parameter = f"flight_moment.{name}"
        changes[parameter] = _positive(vehicle[parameter] + k)
        spread[parameter] = tuple(float(vehicle[parameter] + _pooled([part])[0]) for part in moments[name])
        # what the demand exceeds the model by, in proportion to the acceleration, is too much inertia
        inertia[axis] = float(np.clip(inertia[axis] - excess, 0.6 * inertia[axis], 1.6 * inertia[axis]))
        spread[f"inertia.{name}"] = tuple(
            float(vehicle["inertia"][axis] - _pooled([part])[1]) for part in moments[name]
        )
    inertia[2] = inertia[2] * (inertia[0] + inertia[1]) / (vehicle["inertia"][0] + vehicle["inertia"][1])
    changes["inertia"] = tuple(inertia)
    return changes, spread


def _positive(value: float) -> float:
    return float(max(value, 0.0))


def _pooled(parts: Sequence[tuple[Array, Array]]) -> Array:
    """Return the coefficients of all parts together, each with a constant of its own."""
    y = np.concatenate([part - part.mean() for part, _ in parts])
    x = np.vstack([columns - columns.mean(axis=0) for _, columns in parts])
    return np.linalg.lstsq(x, y, rcond=None)[0]


def _drag_of_model(vehicle: Mapping[str, Any]) -> float:
    """Return force per speed of the rotor drag at hover (N s/m) per unit of drag.rotor_xy."""
    model = VehicleModel({**vehicle, "drag.rotor_xy": 1e-6, "flight_moment.enabled": "off"})
    platform = vehicles.parameters("cf2")
    # speed at which four rotors carry the mass: F = f1 n + f2 n^2
    f1, f2 = platform["rotors.thrust_per_rpm"].value, platform["rotors.thrust_per_rpm2"].value
    force = model.mass * GRAVITY / 4
    rpm = (-f1 + np.sqrt(f1 * f1 + 4 * f2 * force)) / (2 * f2)
    return float(4 * rpm * np.pi / 30)


def _heat(parts: Sequence[tuple[RecordedFlight, Phases]], vehicle: Mapping[str, Any]) -> dict[str, Any]:
    """Return how motors fade: all alike while they fly, and the harder working ones besides."""
    weight, arms = vehicle["rotors.heat_thrust"], (_platform("rotors.arm_x"), _platform("rotors.arm_y"))
    forces = []
    for flight, phases in parts:
        balanced = _balance(flight, phases, {**vehicle, "rotors.heat_loss": 0.0})
        state = balanced.state
        drag = state.model_force[:, 2] - state.thrust
        later = balanced.rows & (flight.time >= phases.rest)
        forces.append((state.needed_force[:, 2] - drag, state.thrust, later))
    loss, time = common_heat(forces, weight, PERIOD)
    changes = {"rotors.heat_loss": loss, "rotors.heat_time": time}
    turns = []
    for flight, phases in parts:
        balanced = _balance(flight, phases, {**vehicle, **changes, "rotors.heat_own_loss": 0.0})
        state = balanced.state
        later = balanced.rows & (flight.time >= phases.rest)
        turns.append((state.needed_torque - state.model_torque, balanced.thrusts, _flying(state, vehicle), later))
    loss, time = own_heat(turns, weight, arms, _WIDTH, PERIOD)
    return {**changes, "rotors.heat_own_loss": loss, "rotors.heat_own_time": time}


def _platform(name: str) -> float:
    return float(vehicles.parameters("cf2")[name].value)


def _flying(state: Balance, vehicle: Mapping[str, Any]) -> Array:
    """Return what the moment of forward flight goes with about x and y (m/s), shape (T, 2)."""
    share = state.thrust / vehicle["flight_moment.thrust"]
    return np.column_stack([share * state.velocity[:, 1], -share * state.velocity[:, 0]])


def _choose_time_constant(
    parts: Sequence[tuple[RecordedFlight, Phases]], vehicle: Mapping[str, Any], choices: Sequence[float]
) -> tuple[dict[str, float], dict[float, float]]:
    """Return the time constant that the instrument prefers, and what speaks against each that was tried."""
    costs = {}
    for tau in choices:
        tried = {**vehicle, **_time_constant(tau)}
        found = _instrumented(parts, tried)
        costs[float(tau)] = _tilt_error(parts, tried) if found is None else found[1]
    times, values = np.array(sorted(costs)), np.array([costs[tau] for tau in sorted(costs)])
    best = int(np.argmin(values))
    tau = float(times[best])
    if 0 < best < len(times) - 1:
        near = slice(best - 1, best + 2)
        bend, slope, _ = np.polyfit(np.log(times[near] / tau), values[near], 2)
        tau = round(float(tau * np.exp(-slope / (2 * bend))), 4)
    return _time_constant(tau), costs


def _instrumented(
    parts: Sequence[tuple[RecordedFlight, Phases]], vehicle: Mapping[str, Any]
) -> tuple[tuple[float, float, float], float] | None:
    """Return inertia (kg m²) and the share of the torque that is wrong; None without a desired attitude."""
    axes: tuple[list[Torques], list[Torques]] = [], []
    for flight, phases in parts:
        if flight.desired is None:
            continue
        balanced = _balance(flight, phases, vehicle)
        desired = shifted(flight.time, flight.desired[:, :2], balanced.log_lag)
        rows = (flight.time > phases.trajectory + _CLEAR) & (flight.time < phases.end - _CLEAR)
        flying = _flying(balanced.state, vehicle)
        for axis, found in enumerate(axes):
            motion = np.column_stack([balanced.turning[:, axis], flying[:, axis]])
            found.append(torques(flight.time, balanced.state.model_torque[:, axis], motion, desired, rows))
    if not axes[0]:
        return None
    (first, wrong_x), (second, wrong_y) = (instrumented(found) for found in axes)
    before = vehicle["inertia"]
    x, y = float(first[0]), float(second[0])
    return (x, y, float(before[2] * (x + y) / (before[0] + before[1]))), 0.5 * (wrong_x + wrong_y)


def _tilt_error(parts: Sequence[tuple[RecordedFlight, Phases]], vehicle: Mapping[str, Any]) -> float:
    errors = []
    for flight, phases in parts:
        prediction = predict(flight, phases, vehicle, tune(flight, phases, vehicle))
        errors.append(prediction.followed_tilt_deg[1])
    return float(np.mean(errors))


def _resistance(flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any]) -> float | None:
    """Return the resistance (Ohm) that explains the sag from rest to hover; None without rest or hover."""
    rest = (flight.time < phases.motors_on - 0.3) & (flight.time > phases.motors_on - 1.5)
    hover = (flight.time >= phases.hovering[0]) & (flight.time < phases.hovering[1])
    if rest.sum() * PERIOD < 0.3 or hover.sum() * PERIOD < 0.3:
        return None
    known = vehicles.parameters("cf2")
    base, slope = known["battery.base_power"].value, known["battery.power_per_thrust"].value
    state = _balance(flight, phases, vehicle).state
    volts = flight.voltage
    loaded = float(np.mean((base + slope * state.thrust[hover]) / volts[hover]))
    idle = float(np.mean(base / volts[rest]))
    return float((volts[rest].mean() - volts[hover].mean()) / (loaded - idle))
