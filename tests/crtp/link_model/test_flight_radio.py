"""Flights whose requests go through simulated radios: how they degrade, and what happens in other times."""

import math

import numpy as np
import pytest

from crazychoir_fw.crtp.link_model import Direction, RadioConfig, SimulatedRadios
from crazychoir_fw.crtp.link_model.flight_radio import PACKET_BYTES, FlightRadio, packet_sizes
from crazychoir_fw.onboard.trajectories import Poly4D
from crazychoir_fw.simulation import DroneConfig, RadioFault, World

BARE = {"retries": 0, "reliable": False, "link_tries": 1000000, "link_timeout": 1000.0}
"""Every transmission for itself, so that losses are seen."""


def join(world, seed=1, **config):
    """Put all drones of a world on one radio."""
    link = SimulatedRadios([RadioConfig(drones=["*"], **config)], [drone.id for drone in world.drones], seed)
    return FlightRadio(world, link)


def new_world(count=1):
    return World([DroneConfig(f"cf{i + 1}", (1.0 * i, 0.0)) for i in range(count)], seed=2, visuals=False)


@pytest.fixture(scope="module")
def hover():
    """The snapshot of a drone that hovers at 1 m."""
    world = new_world()
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(1.0, 2.0)
    world.run(3.0)
    return world.snapshot()


@pytest.fixture
def hovering(hover):
    world = new_world()
    world.restore(hover)
    return world


def up(radio, drone="cf1"):
    return radio.link.statistics()["drones"][drone]["up"]


# ---------------------------------------------------------------- degradation


def path_error(world, rate, seconds=8.0):
    """Swing along x by setpoints at a rate (Hz); return the RMS distance from them (m) and the states on the way."""
    drone = world.drones[0]
    errors, states = [], set()
    for k in range(round(seconds * rate)):
        target = np.array([0.6 * math.sin(0.4 * math.pi * k / rate), 0.0, 1.0])
        drone.commander.send_position_setpoint(*target, 0.0)
        world.step(1000 // rate)
        errors.append(np.linalg.norm(drone.true_position - target))
        states.add(drone.supervisor_state)
    return float(np.sqrt(np.mean(np.square(errors)))), states


@pytest.mark.parametrize("rate", [10, 50])
def test_the_path_error_grows_with_the_loss(hover, rate):
    flown = {}
    for loss in (0.0, 0.3, 0.6, 0.9):
        world = new_world()
        world.restore(hover)
        radio = join(world, loss=loss, **BARE)
        flown[loss] = path_error(world, rate)
        tally = up(radio)
        assert abs(tally["lost"] - loss * tally["sent"]) <= 4 * math.sqrt(tally["sent"] * loss * (1 - loss)) + 1e-9
    errors = [error for error, _ in flown.values()]
    assert errors == sorted(errors)
    assert errors[1] > errors[0] + 0.002
    assert errors[3] > 1.2 * errors[0]
    # the supervisor minds gaps of half a second: five setpoints in a row at 10 Hz, 25 at 50 Hz
    assert flown[0.0][1] == {"Flying"}
    assert flown[0.3][1] == ({"Flying"} if rate == 50 else {"Flying", "Warning, level out"})
    assert "Warning, level out" in flown[0.9][1]


def test_a_reliable_link_hardly_notices_a_third_lost(hovering, hover):
    without, _ = path_error(hovering, 10)
    world = new_world()
    world.restore(hover)
    radio = join(world, loss=0.3)
    error, states = path_error(world, 10)
    assert error == pytest.approx(without, abs=0.01)
    assert states == {"Flying"}
    assert up(radio)["lost"] == 0 and up(radio)["repeated"] > 20


@pytest.mark.parametrize("reliable", [True, False])
def test_at_total_loss_the_drone_levels_out_after_half_a_second_and_stops_after_two(hovering, reliable):
    """planner-commander 8.3, 14.5."""
    drone = hovering.drones[0]

    def hold():
        drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 1.0)

    for _ in range(50):
        hold()
        hovering.step(20)
    begin = hovering.time
    radio = join(hovering, loss=1.0, reliable=reliable)
    entered, last = [], drone.supervisor_state
    for tick in range(2300):
        if tick % 20 == 0:
            hold()
        hovering.step(1)
        if drone.supervisor_state != last:
            last = drone.supervisor_state
            entered.append((hovering.time - begin, last))
    assert [state for _, state in entered] == ["Warning, level out", "Exception, free fall", "Locked"]
    # the last setpoint came 20 ms before, and the supervisor looks every 40 ms
    assert entered[0][0] == pytest.approx(0.5, abs=0.06)
    assert entered[1][0] == pytest.approx(2.0, abs=0.06)
    assert up(radio)["delivered"] == 0
    assert radio.link.is_lost("cf1")


# ---------------------------------------------------------------- requests


def test_requests_arrive_at_the_tick_after_their_latency(hovering):
    radio = join(hovering, latency_ms=30.0, jitter_ms=0.0)
    drone = hovering.drones[0]
    heard = []
    drone.uplink.listeners.append(lambda verb, arguments: heard.append((hovering.tick, verb)))
    begin = hovering.tick
    drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
    drone.param["stabilizer.controller"] = 1
    hovering.step(100)
    assert [verb for _, verb in heard] == ["cf_send_position", "param"]
    assert [31 <= tick - begin <= 33 for tick, _ in heard] == [True, True]
    assert up(radio)["delivered"] == 2


def test_a_refusal_on_arrival_is_heard_by_nobody(hovering):
    join(hovering)
    hovering.drones[0].high_level_commander.takeoff(1.0, 2.0)  # flies already
    hovering.step(20)
    assert hovering.drones[0].is_flying


@pytest.mark.parametrize("loss", [0.0, 1.0])
def test_a_trajectory_is_written_when_its_last_packet_has_come(hovering, loss):
    radio = join(hovering, loss=loss)
    drone = hovering.drones[0]
    drone.high_level_commander.upload_trajectory(3, [Poly4D(1.0)])
    before = [request.verb for request in hovering.journal]
    assert "cf_write_trajectory" not in before[-2:]
    hovering.run(2.0)
    after = [request.verb for request in hovering.journal][len(before) :]
    assert after == ([] if loss else ["cf_write_trajectory", "cf_define_trajectory"])
    assert up(radio)["sent"] == 6 + 1  # 132 bytes


def test_sizes_are_those_of_cflib(hovering):
    """crtp-cflib 12, 13, 14: header and payload."""
    sent = []
    drone = hovering.drones[0]
    drone.uplink.transport = lambda verb, arguments: sent.append((verb, packet_sizes(verb, arguments)))
    drone.commander.send_full_state_setpoint([0, 0, 1], [0, 0, 0], [0, 0, 0], [0, 0, 0, 1], 0, 0, 0)
    drone.commander.send_setpoint(0, 0, 0, 0)
    drone.loc.send_extpose([0, 0, 1], [0, 0, 0, 1])
    drone.high_level_commander.land(0.0, 2.0)
    drone.receive_packet(8, 0, bytes(2))
    assert sent == [
        ("packet", [30]),
        ("cf_send_rpyt", [15]),
        ("cf_send_external_pose", [30]),
        ("cf_land", [16]),
        ("packet", [3]),
    ]


def test_known_sizes_belong_to_requests(hovering):
    uplink = hovering.drones[0].uplink
    plain = [verb for verb in PACKET_BYTES if verb not in ("cf_send_external_pose", "cf_spiral")]
    assert all(uplink.is_request(verb, ()) for verb in plain)


def test_faults_of_the_radio_come_before_the_link(hovering):
    radio = join(hovering)
    drone = hovering.drones[0]
    begin = hovering.time
    hovering.add_fault(RadioFault(at=begin, loss=1.0, duration=0.1, poses=False))
    hovering.add_fault(RadioFault(at=begin + 0.1, latency=0.05, duration=0.1, poses=False))
    drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
    hovering.step(110)
    assert up(radio)["sent"] == 0
    drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
    hovering.step(40)
    assert up(radio)["sent"] == 0
    hovering.step(30)
    assert up(radio)["delivered"] == 1


# ---------------------------------------------------------------- determinism, other times


def hard_flight(world, ticks=1500, every=25):
    for k in range(ticks // every):
        for drone in world.drones:
            drone.commander.send_position_setpoint(0.2 * math.sin(k / 9), 0.0, 1.0, 0.0)
        world.step(every)


HARD = {"loss": 0.4, "retries": 1, "latency_ms": 40.0, "jitter_ms": 10.0, "reorder": 0.2, "duplicate": 0.1}


def test_same_seed_same_bits(hover):
    ends = []
    for seed in (7, 7, 8):
        world = new_world()
        world.restore(hover)
        join(world, seed, **HARD)
        hard_flight(world)
        ends.append(world.drones[0].memory.tobytes())
    assert ends[0] == ends[1] != ends[2]


def test_a_world_that_goes_back_finds_under_way_what_was_under_way(hovering):
    radio = join(hovering, **HARD)
    hard_flight(hovering, 500)
    snapshot = hovering.snapshot()
    assert up(radio)["under_way"] > 0
    counted = up(radio)
    hard_flight(hovering, 500)
    first = hovering.drones[0].memory.tobytes()
    end = up(radio)
    hovering.restore(snapshot)
    assert up(radio) == counted
    hard_flight(hovering, 500)
    assert hovering.drones[0].memory.tobytes() == first
    assert up(radio) == end


def test_a_fork_takes_along_what_is_under_way(hovering):
    join(hovering, **HARD)
    hard_flight(hovering, 500)
    (fork,) = hovering.fork()
    (grandchild,) = fork.fork()
    worlds = (hovering, fork, grandchild)
    for world in worlds:
        hard_flight(world, 500)
    assert len({world.drones[0].memory.tobytes() for world in worlds}) == 1
    assert [len(world.when_forked) for world in worlds] == [1, 1, 1]


def test_a_world_that_starts_again_has_nothing_under_way(hovering):
    radio = join(hovering, latency_ms=100.0)
    hovering.drones[0].commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)
    hovering.reset()
    hovering.step(200)
    assert up(radio)["sent"] == 0
    assert len(list(hovering.journal)) == 0


def test_the_radio_is_used_by_all_drones_in_turn():
    world = new_world(3)
    radio = join(world)
    for drone in world.drones:
        drone.param["stabilizer.controller"] = 1
    assert [radio.link.statistics()["drones"][drone.id]["up"]["sent"] for drone in world.drones] == [1, 1, 1]
    world.step(10)
    assert all(up(radio, drone.id)["delivered"] == 1 for drone in world.drones)
    assert radio.link.next_arrival() == math.inf
    assert Direction.UP in radio.link.dongles[0].links[0].tallies
