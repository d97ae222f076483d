"""What a flight by the planners on board comes down to: the figures of each drone, and what it missed."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.summary import rounded
from crazychoir_fw.mission.fleet import FORCE_CONTROLLERS, OUT_OF_TREE
from crazychoir_fw.mission.plan import FlightPlan
from crazychoir_fw.mission.schema import Mission

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog

TRUE_POSITION = ("sim.x", "sim.y", "sim.z")
ESTIMATE = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
SETPOINT = ("ctrltarget.x", "ctrltarget.y", "ctrltarget.z")
THRUST = "stabilizer.thrust"
SUPERVISOR = "supervisor.info"
FLYING_BIT = 0x0010
OFF_THE_FLOOR = 0.05  # [m] above the start
FULL_THRUST = 65535

HOVER_WINDOW = 1.0
"""Length of the steadiest part of a flight, over which the hover thrust is averaged (s)."""

SLACK = 1.0
"""A waypoint is reached when the drone is near it at some moment this long around its tick (s)."""


def judge(mission: Mission, plan: FlightPlan, log: "FlightLog", start: float) -> list[str]:
    """Return what a drone missed, one sentence each, in the order of the flight.

    Args:
        mission: What was flown; its tolerances count.
        plan: Where each drone had to be, and when.
        log: What happened.
        start: Time of the log at which the plan began (s).
    """
    failures = []
    position = _vector(log, TRUE_POSITION)
    for waypoint in plan.waypoints:
        if plan.fleet[waypoint.drone] in mission.may_fail:
            continue
        due = start + waypoint.tick / TICKS_PER_SECOND
        first, last = np.searchsorted(log.time, [due - SLACK / 2, due + SLACK])
        path = position[first:last, waypoint.drone]
        miss = _least(np.linalg.norm(path - waypoint.position, axis=1))
        if not miss <= mission.tolerance.waypoint:
            failures.append(
                f"{plan.fleet[waypoint.drone]}: missed the target of {waypoint.phase} by {miss:.2f} m, "
                f"tolerance {mission.tolerance.waypoint:g} m"
            )
    for name, course, miss in zip(plan.fleet, plan.courses, endpoint_errors(plan, log), strict=True):
        if course.flies_itself:
            continue  # its motor control has a target of its own, which the plan does not hold
        if name not in mission.may_fail and not miss <= mission.tolerance.endpoint:
            failures.append(f"{name}: ended {miss:.2f} m from its target, tolerance {mission.tolerance.endpoint:g} m")
    return failures


def flight_figures(
    plan: FlightPlan, log: "FlightLog", start: float, controllers: Sequence[str | None]
) -> list[dict[str, float | None]]:
    """Return the measured figures of each drone, in the order of the fleet.

    Errors count from a drone's take-off to the end of its landing, while its supervisor says that it flies:
    `rms_error_m` and `max_error_m` between true position and onboard setpoint, `estimator_rms_m` between true position
    and state estimate. `endpoint_error_m` is the distance from the last commanded place at the end of the flight.
    `hover_thrust_percent` is the mean thrust command over the steadiest second, before battery compensation; the
    firmware logs none for a controller that commands newtons, as one that an app brings may. A figure that a flight
    does not have is null.

    Args:
        plan: Where each drone had to be, and when.
        log: What happened.
        start: Time of the log at which the plan began (s).
        controllers: What controls each drone.
    """
    true = _vector(log, TRUE_POSITION)
    tracking = np.linalg.norm(true - _vector(log, SETPOINT), axis=2)
    estimation = np.linalg.norm(true - _vector(log, ESTIMATE), axis=2)
    endpoint = endpoint_errors(plan, log)

    figures = []
    for i in range(len(plan.fleet)):
        flies = _airborne(plan, log, i, start)
        # the supervisor sees a drone flying whose motors have not lifted it yet
        is_off_the_floor = true[:, i, 2] > true[0, i, 2] + OFF_THE_FLOOR
        thrust = hover_thrust(log.time, true[:, i], log.signals[THRUST][:, i], flies & is_off_the_floor)
        figures.append(
            {
                "rms_error_m": rounded(_rms(tracking[flies, i])),
                "max_error_m": rounded(tracking[flies, i].max() if flies.any() else math.nan),
                "endpoint_error_m": rounded(math.nan if plan.courses[i].flies_itself else endpoint[i]),
                "estimator_rms_m": rounded(_rms(estimation[flies, i])),
                "hover_thrust_percent": None
                if controllers[i] in (*FORCE_CONTROLLERS, OUT_OF_TREE)
                else rounded(100.0 * thrust / FULL_THRUST, digits=2),
            }
        )
    return figures


def endpoint_errors(plan: FlightPlan, log: "FlightLog") -> NDArray[np.float64]:
    """Return the distance (m) of each drone from its last commanded place at the end of the log, shape (N,).

    A drone that landed belongs on the floor it started from, at its height of the first sample.
    """
    position = _vector(log, TRUE_POSITION)[:, : len(plan.courses)]
    targets = np.array([course.position for course in plan.courses])
    on_floor = np.array([not course.is_flying for course in plan.courses])
    targets[on_floor, 2] = position[0, on_floor, 2]
    return np.linalg.norm(position[-1] - targets, axis=1)


def hover_thrust(
    time: NDArray[np.float64], position: NDArray[np.float64], thrust: NDArray[Any], is_airborne: NDArray[np.bool_]
) -> float:
    """Return the mean thrust command over the steadiest second of a flight; NaN if it has no whole second.

    Args:
        time: Times of the samples (s), shape (T,), evenly spaced.
        position: True positions (m, world frame), shape (T, 3).
        thrust: Thrust commands, shape (T,).
        is_airborne: Which samples are in flight, shape (T,).
    """
    if len(time) < 3:
        return math.nan
    window = round(HOVER_WINDOW / ((time[-1] - time[0]) / (len(time) - 1)))
    if not 1 <= window <= len(time):
        return math.nan
    speed = np.linalg.norm(np.gradient(position, time, axis=0), axis=1)
    # a window with one sample on the floor is no hover
    speed = np.where(is_airborne, speed, np.inf)
    mean_speed = np.lib.stride_tricks.sliding_window_view(speed, window).mean(axis=1)
    steadiest = int(np.argmin(mean_speed))
    if not np.isfinite(mean_speed[steadiest]):
        return math.nan
    return float(np.mean(thrust[steadiest : steadiest + window], dtype=np.float64))


def _vector(log: "FlightLog", names: tuple[str, str, str]) -> NDArray[np.float64]:
    """Return three signals side by side, shape (T, N, 3)."""
    return np.stack([np.asarray(log.signals[name], dtype=np.float64) for name in names], axis=2)


def _airborne(plan: FlightPlan, log: "FlightLog", drone: int, start: float) -> NDArray[np.bool_]:
    """Return in which samples a drone flies with a setpoint, shape (T,).

    The plan bounds the time: the supervisor notices a landing late, when the setpoint is long gone.
    """
    is_planned = np.zeros(len(log.time), dtype=bool)
    for begin, end in plan.courses[drone].airborne:
        since = log.time - start
        is_planned |= (since > begin / TICKS_PER_SECOND) & (since < end / TICKS_PER_SECOND - 1e-6)
    info = np.asarray(log.signals[SUPERVISOR][:, drone]).astype(np.int64)
    return is_planned & (info & FLYING_BIT > 0)


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan


def _least(values: NDArray[np.float64]) -> float:
    return float(values.min()) if values.size else math.inf
