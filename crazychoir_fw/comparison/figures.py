"""The figures of docs/real_flights.md, by name, as plain data for files and tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.comparison.controller_replay import replay_controller
from crazychoir_fw.comparison.motor_replay import replay_motors
from crazychoir_fw.comparison.nanobench import RecordedFlight
from crazychoir_fw.comparison.phases import Phases
from crazychoir_fw.comparison.prediction import HORIZONS, predict
from crazychoir_fw.comparison.tuning import Tuning
from crazychoir_fw.comparison.whole_chain import ChainComparison

Figures = dict[str, Any]
Result = TypeVar("Result")


class Attempts:
    """Does one thing after the other, and keeps the sentences of those that could not be done."""

    def __init__(self) -> None:
        self.problems: list[str] = []

    def __call__(self, what: str, work: Callable[[], Result]) -> Result | None:
        """Return what some work returns, or None if it cannot be done."""
        try:
            return work()
        except CrazychoirError as error:
            self.problems.append(f"{what}: {error}")
            return None


def controller_figures(flight: RecordedFlight, phases: Phases) -> Figures:
    """Compare our controller with what it logged, see `replay_controller`."""
    replay = replay_controller(flight, phases)
    return {
        "controller_roll_rms_deg": replay.roll_rms_deg,
        "controller_pitch_rms_deg": replay.pitch_rms_deg,
        "controller_roll_median_deg": replay.roll_median_deg,
        "controller_pitch_median_deg": replay.pitch_median_deg,
        "controller_thrust_rms_percent": replay.thrust_rms_percent,
        "controller_thrust_offset_only_rms_percent": replay.thrust_offset_rms_percent,
    }


def motor_figures(flight: RecordedFlight, phases: Phases) -> Figures:
    """Compare mixer and battery compensation, see `replay_motors`."""
    motors = replay_motors(flight, phases)
    return {
        "motor_mean_percent": list(motors.mean_percent),
        "motor_worst_mean_percent": motors.worst_mean_percent,
        "motor_rms_percent": list(motors.rms_percent),
        "motor_saturated_share": motors.saturated_share,
        "firmware_thrust_max_n": motors.thrust_max,
    }


def hover_figures(tuning: Tuning) -> Figures:
    """Return what the hover of the flight says of its vehicle."""
    return {
        "thrust_scale": tuning.thrust_scale,
        "trim_torque_nm": list(tuning.trim_torque),
        "voltage_v": tuning.hover_voltage,
        "thrust_axis_off_deg": tuning.misalignment_deg,
        "log_lag_s": tuning.log_lag,
        "seconds": tuning.hover_seconds,
    }


def plant_figures(flight: RecordedFlight, phases: Phases, vehicle: Mapping[str, Any], tuning: Tuning) -> Figures:
    """Compare the plant without any feedback, see `predict`."""
    ahead = predict(flight, phases, vehicle, tuning)
    return {
        "plant_horizons_s": list(HORIZONS),
        "plant_position_cm": list(ahead.position_cm),
        "plant_tilt_deg": list(ahead.tilt_deg),
        "plant_mean_position_cm": list(ahead.mean_position_cm),
        "plant_mean_tilt_deg": list(ahead.mean_tilt_deg),
        "plant_followed_position_cm": list(ahead.followed_position_cm),
        "plant_followed_tilt_deg": list(ahead.followed_tilt_deg),
        "plant_followed_tilt_median_deg": list(ahead.followed_tilt_median_deg),
        "plant_trim_wander_nm": ahead.trim_wander,
    }


def chain_figures(chain: ChainComparison) -> Figures:
    """Return how whole flights differ."""
    return {
        "path_rms_m": chain.path_rms_m,
        "lag_s": chain.lag_s,
        "lag_behind_setpoint_real_s": chain.lag_behind_setpoint_s[0],
        "lag_behind_setpoint_simulated_s": chain.lag_behind_setpoint_s[1],
        "tracking_rms_real_m": chain.tracking_rms_m[0],
        "tracking_rms_simulated_m": chain.tracking_rms_m[1],
        "tracking_percent": chain.tracking_percent,
        "tilt_rms_real_deg": chain.tilt_rms_deg[0],
        "tilt_rms_simulated_deg": chain.tilt_rms_deg[1],
        "tilt_percent": chain.tilt_percent,
        "thrust_percent": chain.thrust_percent,
        "voltage_difference_v": chain.voltage_difference_v,
    }
