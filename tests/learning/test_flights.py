"""Flights side by side: starts, the same bits at any number, rewards, limits, bad actions."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.learning import (
    Attitude,
    Flights,
    Gates,
    Hover,
    Motors,
    Observation,
    Recover,
    Residual,
    ThrustRates,
    Track,
    Velocity,
)
from crazychoir_fw.simulation import set_threads

FEW = {"variants": 3}


def actions_of(count, steps, size=4):
    """The same ones for flight i, however many there are."""
    return np.array([np.random.default_rng(i).uniform(-0.4, 0.4, (steps, size)) for i in range(count)]).swapaxes(0, 1)


def flown(task, count, steps=60):
    """Observations and rewards of all flights, and what their drones are at the end."""
    flights = Flights(task, count)
    flights.seed(np.arange(count))
    flights.start(np.arange(count))
    rows = []
    for action in actions_of(count, steps):
        reward, is_over, is_late = flights.step(action)
        rows.append(np.concatenate([flights.observe(), reward[:, None], is_over[:, None], is_late[:, None]], axis=1))
        flights.start(np.flatnonzero(is_over | is_late))
    memory = [bytes(drone.memory) + flights.port.qpos[i].tobytes() for i, drone in enumerate(flights.world.drones)]
    return np.array(rows), memory


def test_a_flight_is_the_same_among_any_number_and_at_any_number_of_threads():
    task = Hover(**FEW, episode_s=0.3)
    alone, memory_alone = flown(task, 1)
    many, memory_many = flown(task, 130)  # more than 100: worlds solve contacts by another method
    assert np.array_equal(alone[:, 0], many[:, 0])
    assert memory_alone[0] == memory_many[0]
    assert not np.array_equal(many[:, 0], many[:, 1])
    set_threads(2)
    again, memory_again = flown(task, 130)
    assert np.array_equal(many, again)
    assert memory_many == memory_again


def test_an_episode_begins_where_the_dice_say_and_the_drone_knows_it():
    flights = Flights(Recover(**FEW), 20)
    reading = flights.reading
    assert np.ptp(reading.truth.velocity[:, 0]) > 1.0
    for name in ("position", "velocity", "rotation"):
        assert np.allclose(getattr(reading.estimate, name), getattr(reading.truth, name), atol=1e-5)
    assert np.allclose(reading.estimate.rates, reading.truth.rates, atol=1e-4)
    flights.step(np.zeros((20, 4)))
    assert np.abs(flights.reading.estimate.rates - flights.reading.truth.rates).max() < 2.0
    assert np.abs(flights.reading.estimate.position - flights.reading.truth.position).max() < 0.01


def test_drones_do_not_feel_each_other():
    task = Hover(**FEW, start_box=(0.0, 0.0, 0.0), start_speed=0.0, start_tilt_deg=0.0, start_rate=0.0)
    flights = Flights(task, 10)
    for _ in range(20):
        flights.step(np.zeros((10, 4)))
    assert all(drone.struct.vehicle.downwash == 0.0 for drone in flights.world.drones)
    assert not flights.reading.is_touching.any()
    assert np.ptp(flights.reading.truth.position[:, :2], axis=0).max() < 0.05  # all of them at one place


@pytest.mark.parametrize(
    "action", [ThrustRates(), Attitude(), Velocity(), Residual(), Motors()], ids=lambda action: action.kind
)
def test_the_neutral_action_of_every_kind_keeps_a_drone_in_the_air(action):
    flights = Flights(Hover(**FEW, action=action, start_tilt_deg=0.0, start_rate=0.0, start_speed=0.0), 3)
    for _ in range(25):
        _, is_over, _ = flights.step(np.zeros((3, 4)))
        assert not is_over.any()
    assert np.abs(flights.reading.truth.velocity[:, 2]).max() < 0.6


def test_actions_move_drones_the_way_they_say():
    flights = Flights(Hover(**FEW, action=Velocity(), start_tilt_deg=0.0, start_speed=0.0, start_rate=0.0), 2)
    for _ in range(80):
        flights.step([[0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.5, 0.0]])
    assert flights.reading.truth.velocity[0, 0] > 0.2
    assert flights.reading.truth.velocity[1, 2] > 0.2

    turned = Flights(Hover(**FEW, start_tilt_deg=0.0, start_rate=0.0, start_yaw_deg=0.0), 2)
    for _ in range(5):
        turned.step([[0.0, 0.3, 0.0, 0.0], [0.0, 0.0, 0.3, 0.0]])
    assert turned.reading.truth.rates[0, 0] > 0.8
    assert turned.reading.truth.rates[1, 1] > 0.8
    # roll to the right, nose down
    assert turned.reading.truth.rotation[0, 7] > 0.02
    assert turned.reading.truth.rotation[1, 6] < -0.02


def test_the_residual_follows_its_law():
    flights = Flights(Hover(**FEW, action=Residual()), 5)
    for _ in range(300):
        flights.step(np.zeros((5, 4)))
    error = flights.reading.truth.position - flights.reading.reference.position
    assert np.abs(error).max() < 0.2


def test_a_flight_that_falls_ends_and_one_that_lasts_is_late():
    flights = Flights(Hover(**FEW, episode_s=2.0), 2)
    ends = {}
    for step in range(200):
        _, is_over, is_late = flights.step([[-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
        if is_over[0]:
            ends.setdefault("fallen", step)
            flights.start([0])
    assert 10 < ends["fallen"] < 150
    assert is_late[1] or is_over[1]


def test_what_varies_is_drawn_once_per_variant_and_flies():
    vary = {
        "defaults.mass": {"uniform": [0.027, 0.033]},
        "defaults.vehicle.trim.torque[0]": {"uniform": [-1e-4, 1e-4]},
        "wind.velocity": {"choice": [[0.5, 0.0, 0.0]]},
    }
    flights = Flights(Hover(vary=vary, variants=6), 40)
    masses = flights.world.model.body_mass[[flights.world.model.body(f"drone{i}").id for i in range(40)]]
    assert 3 <= len(set(masses.tolist())) <= 6
    assert all(abs(drone.struct.vehicle.wind.velocity[0] - 0.5) < 1e-6 for drone in flights.world.drones)
    assert len({float(drone.struct.vehicle.trim_per_thrust[0]) for drone in flights.world.drones}) >= 3
    assert np.allclose([d.struct.vehicle.mass for d in flights.world.drones], masses, atol=1e-6)


def test_vary_is_that_of_a_campaign_file(tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text("extends: m.yaml\nvary:\n  defaults.battery: {uniform: [0.5, 0.6]}\n")
    flights = Flights(Hover(vary=path, variants=2), 1)
    assert flights.world.drones[0].struct.vehicle.battery.charge < 0.6


def test_the_track_moves_and_its_start_is_on_it():
    task = Track(**FEW)
    flights = Flights(task, 8)
    first = flights.reading.reference
    assert np.abs(flights.reading.truth.position - first.position).max() < 0.25
    plan = flights.plan.copy()
    h = 1e-3
    before, after = (task.reference(plan, np.full(8, 1.0 + s * h)) for s in (-1, 1))
    now = task.reference(plan, np.full(8, 1.0))
    assert np.allclose((after.position - before.position) / (2 * h), now.velocity, atol=2e-3)
    assert np.allclose((after.velocity - before.velocity) / (2 * h), now.acceleration, atol=5e-3)


def test_gates_are_passed_in_order_and_bars_end_a_flight():
    task = Gates(**FEW, start_tilt_deg=0.0, start_rate=0.0, action=Velocity(max_speed=1.5))
    flights = Flights(task, 5)
    flights.seed(np.arange(5))
    flights.start(np.arange(5))
    first = flights.plan[:, 0].copy()
    passed = np.zeros(5, bool)
    for _ in range(250):
        heading = np.radians([task.gates[int(number)][3] for number in flights.plan[:, 0]])
        behind = 0.4 * np.stack([np.cos(heading), np.sin(heading), 0 * heading], axis=1)
        error = flights.reading.reference.position + behind - flights.reading.estimate.position
        flights.step(np.concatenate([np.clip(error, -1, 1), np.zeros((5, 1))], axis=1))
        passed |= flights.plan[:, 0] == (first + 1) % 5
    assert passed.any()

    into_a_bar = Flights(Gates(**FEW, start_tilt_deg=0.0, action=Velocity(max_speed=2.0)), 5)
    hits = np.zeros(5, bool)
    for _ in range(200):
        aim = into_a_bar.reading.reference.position + np.array([0.0, 0.0, 0.38], np.float32)
        error = aim - into_a_bar.reading.estimate.position
        _, is_over, _ = into_a_bar.step(np.concatenate([np.clip(2 * error, -1, 1), np.zeros((5, 1))], axis=1))
        hits |= is_over & into_a_bar.reading.is_touching
        into_a_bar.start(np.flatnonzero(is_over))
    assert hits.any()


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ([[0.0, 0.0, 0.0]], "action has shape (1, 3), allowed: (1, 4)"),
        ([0.0, 0.0, 0.0, 0.0], "action has shape (4,), allowed: (1, 4)"),
        ([[0.0, float("nan"), 0.0, 0.0]], "action: number 1 of flight 0 is nan, allowed: -1 to 1"),
        ([[0.0, 0.0, float("inf"), 0.0]], "action: number 2 of flight 0 is inf, allowed: -1 to 1"),
        ([["up", 0.0, 0.0, 0.0]], "allowed: numbers of shape (1, 4)"),
    ],
)
def test_a_bad_action_is_refused_before_anything_flies(action, words):
    flights = Flights(Hover(variants=1), 1)
    before = flights.port.qpos.copy()
    with pytest.raises(RangeError, match=".*") as refused:
        flights.step(action)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
    assert np.array_equal(before, flights.port.qpos)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Hover(rate_hz=60), RangeError, "rate_hz is 60, allowed: 25, 40, 50, 100, 125, 200, 250, 500"),
        (lambda: Observation(("positon_error",)), UnknownNameError, "did you mean 'position_error'?"),
        (lambda: Observation(source="guess"), UnknownNameError, "allowed: estimate, truth"),
        (lambda: Flights(Hover(), 0), RangeError, "count is 0, allowed: 1 or more"),
        (lambda: Flights(Hover(vary={"defaults.colour": {"uniform": [0, 1]}})), RangeError, "vary names"),
        (lambda: Flights(Hover(observation=Observation(("ranges",)), variants=1)), RangeError, "no multiranger"),
    ],
)
def test_a_wrong_option_ends_in_one_sentence(make, error, words):
    with pytest.raises(error) as refused:
        flights = make()
        flights.observe()
    assert words in str(refused.value)


@pytest.mark.parametrize("rate_hz", [25, 50, 250, 500])
def test_the_policy_acts_at_its_rate(rate_hz):
    flights = Flights(Hover(rate_hz=rate_hz, variants=1), 1)
    tick = flights.world.drones[0].struct.onboard.tick
    flights.step(np.zeros((1, 4)))
    assert flights.world.drones[0].struct.onboard.tick - tick == 1000 // rate_hz


def test_ranges_are_those_of_the_scene():
    task = Hover(observation=Observation(("ranges", "rates")), decks=("multiranger",), scene="room", **FEW)
    flights = Flights(task, 4)
    for _ in range(30):
        flights.step(np.zeros((4, 4)))
    ranges = flights.observe()[:, :5]
    assert ((ranges > 0.2) & (ranges <= 4.0)).all()
    assert np.ptp(ranges) > 0.1
