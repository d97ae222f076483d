"""Faults as data: ranges, schedule, events, seeds, going back in time."""

import json
import math

import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.simulation import (
    BatteryFault,
    DroneConfig,
    Gust,
    ImuFault,
    Kick,
    MotorFault,
    PayloadDrop,
    PositioningFault,
    RadioFault,
    World,
)
from crazychoir_fw.simulation.faults import KINDS, Fault
from crazychoir_fw.simulation.faults.radio import share_of


def floor_world(count=1, **options):
    drones = [DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0)) for i in range(count)]
    return World(drones, seed=7, visuals=False, **options)


# ---------------------------------------------------------------- what a fault may be


@pytest.mark.parametrize(
    ("kind", "wrong", "sentence"),
    [
        (MotorFault, {"motor": 5}, "motor: motor is 5, allowed: a whole number in [1, 4]"),
        (MotorFault, {"motor": True}, "motor: motor is True"),
        (MotorFault, {"efficiency": -0.1}, "motor: efficiency is -0.1"),
        (MotorFault, {"at": -1.0}, "motor: at is -1.0"),
        (MotorFault, {"at": math.nan}, "motor: at is nan"),
        (MotorFault, {"duration": 0.0}, "motor: duration is 0.0"),
        (MotorFault, {"drones": "cf1"}, "motor: drones is 'cf1', allowed: a list"),
        (MotorFault, {"drones": []}, "motor: drones is []"),
        (ImuFault, {"sensor": "magnetometer", "stuck": True}, "imu: sensor is 'magnetometer'"),
        (ImuFault, {}, "imu: nothing is wrong with it"),
        (ImuFault, {"stuck": True, "bias": 1.0}, "imu: a stuck sensor shows neither"),
        (ImuFault, {"noise": math.inf}, "imu: noise is inf"),
        (PositioningFault, {}, "positioning: allowed: either lost, or a delay"),
        (PositioningFault, {"lost": True, "delay": 0.1}, "positioning: allowed: either"),
        (RadioFault, {}, "radio: nothing is wrong"),
        (RadioFault, {"loss": 1.5}, "radio: loss is 1.5, allowed: a number in [0, 1]"),
        (BatteryFault, {}, "battery: nothing is wrong"),
        (BatteryFault, {"resistance": 11.0}, "battery: resistance is 11.0"),
        (Kick, {}, "kick: impulse is missing"),
        (Kick, {"impulse": (1.0, 0.0)}, "kick: impulse is (1.0, 0.0), allowed: numbers [x, y, z]"),
        (Kick, {"impulse": (0.01, 0.0, 0.0), "duration": 1.0}, "kick: duration is 1.0, but it happens at once"),
        (Kick, {"impulse": (0.01, 0.0, 0.0), "frame": "drone"}, "kick: frame is 'drone'"),
        (PayloadDrop, {"duration": 1.0}, "payload: duration is 1.0"),
        (Gust, {}, "gust: velocity is missing"),
        (Gust, {"velocity": (51.0, 0.0, 0.0)}, "gust: velocity is"),
    ],
)
def test_impossible_faults_are_refused_with_a_sentence(kind, wrong, sentence):
    with pytest.raises(RangeError) as refused:
        kind(**wrong)
    assert str(refused.value).startswith(sentence)


def test_every_kind_has_its_word_and_is_json():
    assert list(KINDS) == ["motor", "imu", "positioning", "radio", "battery", "payload", "kick", "gust"]
    faults = [
        MotorFault(at=1.0, motor=2),
        Kick(at=2.0, impulse=(0.01, 0.0, 0.0), drones=("cf1",)),
        Gust(velocity=(1.0, 0.0, 0.0)),
    ]
    for fault in faults:
        assert isinstance(fault, Fault)
        assert json.loads(json.dumps(fault.as_dict()))["kind"] == fault.kind
    assert faults[0].details() == {"motor": 2}
    assert faults[1].details() == {"impulse": [0.01, 0.0, 0.0]}


@pytest.mark.parametrize(
    ("config", "fault", "error"),
    [
        ({}, MotorFault(drones=["cf9"]), UnknownNameError),
        ({}, PayloadDrop(), StateError),
        ({"positioning": "none"}, PositioningFault(lost=True), StateError),
        ({"positioning": "flow"}, PositioningFault(delay=0.1), StateError),
        ({}, PositioningFault(delay=0.5), RangeError),
        ({}, RadioFault(latency=1.0), RangeError),
    ],
)
def test_faults_that_a_drone_cannot_have_are_refused_and_leave_nothing(config, fault, error):
    world = World([DroneConfig("cf1", **config)], visuals=False)
    with pytest.raises(error):
        world.add_fault(fault)
    assert world.faults.planned == []
    world.step(2)
    assert world.events == []


def test_a_fault_of_the_past_is_refused():
    world = floor_world()
    world.run(0.5)
    with pytest.raises(RangeError, match=r"motor: at is 0.2 s, allowed: the present time 0.500 s or later"):
        world.add_fault(MotorFault(at=0.2))


# ---------------------------------------------------------------- when it happens


def test_faults_begin_and_end_at_their_ticks_and_are_noted():
    world = floor_world(2, faults=[MotorFault(at=0.1, duration=0.05, motor=3, efficiency=0.5, drones=["cf2"])])
    efficiency = [drone.struct.vehicle.rotors.efficiency for drone in world.drones]
    seen = []
    for _ in range(200):
        world.step(1)
        seen.append(efficiency[1][2])
        assert efficiency[0][2] == 1.0
    assert seen == [1.0] * 99 + [0.5] * 50 + [1.0] * 51
    assert [(event.time, event.kind, event.drone, dict(event.details)) for event in world.events] == [
        (pytest.approx(0.1), "fault", "cf2", {"fault": "motor", "state": "begins", "motor": 3, "efficiency": 0.5}),
        (pytest.approx(0.15), "fault", "cf2", {"fault": "motor", "state": "ends"}),
    ]


def test_bits_do_not_depend_on_how_the_world_is_stepped():
    """The agenda stops a long step at the tick of a fault."""
    ends = []
    for pieces in ([300], [1] * 300, [7] * 42 + [6]):
        world = floor_world(2, faults=[Kick(at=0.123, impulse=(0.001, 0.0, 0.0)), MotorFault(at=0.2, motor=1)])
        for ticks in pieces:
            world.step(ticks)
        ends.append(world.snapshot().tobytes())
    assert ends[0] == ends[1] == ends[2]


def test_an_outdated_world_meets_its_faults_again():
    """What lives in cf_t and mjData comes back with the snapshot, begins and ends with the agenda."""
    faults = [
        MotorFault(at=0.05, motor=1, efficiency=0.7, duration=0.2),
        ImuFault(at=0.1, sensor="gyro", noise=5.0, duration=0.2),
        Kick(at=0.15, impulse=(0.001, 0.0, 0.0)),
        Gust(at=0.12, velocity=(2.0, 0.0, 0.0), duration=0.1),
        BatteryFault(at=0.18, charge=0.3),
        PositioningFault(at=0.2, lost=True, duration=0.05),
    ]
    world = floor_world(1, faults=faults)
    ends = {}
    snapshots = {}
    for tick in (20, 110, 150, 220, 400):
        world.step(tick - world.tick)
        snapshots[tick] = world.snapshot()
    end, events = world.snapshot().tobytes(), list(world.events)
    for tick, snapshot in snapshots.items():
        world.restore(snapshot)
        world.step(400 - tick)
        ends[tick] = world.snapshot().tobytes()
        assert world.events == events
    assert set(ends.values()) == {end}


def test_reset_meets_a_fault_of_the_first_instant_again():
    world = floor_world(1, faults=[MotorFault(motor=1, efficiency=0.5)])
    ends = []
    for _ in range(2):
        world.step(20)
        assert world.drones[0].struct.vehicle.rotors.efficiency[0] == 0.5
        ends.append(world.snapshot().tobytes())
        world.reset()
        assert world.drones[0].struct.vehicle.rotors.efficiency[0] == 1.0
    assert ends[0] == ends[1]


def test_a_journal_of_requests_holds_what_faults_did():
    """Faults go through the uplink, so that a replay needs no schedule."""
    faults = [
        MotorFault(at=0.05, motor=1, efficiency=0.7, duration=0.1),
        ImuFault(at=0.06, sensor="acc", bias=0.1),
        Kick(at=0.07, impulse=(0.001, 0.0, 0.0)),
        Gust(at=0.08, velocity=(1.0, 0.0, 0.0)),
    ]
    world, other = floor_world(1, faults=faults), floor_world(1)
    heard = []
    world.drones[0].uplink.listeners.append(lambda verb, arguments: heard.append((world.tick, verb, arguments)))
    world.step(300)
    assert json.loads(json.dumps(heard))[0] == [50, "cf_inject_motor", [0, 0.7]]
    for tick, verb, arguments in heard:
        other.step(tick - other.tick)
        other.drones[0].uplink.dispatch(verb, *arguments)
    other.step(300 - other.tick)
    assert other.snapshot().tobytes() == world.snapshot().tobytes()


def test_seeds_come_from_the_world_and_the_place_of_the_fault():
    def end(seed, faults):
        world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], seed=seed, visuals=False, faults=faults)
        world.step(30)
        return [drone.struct.injected.random.state[0] for drone in world.drones]

    noise = ImuFault(at=0.01, sensor="gyro", noise=1.0)
    other = MotorFault(at=0.01, motor=1, efficiency=1.0)
    first = end(1, [noise])
    assert first == end(1, [noise])
    assert first[0] != first[1]  # drones differ
    assert first[0] != end(2, [noise])[0]
    assert first[0] != end(1, [other, noise])[0]


@pytest.mark.parametrize("threads", [1, 2])
def test_faults_give_the_same_bits_with_any_number_of_threads(threads):
    faults = [
        ImuFault(at=0.05, sensor="acc", noise=0.3),
        Gust(at=0.02, velocity=(3.0, 1.0, 0.0)),
        Kick(at=0.1, impulse=(0.0, 0.002, 0.001), point=(0.02, 0.0, 0.0), frame="body"),
    ]
    ends = []
    for count in (1, threads):
        world = floor_world(4, faults=faults, threads=count)
        world.step(250)
        ends.append(world.snapshot().tobytes())
    assert ends[0] == ends[1]


# ---------------------------------------------------------------- radio


def listen(world):
    """Return the list of requests that reach the first drone, with their ticks."""
    heard = []
    note = lambda verb, arguments: heard.append((world.tick, verb, arguments))
    world.drones[0].uplink.listeners.append(note)
    return heard


def send(drone, number):
    drone.commander.send_hover_setpoint(float(number), 0.0, 0.0, 1.0)


def numbers_of(heard):
    return [(tick, arguments[0]) for tick, verb, arguments in heard if verb == "cf_send_hover"]


def test_requests_get_lost_in_their_share_and_seed():
    def arrived(seed):
        world = World([DroneConfig("cf1", positioning="none")], seed=seed, visuals=False)
        world.add_fault(RadioFault(at=0.01, loss=0.3, duration=2.0))
        world.step(10)
        heard = listen(world)
        for number in range(2000):
            send(world.drones[0], number)
            world.step(1)
        return [number for _, number in numbers_of(heard)]

    some = arrived(1)
    assert len(some) == pytest.approx(1400, abs=60)
    assert some == arrived(1)
    assert some != arrived(2)


@pytest.mark.parametrize("again", [20, 55])
def test_late_requests_keep_their_order_and_survive_a_jump_back(again):
    """From 50 ms to 10 ms of latency: no packet overtakes another."""
    world = World([DroneConfig("cf1", positioning="none")], visuals=False)
    world.add_fault(RadioFault(at=0.01, latency=0.05, duration=0.03))
    world.add_fault(RadioFault(at=0.04, latency=0.01, duration=0.03))

    def fly(until):
        while world.tick < until:
            if world.tick % 5 == 0:
                send(world.drones[0], world.tick)
            world.step(1)

    heard = listen(world)
    fly(again)
    snapshot, before = world.snapshot(), numbers_of(heard)
    fly(150)
    first = numbers_of(heard)
    assert [number for _, number in first] == list(range(0, 150, 5))
    assert [tick - number for tick, number in first if 10 <= number < 40] == [50] * 6
    # those of 40 ms and later wait for the ones of 35 ms, which arrive at 85
    assert [tick for tick, number in first if 40 <= number < 75] == [85] * 7
    assert [tick - number for tick, number in first if number >= 90] == [0] * 12

    heard.clear()
    world.restore(snapshot)
    fly(150)
    assert before + numbers_of(heard) == first


def test_clients_hear_nothing_of_what_is_under_way_or_refused_late():
    world = floor_world()
    drone = world.drones[0]
    world.add_fault(RadioFault(at=0.01, latency=0.02, poses=False))
    world.step(10)
    heard = listen(world)
    drone.high_level_commander.takeoff(0.5, 1.0)
    drone.high_level_commander.takeoff(0.5, 1.0)
    assert drone.receive_packet(8, 0, bytes([6])) is None
    drone.param["pid_rate.roll_kp"] = 200
    assert drone.param["pid_rate.roll_kp"] != 200
    world.step(20)
    assert drone.param["pid_rate.roll_kp"] == 200
    assert [verb for _, verb, _ in heard] == ["cf_takeoff", "cf_takeoff", "packet", "param"]


def test_poses_of_the_motion_capture_suffer_with_the_radio():
    world = floor_world()
    mocap = world.drones[0].struct.vehicle.mocap.config
    world.add_fault(RadioFault(at=0.01, loss=0.4, latency=0.05, duration=0.1))
    world.step(20)
    assert (mocap.mishap.dropout, mocap.latency_ms) == (pytest.approx(0.4), 58)
    world.step(100)
    assert (mocap.mishap.dropout, mocap.latency_ms) == (0.0, 8)


def test_a_gate_that_was_there_before_is_asked_first():
    world = floor_world()
    asked = []
    world.drones[0].uplink.fault_filter = lambda verb, arguments: bool(asked.append(verb))
    world.add_fault(RadioFault(at=0.01, loss=0.5))
    heard = listen(world)
    send(world.drones[0], 1)
    assert asked == ["cf_send_hover"]
    assert heard == []


def test_the_dice_of_the_radio_are_uniform():
    shares = np.array([share_of(5, drone, tick, 0) for drone in range(3) for tick in range(2000)])
    assert shares.mean() == pytest.approx(0.5, abs=0.02)
    assert np.histogram(shares, 10, (0.0, 1.0))[0].min() > 500


# ---------------------------------------------------------------- the C side


def test_hooks_refuse_what_is_out_of_range():
    cf = floor_world().drones[0].struct
    assert lib.cf_inject_motor(cf, 4, 1.0) == lib.CF_ERR_CAPACITY
    assert lib.cf_inject_motor(cf, 0, 2.1) == lib.CF_ERR_VALUE
    assert lib.cf_inject_imu(cf, [[64, False, 0.0, 0.0]], 1) == lib.CF_ERR_VALUE
    assert lib.cf_inject_imu(cf, [[1, False, math.nan, 0.0]], 1) == lib.CF_ERR_VALUE
    assert lib.cf_inject_imu(cf, [[1, False, 0.0, -1.0]], 1) == lib.CF_ERR_VALUE
    assert lib.cf_inject_battery_charge(cf, 1.1) == lib.CF_ERR_VALUE
    assert lib.cf_inject_battery_resistance(cf, -1.0) == lib.CF_ERR_VALUE
    assert lib.cf_inject_gust(cf, [0.0, math.inf, 0.0], 10) == lib.CF_ERR_VALUE
    assert lib.cf_inject_positioning_dropout(cf, 2.0) == lib.CF_ERR_VALUE
    assert lib.cf_inject_positioning_delay(cf, 2**32 - 1) == lib.CF_ERR_CAPACITY
    assert not cf.injected.is_sensing_wrong
    assert cf.vehicle.wind.gust_duration == 0.0


def test_a_healed_imu_costs_nothing_again():
    world = floor_world()
    cf = world.drones[0].struct
    for axes in (7, 56):
        assert lib.cf_inject_imu(cf, [[axes, True, 0.0, 0.0]], 1) == lib.CF_OK
    world.step(3)
    assert (cf.injected.stuck_axes, cf.injected.held_axes) == (63, 63)
    assert lib.cf_inject_imu(cf, [[7, False, 0.0, 0.0]], 1) == lib.CF_OK
    assert (cf.injected.stuck_axes, cf.injected.held_axes) == (56, 56)
    assert cf.injected.is_sensing_wrong
    assert lib.cf_inject_imu(cf, [[56, False, 0.0, 0.0]], 1) == lib.CF_OK
    assert not cf.injected.is_sensing_wrong
