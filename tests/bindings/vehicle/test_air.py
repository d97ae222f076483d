"""Ground effect, downwash, wind and trim of one vehicle."""

from __future__ import annotations

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

LEVEL = ffi.new("float[9]", np.eye(3).ravel().tolist())


def feel(vehicle, height=5.0, ticks=lib.CF_AIR_TICKS, rotation=LEVEL, velocity=(0.0, 0.0, 0.0)):
    for _ in range(ticks):
        lib.cf_vehicle_feel_air(vehicle, [0.0, 0.0, height], rotation, list(velocity))


def roll(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return ffi.new("float[9]", [1, 0, 0, 0, c, -s, 0, s, c])


# ---------------------------------------------------------------------------------- ground effect


def test_ground_effect_lifts_more_with_less_height_and_is_capped(make_vehicle):
    vehicle = make_vehicle()
    gains = []
    for height in (2.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.0, -1.0):
        feel(vehicle, height)
        gains.append(vehicle.ground_effect.gain[0])
    assert gains[0] == 1.0
    assert gains == sorted(gains)
    assert gains[-1] == pytest.approx(1.12)


def test_lower_rotors_gain_more_when_tilted(make_vehicle):
    vehicle = make_vehicle()
    feel(vehicle, 0.08, rotation=roll(20))
    gain = list(vehicle.ground_effect.gain)
    assert gain[0] == gain[1] > gain[2] == gain[3]  # rolled to the right: M1 and M2 are low


@pytest.mark.parametrize("degrees", [61, 120, 180])
def test_no_ground_effect_beyond_60_degrees(make_vehicle, degrees):
    vehicle = make_vehicle()
    feel(vehicle, 0.05, rotation=roll(degrees))
    assert list(vehicle.ground_effect.gain) == [1.0] * 4


def test_ground_effect_counts_from_the_surface_below(make_vehicle):
    on_floor, on_table = make_vehicle(), make_vehicle()
    on_table.surface = 0.75
    feel(on_floor, 0.0625)
    feel(on_table, 0.8125)
    assert list(on_table.ground_effect.gain) == list(on_floor.ground_effect.gain)


def test_ground_effect_can_be_switched_off(make_vehicle):
    def off(config):
        config.airframe.ground_effect.is_enabled = False

    vehicle = make_vehicle(change=off)
    feel(vehicle, 0.05)
    assert list(vehicle.ground_effect.gain) == [1.0] * 4


def test_rate_of_200_hz_is_as_good_as_every_tick(make_vehicle):
    """A landing at 0.3 m/s, and 1 m/s: largest difference of the gain between updates at 1 kHz and at 200 Hz."""
    for speed, most in ((0.3, 0.004), (1.0, 0.012)):
        slow, fast = make_vehicle(), make_vehicle()
        worst = 0.0
        for tick in range(int(0.4 / speed * 1000)):
            height = 0.4145 - speed * tick / 1000
            feel(slow, height, ticks=1)
            fast.air_countdown = 1
            feel(fast, height, ticks=1)
            worst = max(worst, abs(slow.ground_effect.gain[0] - fast.ground_effect.gain[0]))
        assert worst < most


def test_thrust_gets_the_gain_and_torque_about_z_does_not(make_vehicle, run, wrench):
    def odd(config):
        config.airframe.rotors.duty_bits = 16

    vehicle = make_vehicle(change=odd)
    run(vehicle, [30000, 20000, 30000, 20000], 500)
    free_force, free_torque = wrench(vehicle)
    feel(vehicle, 0.05)
    force, torque = wrench(vehicle)
    assert force[2] == pytest.approx(free_force[2] * vehicle.ground_effect.gain[0], rel=1e-6)
    assert torque[2] == free_torque[2]


# --------------------------------------------------------------------------------------- downwash


def test_downwash_pushes_down_in_the_world(make_vehicle, wrench):
    vehicle = make_vehicle()
    vehicle.downwash = 0.05
    upside_down = np.diag([1.0, -1.0, -1.0])
    assert wrench(vehicle)[0] == pytest.approx([0, 0, -0.05])
    assert wrench(vehicle, upside_down)[0] == pytest.approx([0, 0, -0.05])


@pytest.mark.parametrize("offset", [(0, 0, 0), (0, 0, -0.2), (0, 0, 1.51), (0.26, 0, 0.3), (np.nan, 0, 0.3)])
def test_nothing_is_felt_out_of_reach(make_config, offset):
    config = ffi.addressof(make_config().airframe.downwash)
    assert lib.cf_downwash_force(config, list(offset), 1.0) == 0.0


def test_strength_grows_with_thrust_and_the_root_of_the_mass():
    hover = lib.cf_downwash_strength(0.034, 0.034 * 9.81)
    assert hover == pytest.approx(1.0)
    assert lib.cf_downwash_strength(0.136, 0.136 * 9.81) == pytest.approx(2.0)
    assert lib.cf_downwash_strength(0.034, 0.5 * 0.034 * 9.81) == pytest.approx(0.5)
    assert lib.cf_downwash_strength(0.034, 0.0) == 0.0


# ------------------------------------------------------------------------------------------- wind


def windy(turbulence=0, velocity=(0.0, 0.0, 0.0), **more):
    def change(config):
        wind = config.airframe.wind
        wind.turbulence = turbulence
        wind.velocity = list(velocity)
        for name, value in more.items():
            setattr(wind, name, value)

    return change


def samples(vehicle, count, height=5.0):
    found = []
    for _ in range(count):
        feel(vehicle, height)
        found.append(list(vehicle.wind.velocity))
    return np.array(found)


def test_wind_is_a_velocity_of_the_other_sign(make_vehicle, run, wrench):
    still, windward = make_vehicle(), make_vehicle(change=windy(velocity=(1.0, -2.0, 0.5)))
    for vehicle in (still, windward):
        run(vehicle, [30000] * 4, 300)
    force, torque = wrench(still, velocity=(-1.0, 2.0, -0.5))
    in_wind = wrench(windward)
    assert in_wind[0] == pytest.approx(force)
    assert in_wind[1] == pytest.approx(torque)


def test_indoor_turbulence_has_deviation_and_time_constant_of_its_config(make_vehicle):
    change = windy(lib.CF_TURBULENCE_INDOOR, (0.5, 0, 0), indoor_deviation=0.2, indoor_time=0.1)
    wind = samples(make_vehicle(change=change), 40000) - [0.5, 0, 0]
    assert wind.std(axis=0) == pytest.approx([0.2] * 3, rel=0.05)
    lag = 20  # 0.1 s
    correlation = np.mean(wind[lag:] * wind[:-lag], axis=0) / wind.var(axis=0)
    assert correlation == pytest.approx([np.exp(-1)] * 3, abs=0.06)


def test_dryden_deviations_follow_the_wind_at_6_m(make_vehicle):
    """MIL-F-8785C at 3 m (9.84 ft) and 10 m/s: sigma_w = 1 m/s, the others sigma_w / (0.177 + 0.000823 h)^0.4."""
    vehicle = make_vehicle(change=windy(lib.CF_TURBULENCE_DRYDEN, (10.0, 0, 0)))
    wind = samples(vehicle, 120000, height=2.0) - [10.0, 0, 0]
    sigma = 1.0 / (0.177 + 0.000823 * 9.84) ** 0.4
    assert wind.std(axis=0) == pytest.approx([sigma, sigma, 1.0], rel=0.12)


def test_dryden_spectrum_has_the_slope_of_its_filters(make_vehicle):
    vehicle = make_vehicle(change=windy(lib.CF_TURBULENCE_DRYDEN, (10.0, 0, 0)))
    up = samples(vehicle, 120000, height=2.0)[:, 2]
    a = 10.0 / 3.0  # V / L_w
    frequency = np.fft.rfftfreq(4000, 0.005)[1:]
    blocks = up[: 30 * 4000].reshape(30, 4000)
    power = np.mean(np.abs(np.fft.rfft(blocks - up.mean(), axis=1)) ** 2, axis=0)[1:] * 2 * 0.005 / 4000
    w = 2 * np.pi * frequency / a
    expected = (2 / a) * (1 + 3 * w**2) / (1 + w**2) ** 2  # per Hz, of variance 1
    for low, high in ((0.1, 0.3), (0.3, 1.0), (1.0, 5.0)):
        band = (frequency > low) & (frequency < high)
        assert power[band].mean() == pytest.approx(expected[band].mean(), rel=0.15)


def test_dryden_follows_the_direction_of_the_wind(make_vehicle):
    along = samples(make_vehicle(change=windy(lib.CF_TURBULENCE_DRYDEN, (8.0, 0, 0))), 200)
    across = samples(make_vehicle(change=windy(lib.CF_TURBULENCE_DRYDEN, (0, 8.0, 0))), 200)
    assert across[:, 1] == pytest.approx(along[:, 0], rel=1e-5)
    assert across[:, 0] == pytest.approx(-along[:, 1], rel=1e-3, abs=1e-5)


def test_gust_is_one_minus_cosine_and_ends(make_vehicle):
    vehicle = make_vehicle(change=windy(velocity=(0.0, 1.0, 0.0)))
    assert lib.cf_vehicle_gust(vehicle, [4.0, 0.0, -2.0], 1.0) == lib.CF_OK
    wind = samples(vehicle, 240)
    times = 0.005 * np.arange(1, 241)
    share = np.where(times < 1.0, 0.5 * (1 - np.cos(2 * np.pi * times)), 0.0)
    expected = np.outer(share, [4.0, 0.0, -2.0])
    expected[:, 1] += 1.0
    assert wind == pytest.approx(expected, abs=1e-4)
    assert not vehicle.wind.is_changing


@pytest.mark.parametrize(
    ("peak", "duration"), [((51, 0, 0), 1), ((np.nan, 0, 0), 1), ((1, 0, 0), 0), ((1, 0, 0), 3601), ((1, 0, 0), np.nan)]
)
def test_impossible_gust_is_refused_and_changes_nothing(make_vehicle, peak, duration):
    vehicle = make_vehicle()
    before = bytes(ffi.buffer(vehicle))
    assert lib.cf_vehicle_gust(vehicle, [float(p) for p in peak], duration) == lib.CF_ERR_VALUE
    assert bytes(ffi.buffer(vehicle)) == before


# ----------------------------------------------------------------------------------- trim, rotors


def test_trim_torque_is_that_of_hover_and_follows_the_thrust(make_vehicle, wrench):
    def trim(config):
        config.airframe.trim_torque = [1e-3, -5e-4, 1.7e-4]

    vehicle = make_vehicle(change=trim)
    assert wrench(vehicle)[1] == pytest.approx([0, 0, 0])
    for share in (1.0, 1.5):
        vehicle.rotors.thrust = [share * vehicle.mass * 9.81 / 4] * 4
        assert wrench(vehicle)[1] == pytest.approx(share * np.array([1e-3, -5e-4, 1.7e-4]), rel=1e-5)


def test_thrust_scale_and_efficiency_multiply(make_vehicle, run):
    def change(config):
        supply(config)
        config.airframe.rotors.thrust_scale = 0.9
        config.airframe.rotors.efficiency = [1.0, 0.5, 1.0, 0.0]

    def supply(config):
        config.airframe.battery.constant_voltage = 4.0

    stock, worn = make_vehicle(change=supply), make_vehicle(change=change)
    for vehicle in (stock, worn):
        run(vehicle, [30000] * 4, 300)
    shares = np.array(list(worn.rotors.thrust)) / np.array(list(stock.rotors.thrust))
    assert shares == pytest.approx([0.9, 0.45, 0.9, 0.0], rel=1e-3)


def test_slowing_down_may_take_longer_than_speeding_up(make_vehicle, run):
    def change(config):
        config.airframe.rotors.duty_bits = 16
        config.airframe.rotors.time_constant_up = 0.05
        config.airframe.rotors.time_constant_down = 0.10
        config.airframe.battery.constant_voltage = 4.0

    vehicle = make_vehicle(change=change)
    run(vehicle, [40000] * 4, 50)
    after_up = vehicle.rotors.rpm[0]
    run(vehicle, [40000] * 4, 2000)
    top = vehicle.rotors.rpm[0]
    run(vehicle, [0] * 4, 100)
    assert after_up / top == pytest.approx(1 - np.exp(-1), abs=2e-3)
    assert vehicle.rotors.rpm[0] / top == pytest.approx(np.exp(-1), abs=2e-3)
