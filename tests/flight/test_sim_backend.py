"""Layers on simulated drones: commands in bytes, same bits, journals, faults."""

import numpy as np
import pytest
from flown_layers import formation, hover, mission

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Twist
from crazychoir_fw.flight.backends import make_backend
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.flight.setpoints import setpoints
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.replay import replay


def short(**changes):
    """A formation that takes off and begins: all that a comparison of bits needs."""
    flight = [{"takeoff": {"duration": 1.5}}, {"start": {"duration": 1.0}}]
    return formation(backend="sim", flight=flight, **changes)


@pytest.mark.parametrize("kind", ["fpqr", "frpy", "vel"])
def test_setpoints_of_many_are_those_of_motor_controls(kind):
    names = {"fpqr": "MotorCtrlFPQR", "frpy": "MotorCtrlFRPY", "vel": "MotorCtrlVel"}
    world = World(
        [
            DroneConfig("a", (0, 0), motor_ctrl=names[kind]),
            DroneConfig("b", (1, 0), platform="cf21bl", motor_ctrl=names[kind]),
        ]
    )
    world.step(7)
    seen = []
    for drone in world.drones:
        drone.uplink.listeners.append(lambda verb, arguments: seen.append(arguments[0]))
    dice = np.random.default_rng(1)
    twist = Twist(dice.normal(size=(2, 3)), 4.0 * dice.normal(size=(2, 3)))
    for k, drone in enumerate(world.drones):
        drone.motor_ctrl.cmd_vel(twist.linear[k], twist.angular[k])
    most = np.array([drone.motor_ctrl.max_thrust for drone in world.drones])
    assert setpoints(twist, kind, most, world.tick) == b"".join(seen)


def test_numbers_that_are_none_are_refused():
    twist = Twist(np.zeros((2, 3)), np.array([[0, 0, 0], [0, np.nan, 0]]))
    with pytest.raises(RangeError, match="command 1 is linear"):
        setpoints(twist, "fpqr", np.ones(2), 0)


@pytest.fixture(scope="module")
def flown():
    return fly(mission(short(log_rate=50)), threads=1, visuals=False)


def test_same_bits_with_two_threads(flown):
    again = fly(mission(short(log_rate=50)), threads=2, visuals=False)
    for name, samples in flown.log.signals.items():
        assert np.array_equal(samples, again.log.signals[name], equal_nan=True), name


def test_a_replay_proves_the_flight(flown, tmp_path):
    flown.log.save(tmp_path / "log.npz")
    assert replay(tmp_path).deviation is None


def test_mocap_is_seen_through_the_filter():
    true, seen = (make_backend(mission(short()), threads=1) for _ in range(2))
    seen = make_backend(mission({**short(), "layers": {**short()["layers"], "odometry": "mocap"}}), threads=1)
    for _ in range(20):
        seen.poses()
        seen.advance(0.01)
    away = np.linalg.norm(seen.poses().position - seen.true_positions(), axis=1)
    assert 0.0 < away.max() < 0.01
    true.close()


def test_estimates_are_near_the_truth(flown):
    told = flown.log.stack("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
    true = flown.log.stack("sim.x", "sim.y", "sim.z")
    assert np.abs(told - true).max() < 0.03


def test_a_motor_that_dies_takes_its_own_drone_only():
    faults = [{"motor": {"drones": ["c"], "motor": 1, "at": 2.0, "efficiency": 0.0}}]
    data = formation(backend="sim", may_fail=["c"], faults=faults, criteria={"landed": True})
    data["drones"][2]["position"] = [0.8, 0.8]  # from where it falls on no other drone
    data["flight"] = [{"takeoff": {"duration": 3}}, {"start": {"duration": 2}}, {"land": {"duration": 4}}]
    result = fly(mission(data), visuals=False)
    assert result.success, result.failures
    assert result.expected_failures[0].startswith("c: ")
    assert [fault["kind"] for fault in result.summary["faults"]] == ["motor"]
    assert result.log.metadata["faults"] == result.summary["faults"]
    assert [drone["phase"] for drone in result.summary["drones"]] == ["landed", "landed", "failed", "landed"]
    lost = [event for event in result.summary["events"] if event["kind"] == "lost"]
    assert lost and all(event["details"]["reason"] == "lost c" for event in lost)


def test_the_planner_on_board_flies_goals():
    layers = {"rate": 50, "guidance": {"class": "GoToGuidance", "goals": {"a": [[2, 0, 0, 0.5]]}}}
    data = hover(backend="sim", layers=layers, criteria={"landed": False})
    experiment = make_experiment(mission(data))
    experiment.start()
    experiment.run(3.0)
    np.testing.assert_allclose(experiment.backend.true_positions()[0], [0, 0, 0.5], atol=0.05)


def test_radios_carry_the_commands_of_layers():
    data = hover(backend="sim", radios=[{"drones": ["a"], "loss": 0.02}])
    result = fly(mission(data), visuals=False)
    assert result.success, result.failures
    assert result.summary["link"]
