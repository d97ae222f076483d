"""Steps of the PID cascade with the true state in place of the estimate, beside a published table.

The table is that of docs/reference/vehicle.md#14.3.

    python benchmarks/step_responses.py --json steps.json

Two programs written apart from each other agree on that table. They know neither an estimator nor an 8-bit PWM, fly at
a constant 3.8 V with drag and rotor inertia, on board has the thrust curve of the propellers that are fitted, and all
2.1 have the inertia of the 2.1+. So it is here. All vehicles fly side by side, each 3 m from the next.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw._core import ffi
from crazychoir_fw.onboard import vehicles
from crazychoir_fw.onboard.variables import log_table, parameter_table
from crazychoir_fw.simulation import Drone, DroneConfig, World

APART = 3.0  # [m]
HEIGHT = 1.0  # [m]
NEVER = 0xFFFFFFFF  # [ms]

ALIKE = {
    "ground_effect.enabled": False,
    "flight_moment.enabled": False,
    "drag.form": "linear",
    "drag.body": 0.0,
    "rotors.thrust_scale": 1.0,
    "rotors.duty_bits": 16,
    "battery.constant_voltage": 3.8,
}
IDEAL = {"bias": 0, "mocap_noise": 0, "mocap_attitude_noise": 0, "mocap_latency_ms": 0}
STOCK_INERTIA = {"inertia": [1.657171e-5, 1.6655602e-5, 2.9261652e-5]}
BY_BENCH = {"rotors.law": "quadratic"}  # the motors that docs/reference/vehicle.md#14.3 calls "per DM"

# thrust of a motor (N) that the firmware's builds for these propellers command at least and at most
THRUST_LIMITS = {"legacy": (0.012817578393224994, 0.12), "kit": (0.01922636758983749, 0.18)}


@dataclass(frozen=True)
class Expected:
    """What the reference has: rises from 10 to 90 % (s), overshoots (%), and how far the height dips in the x step."""

    roll: tuple[float, float] | None = None
    x: tuple[float, float] | None = None
    z: tuple[float, float] | None = None
    yaw: tuple[float, float] | None = None
    dip_mm: float | None = None


@dataclass(frozen=True)
class Vehicle:
    """One row of the table."""

    name: str
    expected: Expected
    changes: dict[str, Any]
    platform: str = "cf2"
    propellers: str | None = None  # kit or legacy
    volts: float = 3.8

    def config(self, place: int) -> DroneConfig:
        parts = [self.propellers] if self.propellers else []
        supply = {"battery.constant_voltage": self.volts}
        return DroneConfig(
            f"drone{place}",
            (0.0, APART * place),
            platform=self.platform,
            noise=0,
            attributes=IDEAL,
            vehicle=[*parts, ALIKE, supply, self.changes],
        )


VEHICLES = (
    Vehicle(
        "2.1+",
        Expected(roll=(0.263, 6.9), x=(0.83, 0.4), z=(0.50, 10.2), yaw=(0.284, 3.2), dip_mm=22),
        {"mass": 0.029, **BY_BENCH},
    ),
    Vehicle(
        "2.1+, 0.065 s",
        Expected(roll=(0.242, 5.7), x=(0.83, 0.4), z=(0.56, 10.2), yaw=(0.336, 3.2), dip_mm=17),
        {"mass": 0.029, "rotors.time_constant": 0.065},
    ),
    Vehicle(
        "2.1+, 0.03 s",
        Expected(roll=(0.258, 5.8), x=(0.83, 0.4), z=(0.62, 10.5), yaw=(0.370, 3.6), dip_mm=15),
        {"mass": 0.029, "rotors.time_constant": 0.03},
    ),
    Vehicle(
        "legacy, 31.9 g",
        Expected(roll=(0.273, 8.7), x=(0.83, 0.4), z=(0.49, 10.6), yaw=(0.274, 3.2), dip_mm=30),
        {"mass": 0.0319, **STOCK_INERTIA, **BY_BENCH},
        propellers="legacy",
    ),
    Vehicle(
        "kit, 37.9 g",
        Expected(roll=(0.257, 5.8), x=(0.82, 0.4), z=(0.57, 10.4), yaw=(0.344, 3.4), dip_mm=19),
        {"mass": 0.0379, **STOCK_INERTIA, **BY_BENCH},
        propellers="kit",
    ),
    Vehicle(
        "Brushless",
        Expected(roll=(0.243, 5.7), x=(0.85, 0.4), z=(0.60, 9.5), yaw=(0.322, 3.6), dip_mm=13),
        {"mass": 0.0393, **BY_BENCH},
        platform="cf21bl",
    ),
    Vehicle(
        "Brushless, 0.05 s",
        Expected(roll=(0.248, 5.7), x=(0.85, 0.4), z=(0.61, 9.7), yaw=(0.334, 3.8)),
        {"mass": 0.0393, "rotors.time_constant": 0.05},
        platform="cf21bl",
    ),
    # the other program: motors of 0.07 s at 4.0 V
    Vehicle("2.1+, 0.07 s, 4.0 V", Expected(x=(0.829, 0.4), z=(0.55, 10.7)), {"mass": 0.029}, volts=4.0),
    # docs/reference/vehicle.md#5: how much of the yaw control is the spin-up of the rotors
    Vehicle(
        "2.1+, no rotor inertia",
        Expected(yaw=(0.190, 15.0)),
        {"mass": 0.029, **BY_BENCH, "rotors.inertia": 0.0},
    ),
)


@dataclass
class Response:
    """What a vehicle did: rise (s) and overshoot (%) by the name of the step."""

    vehicle: Vehicle
    steps: dict[str, tuple[float, float]] = field(default_factory=dict)
    dip_mm: float = 0.0


def rise_and_overshoot(times: np.ndarray, values: np.ndarray, start: float, goal: float) -> tuple[float, float]:
    """Return the time from 10 % to 90 % (s) and the overshoot (%) of a step response."""
    fraction = (values - start) / (goal - start)
    rise = times[np.argmax(fraction >= 0.9)] - times[np.argmax(fraction >= 0.1)]
    return float(rise), float(100 * (fraction.max() - 1))


def fit_onboard_curve(drone: Drone, propellers: str) -> None:
    """Give the mixer on board the thrust curve that the firmware has when built for these propellers."""
    before = ffi.offsetof("cf_power_distribution_t", "idle_thrust")
    place = ffi.cast("char *", drone.struct) + parameter_table()["powerDist.idleThrust"].offset - before
    curve = ffi.cast("cf_power_distribution_t *", place).thrust
    numbers = vehicles.overrides([propellers])
    for i, coefficient in enumerate(numbers["rotors.thrust_curve"]):
        setattr(curve, f"c{i}", coefficient)
    curve.thrust_to_torque = numbers["rotors.torque_per_thrust"]
    curve.thrust_min, curve.thrust_max = THRUST_LIMITS[propellers]


class Truth:
    """Tells the Kalman filter of a drone its true state."""

    def __init__(self, drone: Drone) -> None:
        self.drone = drone
        # the vector S is the first member of the filter's core
        place = ffi.cast("char *", drone.struct) + log_table()["kalman.stateX"].offset
        self._core = ffi.cast("kalmanCoreData_t *", place)

    def tell(self) -> None:
        w, x, y, z = self.drone.true_quat_wxyz
        rotation = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
        velocity = self.drone.true_velocity
        body = [sum(row[i] * v for row, v in zip(rotation, velocity, strict=True)) for i in range(3)]
        self._core.S = [*self.drone.true_position, *body, 0.0, 0.0, 0.0]
        self._core.q = [w, x, y, z]
        self._core.R = rotation
        # a prediction would move the filter by the 10 ms since the last one, which it has been told already
        self.drone.struct.onboard.estimator.nextPredictionMs = NEVER


def angles_deg(drone: Drone) -> tuple[float, float]:
    """Return roll and yaw."""
    w, x, y, z = drone.true_quat_wxyz
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return float(np.degrees(roll)), float(np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))))


Command = Callable[[Drone, float], None]  # the drone and its y


def hold(x: float = 0.0, z: float = HEIGHT, yaw: float = 0.0) -> Command:
    return lambda drone, y: drone.commander.send_position_setpoint(x, y, z, yaw)


def lean(roll: float) -> Command:
    return lambda drone, y: drone.commander.send_zdistance_setpoint(roll, 0.0, 0.0, HEIGHT)


def fly(world: World, seconds: float, command: Command, read: Callable[[Drone], Any] | None = None) -> np.ndarray:
    """Command at 100 Hz, tell the truth at 1 kHz; return what `read` gives, shape (ticks, drones, ...)."""
    truths = [Truth(drone) for drone in world.drones]
    values = []
    for tick in range(round(seconds * 1000)):
        for i, truth in enumerate(truths):
            if tick % 10 == 0:
                command(truth.drone, APART * i)
            truth.tell()
        world.step(1)
        if read is not None:
            values.append([read(drone) for drone in world.drones])
    return np.array(values)


def responses() -> list[Response]:
    """Fly all steps with all vehicles."""
    world = World([vehicle.config(i) for i, vehicle in enumerate(VEHICLES)], seed=1, visuals=False)
    for vehicle, drone in zip(VEHICLES, world.drones, strict=True):
        if vehicle.propellers:
            fit_onboard_curve(drone, vehicle.propellers)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(HEIGHT, 2.0)
    world.run(8.0)
    found = [Response(vehicle) for vehicle in VEHICLES]

    def step(name: str, seconds: float, command: Command, read: Callable[[Drone], float], size: float) -> None:
        track = fly(world, seconds, command, read)
        times = 0.001 * np.arange(1, len(track) + 1)
        for response, values in zip(found, track.T, strict=True):
            response.steps[name] = rise_and_overshoot(times, values, values[0], values[0] + size)

    # the vertical integrators are slow
    fly(world, 10.0, hold())
    settled = world.snapshot()
    lowest = [np.inf] * len(found)

    def x_of(drone: Drone) -> float:
        x, _, z = drone.true_position
        i = world.drones.index(drone)
        lowest[i] = min(lowest[i], z)
        return float(x)

    heights = [drone.true_position[2] for drone in world.drones]
    step("x", 3.0, hold(x=1.0), x_of, 1.0)
    for response, height, low in zip(found, heights, lowest, strict=True):
        response.dip_mm = float(1000 * (height - low))
    world.restore(settled)
    step("z", 2.5, hold(z=HEIGHT + 0.5), lambda drone: drone.true_position[2], 0.5)
    world.restore(settled)
    step("yaw", 1.5, hold(yaw=45.0), lambda drone: angles_deg(drone)[1], 45.0)
    world.restore(settled)
    fly(world, 2.0, lean(0.0))
    step("roll", 1.2, lean(10.0), lambda drone: angles_deg(drone)[0], 10.0)
    return found


STEPS = {"roll": "roll step 10°", "x": "x step 1 m", "z": "z step 0.5 m", "yaw": "yaw step 45°"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    table = []
    for response in responses():
        for name, title in STEPS.items():
            expected = getattr(response.vehicle.expected, name)
            if expected is not None:
                (rise, overshoot), ours = expected, response.steps[name]
                print(
                    f"{response.vehicle.name:24s} {title:14s} rise {ours[0]:.3f} s ({rise:.3f}), "
                    f"overshoot {ours[1]:4.1f} % ({overshoot})"
                )
        if response.vehicle.expected.dip_mm is not None:
            print(f"{response.vehicle.name:24s} dip {response.dip_mm:.0f} mm ({response.vehicle.expected.dip_mm})")
        table.append({"vehicle": response.vehicle.name, "steps": response.steps, "dip_mm": response.dip_mm})
    if arguments.json:
        arguments.json.write_text(json.dumps(table, indent=2))


if __name__ == "__main__":
    main()
