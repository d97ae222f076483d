"""The estimate of how many drones a radio can serve, against the simulated radio."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.link_model import Direction, RadioConfig, SimulatedRadios
from crazychoir_fw.crtp.link_model.budget import LogBlock, budget

UP, DOWN = Direction.UP, Direction.DOWN
SECONDS = 10


def config(**values):
    return RadioConfig(drones=["*"], **values)


def simulated(radio, drones, up, down, ping=10.0):
    """Return means over all drones of what a simulated radio counts under the same streams, at random phases."""
    dice = random.Random(5)
    ids = [f"cf{i}" for i in range(drones)]
    packets = []
    for drone in ids:
        for rate, direction, size in ((up, UP, 18), (ping, UP, 10), (ping, DOWN, 10), (down, DOWN, 31)):
            begin = dice.random() / rate
            packets += [(begin + k / rate, drone, direction, size) for k in range(int(SECONDS * rate))]
    link = SimulatedRadios([radio], ids, seed=3)
    for now, drone, direction, size in sorted(packets, key=lambda packet: packet[0]):
        link.send(now, drone, direction, bytes(size), droppable=direction is DOWN)
    link.arrivals(SECONDS)
    figures = link.statistics()

    def mean(way, key):
        return sum(drone[way][key] for drone in figures["drones"].values()) / drones

    return figures["radios"]["radio1"]["utilization"], mean


@pytest.mark.parametrize(
    ("drones", "up", "down", "values"),
    [
        (1, 100, 100, {}),
        (12, 10, 10, {}),
        (12, 50, 50, {}),
        (20, 30, 10, {}),
        (4, 20, 20, {"data_rate": "250K"}),
        (6, 20, 20, {"data_rate": "1M", "turnaround_ms": 1.0}),
        (12, 20, 20, {"loss": 0.1}),
        (8, 20, 20, {"loss": 0.3}),
        (8, 20, 20, {"loss": 0.3, "retries": 0, "reliable": False, "link_tries": 1000000}),
    ],
)
def test_it_agrees_with_the_simulated_radio(drones, up, down, values):
    radio = config(**values)
    estimate = budget(radio, drones, up, logs=[LogBlock(down)])
    busy, mean = simulated(radio, drones, up, down)
    assert estimate.verdict == "fits"
    assert estimate.busy == pytest.approx(busy, rel=0.07)
    assert estimate.up_mean_ms == pytest.approx(mean("up", "latency_mean_ms"), rel=0.12)
    assert estimate.up_p95_ms == pytest.approx(mean("up", "latency_p95_ms"), rel=0.25)
    assert estimate.down_mean_ms == pytest.approx(mean("down", "latency_mean_ms"), rel=0.2)
    assert estimate.lost == pytest.approx(mean("up", "lost") / mean("up", "sent"), abs=0.03)


def test_what_is_too_much_makes_queues_without_end():
    estimate = budget(config(), 20, 50, logs=[LogBlock(100)])
    assert estimate.verdict == "too much" and estimate.up_mean_ms == math.inf
    _, mean = simulated(config(), 20, 50, 100)
    assert mean("down", "dropped") > 100


def test_a_dongle_that_rests_between_polls():
    radio = config(idle_poll_ms=10.0)
    estimate = budget(radio, 4, 20, logs=[LogBlock(20)])
    busy, mean = simulated(radio, 4, 20, 20)
    assert estimate.busy == pytest.approx(busy, rel=0.1)
    assert estimate.up_mean_ms == pytest.approx(mean("up", "latency_mean_ms"), abs=0.3)
    assert estimate.down_mean_ms == pytest.approx(mean("down", "latency_mean_ms"), rel=0.2)


def test_twelve_drones_at_ten_hertz_fit_on_one_radio():
    estimate = budget(config(), 12, 10, logs=[LogBlock(10)])
    assert estimate.verdict == "fits"
    assert estimate.up_p95_ms < 10.0


@given(st.integers(1, 39), st.floats(0.0, 100.0), st.floats(0.0, 100.0), st.floats(0.0, 0.4))
def test_more_drones_are_never_easier(drones, setpoints, logs, loss):
    one, more = (budget(config(loss=loss), n, setpoints, logs=[LogBlock(logs)]) for n in (drones, drones + 1))
    assert more.utilization >= one.utilization
    assert more.cycle_ms >= one.cycle_ms
    assert more.up_p95_ms >= one.up_p95_ms or math.isinf(one.up_p95_ms)


def test_a_dead_radio_carries_nothing():
    assert budget(config(loss=1.0), 1).up_mean_ms == math.inf
    assert budget(config(loss=1.0, reliable=False), 1).lost == 1.0


@pytest.mark.parametrize(("drones", "rate"), [(0, 10.0), (1, -1.0), (1, math.nan)])
def test_nonsense_is_refused(drones, rate):
    with pytest.raises(RangeError, match="budget of"):
        budget(config(), drones, rate)
