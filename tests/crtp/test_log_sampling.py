"""Log blocks are sampled by simulated time (docs/reference/crtp-cflib.md#8.3)."""

import sys
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_requests import (
    APPEND,
    CREATE,
    DELETE,
    FLOAT,
    INT16,
    START,
    START_MS,
    STOP,
    UINT8,
    UINT16,
    control,
    data,
    entries,
    start,
    times,
)

from crazychoir_fw.crtp.services.log_sampler import SLICE, sampler_of
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.onboard import core
from crazychoir_fw.simulation import DroneConfig, World

ROLL = ("stabilizer.roll", INT16)


@pytest.fixture
def world():
    return World([DroneConfig("cf1"), DroneConfig("cf2", (0.5, 0.0))], visuals=False)


@pytest.fixture(scope="module")
def lasting_world():
    return World([DroneConfig("cf1")], visuals=False)


@pytest.fixture
def station(world):
    return Station(world, world["cf1"])


@pytest.mark.parametrize(("begin", "period"), [(0, 10), (3, 10), (7, 25), (0, 1), (5, 1), (2, 7), (13, 100)])
def test_the_first_packet_comes_a_period_after_the_start_or_up_to_a_slice_later(world, station, begin, period):
    world.step(begin)
    start(station, 1, period, ROLL)
    world.step(500)
    sent = times(station)
    assert period <= sent[0] - begin < period + (SLICE if period >= SLICE else 1)
    assert np.all(np.diff(sent) == period)
    assert sent[-1] + period > world.tick


def test_a_swarm_with_blocks_started_at_any_time_stops_the_world_once_per_slice(world):
    stations = [Station(world, drone) for drone in world.drones]
    for number in range(10):
        for station in stations:
            start(station, number, 20, ROLL)
        world.step(3)
    stops, tick = [], world.tick
    while tick < 100:
        stops.append(tick := world.agenda.next_stop(1000))
        world.step(tick - world.tick)
    assert len(stops) == 7
    assert all(stop % SLICE == 0 for stop in stops)


def test_the_values_are_those_of_the_instant(world, station):
    start(station, 1, 10, ("stateEstimate.z", FLOAT), ("stateEstimateZ.z", INT16), ("supervisor.info", UINT16))
    for _ in range(5):
        world.step(10)
        log = world["cf1"].log
        expected = (log["stateEstimate.z"], log["stateEstimateZ.z"], log["supervisor.info"])
        assert data(station, "fhH") == [(1, world.tick, expected)]


def test_variables_that_a_library_computes_when_read(bitcraze_library, miniature, monkeypatch):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    provider = core.load_library(bitcraze_library)
    world = World([DroneConfig("cf1", provider="bitcraze")], visuals=False)
    station = Station(world, world["cf1"])
    names = [name for name in world["cf1"].log if name.split(".")[0] in ("stateEstimate", "stateEstimateZ", "kalman")]
    for number, name in enumerate(names[:16]):
        assert control(station, CREATE, number, entries((name, FLOAT), provider=provider)) == 0
        assert control(station, START, number, b"\x01") == 0
    station.context.carry_out()
    world.step(2000)
    sent = {names[number]: value for number, _, (value,) in data(station, "f")}
    assert sent == {name: np.float32(world["cf1"].log[name]) for name in names[:16]}


def test_the_time_stamp_has_24_bits_and_counts_from_boot(world, station):
    start(station, 1, 10, ROLL)
    world["cf1"].struct.onboard.tick = 0x01000000 - 15
    world.step(20)
    assert times(station) == [0x00FFFFFB, 0x000005]
    world["cf1"].reboot()
    world.step(10)
    assert times(station) == [10]


def test_a_start_while_it_runs_changes_the_period(world, station):
    start(station, 1, 10, ROLL)
    world.step(35)
    assert times(station) == [10, 20, 30]
    assert control(station, START, 1, b"\x05") == 0
    station.context.carry_out()
    world.step(200)
    assert times(station) == [90, 140, 190]


@pytest.mark.parametrize("command", [STOP, DELETE])
def test_stop_and_delete_need_nobodys_help(world, station, command):
    start(station, 1, 10, ROLL)
    world.step(10)
    assert control(station, command, 1) == 0
    station.context.take_out()
    world.step(100)
    assert times(station) == []


def test_a_stopped_block_starts_again(world, station):
    start(station, 1, 10, ROLL)
    world.step(10)
    assert control(station, STOP, 1) == 0
    assert control(station, START, 1, b"\x02") == 0
    station.context.carry_out()
    world.step(40)
    assert times(station) == [10, 30, 50]


def test_a_stop_that_overtakes_its_start(world, station):
    assert control(station, CREATE, 1, entries(ROLL)) == 0
    assert control(station, START, 1, b"\x01") == 0
    assert control(station, STOP, 1) == 0
    station.context.carry_out()
    world.step(50)
    assert times(station) == []


@pytest.mark.parametrize(("command", "rest"), [(START_MS, b"\0\0"), (START, b"\0")])
def test_period_0_sends_one_packet_at_once(world, station, command, rest):
    world.step(5)
    start(station, 1, 10, ROLL)
    assert control(station, command, 1, rest) == 0
    station.context.carry_out()
    assert times(station) == [5]
    world.step(20)
    assert times(station) == [20], "what ran goes on"


@pytest.mark.parametrize("period", [b"\0\0", b"\x0a\0"])
def test_what_still_waits_at_the_end_of_a_session_is_not_begun(world, station, period):
    assert control(station, CREATE, 1, entries(ROLL)) == 0
    assert control(station, START_MS, 1, period) == 0
    station.end_session()
    station.context.carry_out()
    world.step(20)
    assert times(station) == []


def test_what_is_appended_while_it_runs_is_sent(world, station):
    start(station, 1, 10, ROLL)
    world.step(10)
    assert control(station, APPEND, 1, entries(("supervisor.info", UINT8))) == 0
    world.step(10)
    assert [len(values) for _, _, values in data(station)] == [2, 3]


def test_an_empty_block_sends_its_head(world, station):
    start(station, 1, 10)
    world.step(10)
    assert data(station) == [(1, 10, b"")]


def test_drones_do_not_see_each_others_blocks(world):
    stations = [Station(world, drone) for drone in world.drones]
    start(stations[0], 1, 10, ROLL)
    start(stations[1], 1, 10, ROLL, ROLL)
    stations[0].end_session()
    world.step(20)
    assert times(stations[0]) == []
    assert [len(values) for _, _, values in data(stations[1])] == [4, 4]


def test_blocks_go_on_when_time_goes_back(world, station):
    snapshot = world.snapshot()
    world.step(100)
    start(station, 1, 10, ROLL)
    start(station, 2, 1000, ROLL)
    world.step(50)
    assert len(times(station)) == 5
    world.reset()
    world.step(30)
    assert times(station) == [10, 20, 30]
    world.restore(snapshot)
    world.step(20)
    assert times(station) == [10, 20]
    world.step(980)
    assert [number for number, _, _ in data(station)].count(2) == 1


def test_nothing_is_left_on_the_agenda(world, station):
    world.step(5)
    appointments = world.agenda.periods
    for number, period in enumerate([1, 5, 10, 35, 1000]):
        start(station, number, period, ROLL)
    station.end_session()
    world.step(2000)
    station.context.take_out()
    assert world.agenda.periods == appointments
    assert not sampler_of(world)._groups


def test_logging_changes_no_bit_of_a_flight():
    def fly(is_logged):
        world = World([DroneConfig("cf1")], visuals=False, seed=3)
        if is_logged:
            start(Station(world, world["cf1"]), 1, 10, ("stateEstimate.x", FLOAT), ROLL)
        world.wait_until_ready()
        world["cf1"].high_level_commander.takeoff(0.5, 1.0)
        world.run(1.5)
        # what the drone knows of its radio is another matter
        return *world.data.qpos, *world.data.qvel, *world["cf1"].estimated_position, world["cf1"].battery_voltage

    assert fly(True) == fly(False)


def test_a_scene_with_longer_steps_is_sampled(tmp_path):
    scene = tmp_path / "slow.xml"
    scene.write_text(
        '<mujoco><option timestep="0.004"/><worldbody><geom type="plane" size="5 5 .1"/></worldbody></mujoco>'
    )
    world = World([DroneConfig("cf1")], scene=scene, visuals=False)
    station = Station(world, world["cf1"])
    start(station, 1, 10, ROLL)
    world.step(60)
    assert times(station) == [12, 20, 32, 40, 52, 60]


@pytest.fixture
def hasty_threads():
    """Threads that take turns all the time."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.usefixtures("hasty_threads")
def test_blocks_come_and_go_while_they_are_sampled(world):
    """The radio thread works on blocks while the simulation thread samples; nothing is torn."""
    station = Station(world, world["cf1"])
    seen, errors, is_over = [], [], threading.Event()

    def be_a_client():
        try:
            while not is_over.is_set():
                for number in (1, 2):
                    control(station, CREATE, number, entries(ROLL))
                    control(station, START_MS, number, b"\1\0")
                    control(station, APPEND, number, entries(("supervisor.info", UINT8)))
                control(station, DELETE, 1)
                control(station, STOP, 2)
                control(station, DELETE, 2)
                seen.extend(station.context.take_out())
        except BaseException as error:
            errors.append(error)

    client = threading.Thread(target=be_a_client)
    client.start()
    for _ in range(200):
        station.context.carry_out()
        world.step(1)
    is_over.set()
    client.join()
    assert errors == []
    assert {len(datagram) for datagram, _ in seen} <= {5 + 2, 5 + 3}


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 60), st.integers(0, 40)), min_size=1, max_size=12))
def test_every_block_keeps_its_period(lasting_world, commands):
    world = lasting_world
    world.reset()
    station = Station(world, world["cf1"])
    for number in range(4):
        control(station, CREATE, number, entries(ROLL))
    for number, period, wait in commands:
        control(station, START_MS, number, bytes((period, 0)))
        station.context.carry_out()
        world.step(wait)
    last = {number: period for number, period, _ in commands}
    world.step(2 * SLICE + 60)
    station.context.take_out()
    begin = world.tick
    world.step(240)
    sent = data(station)
    station.end_session()
    for number in range(4):
        stamps = [stamp for block, stamp, _ in sent if block == number]
        if number in last:
            assert np.all(np.diff([begin, *stamps])[1:] == last[number])
            assert len(stamps) in (240 // last[number], 240 // last[number] + 1)
        else:
            assert stamps == []
