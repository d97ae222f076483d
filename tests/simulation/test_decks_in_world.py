"""Decks of drones in a world: presence flags, and what their parameters and logs say."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.simulation import DroneConfig, World

SYSTEMS = ["none", "mocap", "mocap_position", "lighthouse", "loco_twr", "loco_tdoa2", "loco_tdoa3", "flow"]
FLAGS = {
    "lighthouse": {"bcLighthouse4"},
    "loco_twr": {"bcLoco", "bcDWM1000"},
    "loco_tdoa2": {"bcLoco", "bcDWM1000"},
    "loco_tdoa3": {"bcLoco", "bcDWM1000"},
    "flow": {"bcFlow2", "bcZRanger2"},
}


def make(positioning, position=(0.0, 0.0), seed=1, **attributes):
    world = World([DroneConfig("cf1", position, positioning=positioning, attributes=attributes)], seed=seed)
    return world, world.drones[0]


@pytest.mark.parametrize("positioning", SYSTEMS)
def test_deck_flags_follow_the_positioning(positioning):
    _, drone = make(positioning)
    names = [name for name in drone.param if name.startswith("deck.")]
    # docs/reference/crtp-cflib.md#20.2: the client falls over when one of these is missing
    assert {"deck.bcFlow", "deck.bcFlow2", "deck.bcLighthouse4", "deck.bcLoco", "deck.bcDWM1000"} <= set(names)
    mounted = {name.removeprefix("deck.") for name in names if drone.param[name]}
    assert mounted == FLAGS.get(positioning, set())


def test_deck_flags_cannot_be_written():
    _, drone = make("flow")
    with pytest.raises(StateError, match="bcFlow2 is read-only"):
        drone.param["deck.bcFlow2"] = 0


def test_lighthouse_tells_what_it_receives():
    world, drone = make("lighthouse")
    world.run(3.1)
    assert drone.param["lighthouse.method"] == 1
    assert drone.param["lighthouse.systemType"] == 2
    for name in ("bsAvailable", "bsReceive", "bsActive", "bsCalVal", "bsCalCon", "bsGeoVal"):
        assert drone.log[f"lighthouse.{name}"] == 3
    assert drone.log["lighthouse.bsCalUd"] == 0
    assert drone.log["lighthouse.status"] == 2


def test_lighthouse_out_of_sight_says_so():
    world, drone = make("lighthouse", position=(9.0, 9.0))
    world.run(3.1)
    assert drone.log["lighthouse.bsReceive"] == 0
    assert drone.log["lighthouse.status"] == 0


@pytest.mark.parametrize("method", [0, 1])
def test_lighthouse_finds_its_place_by_either_method(method):
    ideal = {"lighthouse_position_error": 0.0, "lighthouse_attitude_error": 0.0}
    world, drone = make("lighthouse", position=(0.8, -0.5), **ideal)
    drone.param["lighthouse.method"] = method
    # told a wrong start, it can only learn from light
    drone.param["kalman.initialX"] = 0.0
    drone.param["kalman.initialYaw"] = 0.3
    drone.param["kalman.resetEstimation"] = 1
    world.run(5.0)
    assert np.linalg.norm(drone.estimated_position - drone.true_position) < 0.01
    assert abs(drone.log["stateEstimate.yaw"]) < 5.0


def test_twr_ranges_are_in_the_log():
    world, drone = make("loco_twr", loco_noise=0.0, loco_bias=0.0, loco_outlier=0.0)
    world.run(3.1)
    corners = np.array([(x, y) for x, y in ((-1, -1), (-1, 1), (1, 1), (1, -1))] * 2) * 2.5
    heights = np.array([0.2, 2.4] * 2 + [2.4, 0.2] * 2)
    anchors = np.column_stack([corners, heights])
    expected = np.linalg.norm(anchors - drone.true_position, axis=1)
    assert [drone.log[f"ranging.distance{i}"] for i in range(8)] == pytest.approx(expected, abs=1e-4)
    assert drone.log["ranging.state"] == 255


def test_deck_in_another_mode_than_its_anchors_hears_nothing():
    world, drone = make("loco_tdoa2")
    world.run(3.1)
    assert drone.log["ranging.state"] == 255
    drone.param["loco.mode"] = 3
    world.run(2.0)
    assert drone.log["ranging.state"] == 0


def test_two_dimensions_keep_the_height():
    world, drone = make("loco_tdoa2", loco_2d="on", loco_height=0.4)
    world.run(4.0)
    assert drone.log["stateEstimate.z"] == pytest.approx(0.4, abs=0.01)


def test_anchors_and_base_stations_can_be_placed():
    world, drone = make("loco_twr", anchor3=(1.0, 2.0, 3.0), loco_noise=0.0, loco_bias=0.0, loco_outlier=0.0)
    world.run(3.1)
    assert drone.log["ranging.distance3"] == pytest.approx(np.linalg.norm(drone.true_position - (1, 2, 3)), abs=1e-4)
    stations = {"base_station1": "7 9 2 9 9 0.5", "base_station2": (11.0, 9.0, 2.0, 9.0, 9.0, 0.5)}
    world, drone = make("lighthouse", position=(9.0, 9.0), **stations)
    world.run(3.1)
    assert drone.log["lighthouse.bsActive"] == 3


@pytest.mark.parametrize("value", ["1 2", "1 2 3 4", "1 2 x", "1 2 nan", "1 2 1001", (1.0, 2.0)])
def test_wrong_vector_ends_in_one_sentence(value):
    with pytest.raises(RangeError, match=r"crazyflie cf1: anchor0 is '1\.?0? .*', allowed: 3 numbers -1000 to 1000"):
        make("loco_twr", anchor0=value)


def test_flow_deck_is_in_the_log():
    world, drone = make("flow", position=(0.0, 0.0, 0.5))
    world.run(0.2)
    assert drone.log["range.zrange"] == pytest.approx(1000 * drone.true_position[2], abs=150)
    assert drone.log["motion.motion"] == 0xB0
    assert drone.log["motion.std"] == 2.0
    assert drone.log["motion.squal"] > 0
    assert drone.log["range.front"] == 0


def test_flow_can_be_disabled():
    world, drone = make("flow", position=(0.0, 0.0, 0.5))
    world.run(2.0)
    drone.param["motion.disable"] = 1
    world.run(2.05)
    # two inertial samples per millisecond, 40 ranges and 50 pressures, nothing else
    assert drone.log["estimator.rtApnd"] == pytest.approx(2090, abs=3)


def test_mocap_position_brings_no_heading():
    world, drone = make("mocap_position")
    drone.param["kalman.initialYaw"] = 0.5
    world.run(3.0)
    assert drone.log["stateEstimate.yaw"] == pytest.approx(np.degrees(0.5), abs=2.0)
    assert np.linalg.norm(drone.estimated_position - drone.true_position) < 0.01


def test_reboot_keeps_decks_and_geometry():
    world, drone = make("lighthouse")
    world.run(3.0)
    drone.reboot()
    world.run(3.1)
    assert drone.param["deck.bcLighthouse4"] == 1
    assert drone.log["lighthouse.status"] == 2


@pytest.mark.parametrize("positioning", SYSTEMS)
def test_same_seed_same_bits(positioning):
    def fly(seed):
        world, drone = make(positioning, seed=seed)
        world.run(2.0)
        return [drone.log[name] for name in ("kalman.stateX", "kalman.varX", "gyro.x", "kalman.stateZ")]

    assert fly(3) == fly(3)
    assert fly(3) != fly(4)
