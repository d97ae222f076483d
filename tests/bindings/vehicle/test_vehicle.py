"""The whole vehicle: config, determinism, memory, logs, a fall and a flight to the end of the pack."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

Make = Callable[..., Any]


SYSTEMS = {
    name.removeprefix("CF_POSITIONING_").lower(): getattr(lib, name)
    for name in dir(lib)
    if name.startswith("CF_POSITIONING_") and name != "CF_POSITIONING_COUNT"
}


def trace(vehicle: Any, ticks: int = 300) -> bytes:
    """Return every bit of a vehicle that flew through some ticks."""
    ratios = ffi.new("uint16_t[4]")
    zeros, force = ffi.new("float[3]"), ffi.new("float[3]", [0.1, 0.2, 9.81])
    quat, eye = ffi.new("float[4]", [1, 0, 0, 0]), ffi.new("float[9]", np.eye(3).ravel().tolist())
    gyro, acc = ffi.new("Axis3i16 *"), ffi.new("Axis3i16 *")
    pose, flow = ffi.new("poseMeasurement_t *"), ffi.new("cf_flow_reading_t *")
    sweeps, ranging = ffi.new("cf_sweep_t[2]"), ffi.new("cf_ranging_t *")
    place = ffi.new("float[3]", [0.1, 0.2, 0.8])
    out = b""
    for tick in range(ticks):
        for i in range(4):
            ratios[i] = (30000 + 97 * tick * (i + 1)) % 65536
        lib.cf_vehicle_actuate(vehicle, ratios)
        lib.cf_vehicle_imu(vehicle, zeros, force, gyro, acc)
        lib.cf_vehicle_mocap(vehicle, force, quat, pose)
        lib.cf_vehicle_flow_deck(vehicle, 1.0, eye, force, zeros, flow)
        lib.cf_vehicle_lighthouse(vehicle, place, eye, sweeps)
        lib.cf_vehicle_loco(vehicle, place, ranging)
        out += b"".join(bytes(ffi.buffer(x)) for x in (gyro, acc, pose, flow, sweeps, ranging))
    return out + bytes(ffi.buffer(vehicle))


@pytest.fixture(params=SYSTEMS)
def fitted(request: Any, make_vehicle: Make) -> Make:
    """Return a function that makes a vehicle with one of the positioning systems."""

    def change(config: Any) -> None:
        config.positioning = SYSTEMS[request.param]

    return lambda **options: make_vehicle(change=change, **options)


def test_same_seed_and_id_give_the_same_bits(fitted: Make) -> None:
    assert trace(fitted(seed=4, drone_id=2)) == trace(fitted(seed=4, drone_id=2))


@pytest.mark.parametrize(("seed", "drone_id"), [(4, 3), (5, 2)])
def test_other_seed_or_id_gives_other_noise(fitted: Make, seed: int, drone_id: int) -> None:
    assert trace(fitted(seed=4, drone_id=2)) != trace(fitted(seed=seed, drone_id=drone_id))


def test_drones_of_one_world_share_base_stations_and_anchors(make_vehicle: Make) -> None:
    def room(system: int, member: str, seed: int, drone_id: int) -> bytes:
        def change(config: Any) -> None:
            config.positioning = system

        vehicle = make_vehicle(change=change, seed=seed, drone_id=drone_id)
        part = getattr(vehicle.lighthouse if member == "stations" else vehicle.loco, member)
        return bytes(ffi.buffer(part))

    for system, member in ((lib.CF_POSITIONING_LIGHTHOUSE, "stations"), (lib.CF_POSITIONING_LOCO_TWR, "bias")):
        assert room(system, member, 4, 0) == room(system, member, 4, 1)
        assert room(system, member, 4, 0) != room(system, member, 5, 0)


@pytest.mark.parametrize("number", [-1, 8, 2**31 - 1])
def test_unknown_positioning_is_refused(make_config: Make, number: int) -> None:
    config = make_config()
    ffi.cast("int *", ffi.addressof(config, "positioning"))[0] = number
    assert lib.cf_vehicle_init(ffi.new("cf_vehicle_t *"), config, 1, 0) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("system", SYSTEMS)
def test_only_the_fitted_system_measures(make_vehicle: Make, system: str) -> None:
    def change(config: Any) -> None:
        config.positioning = SYSTEMS[system]

    vehicle = make_vehicle(change=change)
    zeros, quat, eye = ffi.new("float[3]"), ffi.new("float[4]", [1, 0, 0, 0]), ffi.new("float[9]", [1, 0, 0] * 3)
    eye[0], eye[4], eye[8] = 1.0, 1.0, 1.0
    place = ffi.new("float[3]", [0.1, 0.2, 0.8])
    counts = dict.fromkeys(("mocap", "flow", "lighthouse", "loco"), 0)
    for _ in range(200):
        counts["mocap"] += lib.cf_vehicle_mocap(vehicle, place, quat, ffi.new("poseMeasurement_t *"))
        counts["flow"] += lib.cf_vehicle_flow_deck(vehicle, 1.0, eye, zeros, zeros, ffi.new("cf_flow_reading_t *"))
        counts["lighthouse"] += lib.cf_vehicle_lighthouse(vehicle, place, eye, ffi.new("cf_sweep_t[2]"))
        counts["loco"] += lib.cf_vehicle_loco(vehicle, place, ffi.new("cf_ranging_t *"))
    assert {name for name, count in counts.items() if count} == {system.split("_")[0]} - {"none"}


def test_copy_of_the_memory_flies_on_alike(make_vehicle: Make) -> None:
    vehicle = make_vehicle()
    trace(vehicle)
    copy = ffi.new("cf_vehicle_t *")
    ffi.memmove(copy, vehicle, ffi.sizeof("cf_vehicle_t"))
    assert trace(copy) == trace(vehicle)


def test_sensors_have_dice_of_their_own(make_vehicle: Make) -> None:
    """Not asking one sensor leaves the noise of the others as it was."""
    one, other = make_vehicle(), make_vehicle()
    zeros, quat = ffi.new("float[3]"), ffi.new("float[4]", [1, 0, 0, 0])
    pose = ffi.new("poseMeasurement_t *")
    for _ in range(100):
        lib.cf_vehicle_mocap(one, zeros, quat, pose)
    samples = []
    for vehicle in (one, other):
        gyro, acc = ffi.new("Axis3i16 *"), ffi.new("Axis3i16 *")
        lib.cf_vehicle_imu(vehicle, zeros, zeros, gyro, acc)
        samples.append(bytes(ffi.buffer(gyro)) + bytes(ffi.buffer(acc)))
    assert samples[0] == samples[1]


def test_vehicle_is_small_and_fills_whole_doubles() -> None:
    # 1 KiB are poses of the motion capture under way; wind (112), rangers (64), ground effect (44), the walk and the
    # lines of the IMU (100), efficiency and warmth of each rotor (40 with its parameters), the warmth that all
    # rotors have in common (16 with its parameters), spells and qualities of the motion capture (128) came on top of
    # 1600
    assert ffi.sizeof("cf_vehicle_t") <= 2168
    assert ffi.sizeof("cf_vehicle_t") % 8 == 0


NUMBERS = [
    ("airframe.mass", 0.0),
    ("airframe.mass", float("nan")),
    ("airframe.landed_height", -0.1),
    ("airframe.rotors.time_constant_up", 0.0),
    ("airframe.rotors.time_constant_up", float("nan")),
    ("airframe.rotors.thrust_per_rpm2", 0.0),
    ("airframe.rotors.linear_voltage", 0.0),
    ("airframe.rotors.linear_voltage", 0.3),  # the cubic is negative there
    ("airframe.rotors.hover_rpm", 0.0),
    ("airframe.rotors.arm_x", -0.03),
    ("airframe.rotors.inertia", -1e-9),
    ("airframe.rotors.height", float("inf")),
    ("airframe.rotors.duty_bits", 0),
    ("airframe.rotors.duty_bits", 17),
    ("airframe.rotors.duty_lowest_level", -1),
    ("airframe.rotors.curve.c0", float("nan")),
    ("airframe.rotors.curve.thrust_to_torque", -0.1),
    ("airframe.aerodynamics.form", 3),
    ("airframe.aerodynamics.drag_xy", -0.1),
    ("airframe.aerodynamics.drag_z", float("nan")),
    ("airframe.aerodynamics.rotor_drag_xy", -1e-6),
    ("airframe.aerodynamics.rotor_drag_z", float("inf")),
    ("airframe.aerodynamics.body_drag", float("nan")),
    ("airframe.aerodynamics.flight_moment_x", -1e-4),
    ("airframe.aerodynamics.flight_moment_y", float("nan")),
    ("airframe.aerodynamics.flight_moment_thrust", 0.0),
    ("airframe.battery.capacity", -1.0),
    ("airframe.imu.noise_scale", float("nan")),
    ("mocap.position_noise", float("nan")),
    ("flow_deck.flow_noise", -1.0),
    ("lighthouse.noise", float("nan")),
    ("loco.bias", -0.1),
]


@pytest.mark.parametrize(("path", "value"), NUMBERS)
def test_impossible_config_is_refused_and_leaves_the_vehicle(
    make_config: Make, make_vehicle: Make, path: str, value: float
) -> None:
    vehicle = make_vehicle()
    before = bytes(ffi.buffer(vehicle))
    config = make_config()
    *parents, name = path.split(".")
    place: Any = config
    for parent in parents:
        place = getattr(place, parent)
    setattr(place, name, value)
    assert lib.cf_vehicle_init(vehicle, config, 1, 0) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(vehicle)) == before


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("value", [0.0, -1e-6, float("nan")])
def test_impossible_inertia_is_refused(make_config: Make, axis: int, value: float) -> None:
    config = make_config()
    config.airframe.inertia[axis] = value
    assert lib.cf_vehicle_init(ffi.new("cf_vehicle_t *"), config, 1, 0) == lib.CF_ERR_VALUE


def test_too_long_delay_line_is_refused(make_config: Make) -> None:
    config = make_config()
    config.mocap.latency_ms = 1000
    assert lib.cf_vehicle_init(ffi.new("cf_vehicle_t *"), config, 1, 0) == lib.CF_ERR_CAPACITY


def test_unknown_platform_has_no_config() -> None:
    number = ffi.cast("cf_platform_t", 7)
    assert lib.cf_vehicle_default_config(ffi.new("cf_vehicle_config_t *"), number) == lib.CF_ERR_UNKNOWN


def test_logs_name_what_only_the_simulator_knows(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle()
    run(vehicle, [20000, 30000, 40000, 50000], 500)
    table = lib.cf_vehicle_logs()
    start = ffi.cast("char *", vehicle)
    values = {}
    for row in table.rows[0 : table.count]:
        assert row.type == lib.CF_TYPE_FLOAT
        name = f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}"
        values[name] = ffi.cast("float *", start + table.base + row.offset)[0]
    expected = {f"sim.rpm{i + 1}": vehicle.rotors.rpm[i] for i in range(4)}
    expected |= {f"sim.thrust{i + 1}": vehicle.rotors.thrust[i] for i in range(4)}
    expected |= {"sim.current": vehicle.battery.current, "sim.charge": vehicle.battery.charge}
    expected |= {f"sim.wind{axis}": vehicle.wind.velocity[i] for i, axis in enumerate("XYZ")}
    expected |= {"sim.downwash": vehicle.downwash, "sim.groundGain": vehicle.ground_effect.gain[0]}
    assert values == expected


def test_thrust_points_along_the_body(make_vehicle: Make, run: Make, wrench: Make) -> None:
    vehicle = make_vehicle()
    run(vehicle, [40000] * 4, 500)
    rotation = Rotation.from_euler("xyz", [0.4, -0.3, 1.0]).as_matrix()
    force, _ = wrench(vehicle, rotation)
    total = sum(vehicle.rotors.thrust)
    assert force == pytest.approx(total * rotation[:, 2], rel=1e-5)


def test_free_fall_in_vacuum_is_exact(make_vehicle: Make, wrench: Make) -> None:
    def change(config: Any) -> None:
        config.airframe.aerodynamics.form = lib.CF_DRAG_NONE
        config.airframe.aerodynamics.body_drag = 0.0

    force, torque = wrench(make_vehicle(change=change), velocity=(1, 2, -30), rates=(5, 6, 7))
    assert (force == 0).all()
    assert (torque == 0).all()


def test_full_duty_fades_as_the_pack_empties(make_vehicle: Make, run: Make) -> None:
    vehicle = make_vehicle()
    run(vehicle, [65535] * 4, 1000)
    fresh = vehicle.rotors.thrust[0]
    sag = 4.2 - vehicle.battery.voltage
    run(vehicle, [65535] * 4, 120_000)
    assert 0.6 < sag < 1.2
    assert vehicle.rotors.thrust[0] < 0.9 * fresh
    assert vehicle.battery.charge < 0.6


def test_torque_of_the_heaviest_yaw_command_has_the_right_sign(make_vehicle: Make, run: Make, wrench: Make) -> None:
    """Clockwise rotors faster: the body turns counter-clockwise."""
    vehicle = make_vehicle()
    run(vehicle, [20000, 50000, 20000, 50000], 300)
    assert wrench(vehicle)[1][2] > 3e-4


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf"), 3e38])
def test_broken_motion_neither_traps_nor_reaches_the_motors(
    make_vehicle: Make, run: Make, wrench: Make, bad: float
) -> None:
    vehicle = make_vehicle()
    run(vehicle, [40000] * 4, 100)
    wrench(vehicle, velocity=(bad, 0, 0), rates=(0, bad, 0))
    trace(vehicle, 50)
    assert np.isfinite(list(vehicle.rotors.rpm)).all()
    assert np.isfinite(vehicle.battery.voltage)
