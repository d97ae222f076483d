"""The vehicle with broken motion, broken configs and the ends of every range."""

import math
from itertools import product

import numpy as np
import pytest
from extremes import FEW, leaves

from crazychoir_fw._core import ffi, lib

EYE = [1, 0, 0, 0, 1, 0, 0, 0, 1]
PLATFORMS = range(lib.CF_PLATFORM_COUNT)
SYSTEMS = range(lib.CF_POSITIONING_COUNT)


@pytest.fixture
def config_of():
    def make(platform=lib.CF_PLATFORM_CF2, positioning=lib.CF_POSITIONING_MOCAP):
        config = ffi.new("cf_vehicle_config_t *")
        assert lib.cf_vehicle_default_config(config, platform) == lib.CF_OK
        config.positioning = positioning
        return config

    return make


@pytest.fixture
def vehicle_of(config_of):
    def make(*which):
        vehicle = ffi.new("cf_vehicle_t *")
        assert lib.cf_vehicle_init(vehicle, config_of(*which), 1, 2) == lib.CF_OK
        return vehicle

    return make


def survives(vehicle, odd=1.0, place=0, ticks=60):
    """Let every sensor measure a motion with one broken number, and check what it says."""
    motion = {
        "position": [0.1, 0.2, 1], "quat": [1, 0, 0, 0], "rotation": list(EYE),
        "velocity": [0, 0, 0], "rates": [0, 0, 0], "force": [0, 0, 9.81],
    }  # fmt: skip
    places = ["position", 2], ["quat", 0], ["rotation", 8], ["rotation", 0], ["velocity", 0], ["rates", 1], ["force", 2]
    motion[places[place][0]][places[place][1]] = odd
    position, quat, rotation, velocity, rates, force = (ffi.new("float[]", values) for values in motion.values())
    gyro, acc, pose, reading, ranging = (
        ffi.new(f"{kind} *")
        for kind in ("Axis3i16", "Axis3i16", "poseMeasurement_t", "cf_flow_reading_t", "cf_ranging_t")
    )
    sweeps, ranges = ffi.new("cf_sweep_t[]", lib.CF_LIGHTHOUSE_STATIONS), ffi.new("uint16_t[]", lib.CF_RANGE_COUNT)
    pressure, temperature, f, t = (ffi.new("float[3]") for _ in range(4))
    for _ in range(ticks):
        lib.cf_vehicle_imu(vehicle, rates, force, gyro, acc)
        lib.cf_vehicle_mocap(vehicle, position, quat, pose)
        lib.cf_vehicle_flow_deck(vehicle, position[2], rotation, velocity, rates, reading)
        assert reading.range < 5000 or reading.range == lib.CF_RANGE_NOTHING
        for i in range(lib.cf_vehicle_lighthouse(vehicle, position, rotation, sweeps)):
            assert sweeps[i].station < lib.CF_LIGHTHOUSE_STATIONS and sweeps[i].sweep < lib.CF_LIGHTHOUSE_SWEEPS
            assert 0 < sweeps[i].sensors < 1 << lib.CF_LIGHTHOUSE_SENSORS
            assert all(map(math.isfinite, sweeps[i].angles))
        if lib.cf_vehicle_loco(vehicle, position, ranging):
            assert max(ranging.anchor, ranging.previous) < lib.CF_LOCO_ANCHORS
        measured = lib.cf_rangers_step(ffi.addressof(vehicle.rangers), position, rotation, ffi.NULL, ranges)
        for i in range(lib.CF_RANGE_COUNT):
            assert not measured >> i & 1 or ranges[i] < 5000 or ranges[i] == lib.CF_RANGE_NOTHING
        lib.cf_vehicle_barometer(vehicle, position[2], pressure, temperature)
        lib.cf_vehicle_feel_air(vehicle, position, rotation, velocity)
        effect = vehicle.ground_effect
        assert 1 <= min(effect.gain) <= max(effect.gain) <= effect.config.cap
        lib.cf_vehicle_wrench(vehicle, rotation, velocity, rates, f, t)


@pytest.mark.parametrize(("platform", "system"), list(product(PLATFORMS, SYSTEMS)))
def test_broken_motion(platform, system, vehicle_of):
    vehicle = vehicle_of(platform, system)
    for odd, place in product(FEW, range(7)):
        survives(vehicle, odd, place, ticks=12)
    assert vehicle.mass > 0


def test_saturation_is_at_the_ends_of_16_bits(vehicle_of):
    vehicle, gyro, acc = vehicle_of(), ffi.new("Axis3i16 *"), ffi.new("Axis3i16 *")
    lib.cf_vehicle_actuate(vehicle, [0, 0, 0, 0])
    lib.cf_vehicle_imu(vehicle, [math.inf, 3.4e38, 40], [240, -240, 0], gyro, acc)
    assert [gyro.x, gyro.y, gyro.z, acc.x, acc.y] == [32767, 32767, 32767, 32767, -32768]
    lib.cf_vehicle_imu(vehicle, [-math.inf, -3.4e38, math.nan], [240, -240, 0], gyro, acc)
    assert [gyro.x, gyro.y, gyro.z] == [-32768] * 3


@pytest.mark.parametrize("platform", PLATFORMS)
def test_every_ratio(platform, vehicle_of):
    vehicle = vehicle_of(platform)
    for ratio in range(0, 65536, 51):
        lib.cf_vehicle_actuate(vehicle, [ratio, 65535 - ratio, 0, 65535])
        assert math.isfinite(vehicle.battery.voltage) and vehicle.battery.voltage > 0
        assert 0 <= min(vehicle.rotors.thrust) <= max(vehicle.rotors.thrust) < 0.5


def test_a_pack_runs_down(vehicle_of):
    vehicle, full = vehicle_of(), ffi.new("uint16_t[]", [65535] * 4)
    vehicle.battery.charge = 0.01
    for _ in range(200000):
        lib.cf_vehicle_actuate(vehicle, full)
    assert vehicle.battery.charge == pytest.approx(-0.05)
    assert lib.cf_rotors_total_thrust(ffi.addressof(vehicle.rotors)) < vehicle.mass * 9.81


def test_odd_gusts_are_refused_or_blow(vehicle_of):
    for peak, duration in product(FEW, FEW):
        vehicle = vehicle_of()
        lib.cf_vehicle_gust(vehicle, [0, peak, 0], duration)
        for _ in range(300):
            lib.cf_vehicle_feel_air(vehicle, [0, 0, 1], EYE, [0, 0, 0])
            assert abs(vehicle.wind.velocity[1]) <= 50


@pytest.mark.parametrize("system", SYSTEMS)
def test_odd_configs_are_refused_or_run(system, config_of):
    """Every float of the config in turn becomes every odd number."""
    good = config_of(lib.CF_PLATFORM_CF2, system)
    good.rangers.has_multiranger = good.rangers.has_zranger = True
    good.airframe.wind.turbulence = lib.CF_TURBULENCE_DRYDEN
    accepted = 0
    for offset, ctype in leaves(ffi.typeof("cf_vehicle_config_t")):
        for odd in FEW if ctype.cname == "float" else ():
            config, vehicle = ffi.new("cf_vehicle_config_t *", good[0]), ffi.new("cf_vehicle_t *")
            ffi.cast("float *", ffi.cast("char *", config) + offset)[0] = odd
            if lib.cf_vehicle_init(vehicle, config, 1, 1) == lib.CF_OK:
                accepted += 1
                for _ in range(20):
                    lib.cf_vehicle_actuate(vehicle, [65535, 30000, 1, 0])
                survives(vehicle, ticks=3)
    assert accepted > 100


def test_a_refused_config_leaves_the_vehicle(config_of):
    config, vehicle = config_of(lib.CF_PLATFORM_CF21BL), ffi.new("cf_vehicle_t *")
    config.airframe.mass = math.nan
    ffi.buffer(vehicle)[:] = before = b"\x5a" * ffi.sizeof("cf_vehicle_t")
    assert lib.cf_vehicle_init(vehicle, config, 1, 1) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(vehicle)) == before
    assert lib.cf_vehicle_default_config(config, lib.CF_PLATFORM_COUNT) == lib.CF_ERR_UNKNOWN


def test_normal_numbers_exist_for_all_kinds_of_bits():
    for power, around in product(range(32), range(5)):
        assert abs(lib.cf_random_normal_from_bits((1 << power) + around - 2 & 0xFFFFFFFF)) < 6.24
    assert abs(lib.cf_random_normal_from_bits(0xFFFFFFFF)) < 1e-6


@pytest.mark.parametrize("rate", range(1, 1001, 111))
def test_ring_of_the_mocap_never_overflows(rate, config_of):
    config, mocap, pose = config_of(), ffi.new("cf_mocap_t *"), ffi.new("poseMeasurement_t *")
    config.mocap.rate = rate
    config.mocap.latency_ms = lib.CF_MOCAP_CAPACITY * 1000 // rate
    dice = ffi.new("cf_random_t *", [[1, 2]])[0]
    settings = ffi.addressof(config.mocap)
    assert lib.cf_mocap_init(mocap, settings, dice, dice) == lib.CF_ERR_CAPACITY
    config.mocap.latency_ms -= 1
    assert lib.cf_mocap_init(mocap, settings, dice, dice) == lib.CF_OK
    arrived = 0
    position, quat = ffi.new("float[3]"), ffi.new("float[4]", [1, 0, 0, 0])
    for _ in range(3000 + config.mocap.latency_ms):
        assert mocap.waiting <= lib.CF_MOCAP_CAPACITY
        arrived += lib.cf_mocap_step(mocap, position, quat, pose)
    assert arrived == 3 * rate


@pytest.mark.parametrize(("altitude", "height"), list(product((-500, 9000), (-1e4, -1, 0, 1e4))))
def test_barometer_gives_a_pressure_wherever_a_drone_may_be(altitude, height, config_of):
    config, vehicle = config_of(), ffi.new("cf_vehicle_t *")
    config.barometer.altitude, config.barometer.noise_scale = altitude, 100
    assert lib.cf_vehicle_init(vehicle, config, 1, 2) == lib.CF_OK
    pressure, temperature = ffi.new("float *", -1), ffi.new("float *", -1)
    told = []
    for _ in range(3000):
        if lib.cf_vehicle_barometer(vehicle, height, pressure, temperature):
            assert temperature[0] == 25
            told.append(pressure[0])
    assert told
    assert np.isfinite(told).all() and min(told) > 0
