"""Checkouts of several releases, whole and with files missing: what their libraries are, and what they do instead."""

import numpy as np
import pytest
from flight_inputs import GOAL, START, pieces_of, random_inputs, random_measurement
from side_by_side import Drone, all_of, complementary_flight, control_of, filter_step, same

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import load_library
from crazychoir_fw.simulation import DroneConfig, World

BRUSHLESS = lib.CF_PLATFORM_CF21BL


# ----------------------------------------------------------------------------------------------- what it is


def test_parameters_and_logs_are_those_of_the_builtin_provider(pair):
    builtin, bitcraze = pair
    for which in ("parameters", "logs"):
        ours, theirs = builtin.variables(which), bitcraze.variables(which)
        assert {name: row[:2] for name, row in ours.items()} == {name: row[:2] for name, row in theirs.items()}
        for name in ours:
            mine, other = builtin.variable(which, name)[0], bitcraze.variable(which, name)[0]
            assert mine == other or (np.isnan(mine) and np.isnan(other)), name


_2025_02 = {
    *("plan_go_to_linear", "plan_spiral", "position_reset_at", "traj_eval_jerk", "traj_eval_omega"),
    "lighthouse_opening_window",
}
_2025_12 = {"controller_lee", "kalman_attitude_reversion", "kalman_predict_params", "power_cap_result", "setpoint_jerk"}
FEATURES = {
    "2024.10": set(),
    "2025.02": _2025_02,
    "2026.08": _2025_02 | _2025_12 | {"kalman_drag", "plan_start_trajectory_yaw", "tof_cone"},
}
ALWAYS = {"complementary", "lighthouse_model_lh2", "robust_tdoa"}


@pytest.mark.parametrize(("fixture", "release"), [("newest", "2026.08"), ("older", "2025.02"), ("oldest", "2024.10")])
def test_each_probe_answers_for_each_release(request, fixture, release):
    identity = request.getfixturevalue(fixture).identity
    assert set(identity["features"]) == FEATURES[release] | ALWAYS
    assert set(identity["missing_features"]) == FEATURES["2026.08"] - FEATURES[release]
    assert [name.rpartition("/")[2] for name in identity["host_mode"]] == ["collision_avoidance.c"]
    assert identity["notes"] == []


# --------------------------------------------------------------------------------- several drones, older releases


def test_a_flight_in_the_world_is_the_same_to_the_last_bit(newest):
    load_library(newest)  # the newest of its name, whatever other tests have loaded
    flights = []
    for provider in ("builtin", "bitcraze"):
        world = World([DroneConfig(f"cf{i}", (i, 0.0), provider=provider) for i in range(2)])
        world.wait_until_ready()
        for drone in world.drones:
            drone.high_level_commander.takeoff(0.5, 1.0)
        world.run(1.2)
        world.drones[1].high_level_commander.go_to(1.0, 0.5, 0.6, 1.0, 1.0)
        world.run(1.0)
        flights.append(world.positions())
    assert flights[0][1] == pytest.approx([1.0, 0.5, 0.6], abs=0.3)
    assert np.array_equal(*flights)


def test_drones_share_code_and_nothing_else(newest):
    number = load_library(newest)
    alone, *others = (Drone(number) for _ in range(3))
    controls = [ffi.new("control_t *") for _ in range(3)]
    own = [random_inputs(np.random.default_rng(seed)) for seed in (1, 1, 2)]
    expected = []
    for step in range(1, 60):
        alone.controller(controls[0], *own[0], step)
        expected.append(control_of(controls[0]))
    for step in range(1, 60):
        for drone, control, inputs in zip(others, controls[1:], own[1:], strict=True):
            drone.controller(control, *inputs, step)
        assert control_of(controls[1]) == expected[step - 1]
    assert control_of(controls[2]) != expected[-1]
    blocks = [ffi.buffer(drone.memory)[ffi.offsetof("cf_t", "provider_state") :] for drone in (alone, *others)]
    assert blocks[0] == blocks[1], "what a drone is does not depend on when it was asked"
    assert blocks[1] != blocks[2]


@pytest.mark.parametrize("fixture", ["older", "oldest"])
def test_older_releases_do_what_they_can(request, fixture, rng):
    """The library reports missing features; the others work as in newer releases."""
    builtin, old = Drone(0), Drone(load_library(request.getfixturevalue(fixture)))
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert old.controller_init(lib.ControllerTypeLee) == lib.CF_ERR_UNKNOWN
    names = [old.table.controller_name(number) for number in range(1, 5)]
    assert [ffi.string(name).decode() for name in names] == ["PID", "Mellinger", "INDI", "Brescianini"]

    control = ffi.new("control_t *")
    for number in range(1, 5):
        old.controller_init(number)
        for step in range(1, 40):
            old.controller(control, *random_inputs(rng), step)
        assert np.isfinite(control.thrust)
    control = ffi.new("control_t *", {"thrust": 65000.0, "roll": 5000})
    counts, duties = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_pwm_t *")
    old.power_distribution(control, counts)
    assert old.power_cap(counts, duties)
    assert max(duties.list) == 65535

    one, other = (filter_step(drone, 10, [], np.array([0, 0.1, 1]), np.ones(3)) for drone in (builtin, old))
    assert same(one[0], other[0])
    pose = ffi.new(
        "measurement_t *",
        {"type": lib.MeasurementTypePose, "data": {"pose": {"quat": {"w": 1}, "stdDevPos": 1, "stdDevQuat": 1}}},
    )
    one, other = (filter_step(drone, 20, [pose], np.array([0, 0.1, 1]), np.ones(3)) for drone in (builtin, old))
    assert same(one[0], other[0])

    for name, arguments in [
        ("plan_takeoff", (START, 1.0, 0.2, 1.0, 0.0)),
        ("plan_go_to", (memory, START, True, False, GOAL, 1.0, 2.0, 1.5)),
        ("plan_land", (START, 0.0, 0.0, 1.0, 5.0)),
    ]:
        assert all_of((builtin, old), name, *arguments) == 0
        for t in (0.5, 1.7, 2.5, 5.5):
            one, other = (drone.plan_current_goal(memory, t) for drone in (builtin, old))
            assert same(ffi.addressof(one.pos), ffi.addressof(other.pos))
            assert one.yaw == other.yaw
    pieces = pieces_of(rng, 2)
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"offset": 132, "n_pieces": 2, "timescale": 1.0})
    uploaded.relative_position = True
    assert all_of((builtin, old), "plan_start_trajectory", pieces, uploaded, START, 0.0) == 0
    one, other = (drone.plan_current_goal(pieces, 1.0) for drone in (builtin, old))
    assert same(ffi.addressof(one.pos), ffi.addressof(other.pos))
    assert old.console() == ""


def test_what_an_old_planner_lacks_is_told(oldest):
    old = Drone(load_library(oldest))
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert old.plan_spiral(START, ffi.new("cf_spiral_t *", {"duration": 1.0}), 0.0) == 1
    assert old.plan_is_stopped()
    assert old.plan_go_to(memory, START, False, True, GOAL, 0.0, 1.0, 0.0) == 0
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"n_pieces": 1, "timescale": 1.0, "relative_yaw": True})
    assert old.plan_start_trajectory(memory, uploaded, START, 0.0) == 0
    assert [line.partition(": ")[2] for line in old.console().splitlines()] == [
        "this firmware knows no spiral",
        "this firmware knows no linear go-to, it flies a smooth one",
        "this firmware does not turn trajectories to the present yaw",
    ]


# ------------------------------------------------------------------------------------------ checkouts that lack files


def test_a_missing_model_is_missed_once(poor):
    drone = Drone(load_library(poor), BRUSHLESS)
    pose = ffi.new(
        "measurement_t *",
        {"type": lib.MeasurementTypePose, "data": {"pose": {"pos": (1, 1, 1), "stdDevPos": 0.1, "stdDevQuat": 1}}},
    )
    for _ in range(3):
        drone.kalman_update(pose, ffi.new("Axis3f *"), 1)
    assert drone.console() == "ESTKALMAN: no model of poses in this build, measurements ignored\n"
    assert drone.variable("logs", "kalman.stateX")[0] == 0
    assert "mm_pose.c does not compile, left out" in " ".join(poor.identity["notes"])


def test_a_missing_complementary_estimator_is_that_of_the_builtin_provider(poor, rng):
    builtin, drone = Drone(0, BRUSHLESS), Drone(load_library(poor), BRUSHLESS)
    for one, other in complementary_flight((builtin, drone), rng, 200):
        assert same(one, other)
    assert drone.console().startswith("ESTIMATOR: ")
    for group in ("sensfusion6", "posEstAlt"):
        for which in ("parameters", "logs"):
            ours = {name for name in builtin.variables(which) if name.startswith(group)}
            assert ours <= drone.variables(which).keys()
    assert drone.variable("logs", "posEstAlt.estimatedZ")[0] == other.position.z


def test_a_missing_controller_has_no_name(poor):
    drone = Drone(load_library(poor), BRUSHLESS)
    assert drone.table.controller_name(lib.ControllerTypeINDI) == ffi.NULL
    assert drone.controller_init(lib.ControllerTypeINDI) == lib.CF_ERR_UNKNOWN
    assert not [name for name in drone.variables("parameters") if name.startswith("ctrlINDI")]


def test_without_the_supervisor_of_the_filter_its_limits_are_parameters_all_the_same(poor):
    drone = Drone(load_library(poor), BRUSHLESS)
    assert drone.variable("parameters", "kalman.maxPos")[0] == 100
    drone.cf.onboard.fault = 0
    drone.variable("logs", "kalman.stateX")[0] = 200
    assert not drone.kalman_is_within_bounds()
    drone.variable("parameters", "kalman.maxPos")[0] = 0
    assert drone.kalman_is_within_bounds()


# -------------------------------------------------------------------------------------------------- out of tree


def test_a_users_own_controller_and_estimator_see_the_types_of_the_checkout(poor, rng):
    drone = Drone(load_library(poor), BRUSHLESS)
    assert ffi.string(drone.table.controller_name(lib.ControllerTypeOot)) == b"OutOfTree"
    assert drone.controller_init(lib.ControllerTypeOot) == lib.CF_OK
    setpoint, sensors, estimate = random_inputs(rng)
    control = ffi.new("control_t *")
    for step in (1, 2):
        drone.controller(control, setpoint, sensors, estimate, step)
    total = np.float32(np.float32(setpoint.jerk.z) + np.float32(estimate.position.z)) + np.float32(sensors.gyro.x)
    assert (control.controlMode, control.torqueX) == (lib.controlModeForceTorque, 2)
    assert control.thrustSi == total

    drawn = {}
    while len(drawn) < 11:
        measurement = random_measurement(rng)
        drawn[measurement.type] = measurement
    queue = ffi.new("measurement_t[]", [measurement[0] for measurement in drawn.values()])
    drone.out_of_tree_estimator_init()
    estimate = ffi.new("state_t *", {"velocity": {"x": 7.0}})
    drone.out_of_tree_estimator(queue, len(queue), estimate, 1, 1)
    assert (estimate.position.x, estimate.velocity.x) == (11, 7)
    assert estimate.position.y == np.float32(-0.02)
    assert estimate.position.z == np.float32(0.1309)
