"""A library from the miniature checkout beside the builtin provider: the same laws, therefore the same bits.

The filter of the miniature computes with full matrices, that of the builtin provider leaves out zeros; its planner
and its controllers keep their state at file scope and by pointers. Whatever the adapter loses or swaps shows here.
"""

import numpy as np
import pytest
from miniature import lay_out
from side_by_side import Drone, same

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.core import load_library
from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.simulation import DroneConfig, World

BRUSHLESS = lib.CF_PLATFORM_CF21BL
DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity
STEPS = 600  # of the loop, for what is compared step by step
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="module")
def build(place):
    """Build a library from a checkout, as fast as the compiler can, in the cache of this module."""

    def run(checkout, platform="cf2", apps=()):
        script = checkout / "bindings" / "setup.py"
        script.write_text(script.read_text().replace('"-O3"', '"-O0"'))
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("CRAZYCHOIR_CACHE", str(place / "cache"))
            return build_provider(checkout, platform, apps)

    return run


@pytest.fixture(scope="module")
def newest(place, build):
    return build(lay_out(place / "2026.08", release="2026.08", setup_py="2026"))


@pytest.fixture(scope="module")
def older(place, build):
    return build(lay_out(place / "2025.02", release="2025.02", setup_py="2025"))


@pytest.fixture(scope="module")
def oldest(place, build):
    return build(lay_out(place / "2024.10", release="2024.10", setup_py="2023"))


APP = """
#include "controller.h"
#include "estimator/estimator.h"
#include "stabilizer_types.h"

static int count;

void controllerOutOfTreeInit(void) { count = 0; }
bool controllerOutOfTreeTest(void) { return true; }
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep) {
  count++;
  control->controlMode = controlModeForceTorque;
  control->thrustSi = setpoint->jerk.z + state->position.z + sensors->gyro.x;
  control->torqueX = count;
}

void estimatorOutOfTreeInit(void) {}
bool estimatorOutOfTreeTest(void) { return true; }
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) {
  measurement_t m;
  state->position.x = 0;
  while (estimatorDequeue(&m)) {
    state->position.x += 1;
    if (m.type == MeasurementTypeSweepAngle) {
      state->position.y = m.data.sweepAngle.calib->tilt;
    } else if (m.type == MeasurementTypeTOF) {
      state->position.z = m.data.tof.coneHalfAngle;
    }
  }
}
"""

BROKEN = '#error "needs a driver"\n'


@pytest.fixture(scope="module")
def poor(place, build):
    """For the other platform, with an app; the pose model and the complementary estimator do not compile, and there
    are neither INDI nor the supervisor of the filter."""
    checkout = lay_out(place / "poor", release="2026.08", setup_py="2025")
    modules = checkout / "src/modules/src"
    (modules / "kalman_core/mm_pose.c").write_text(BROKEN)
    (modules / "estimator/position_estimator_altitude.c").write_text(BROKEN)
    (modules / "kalman_supervisor.c").unlink()
    (modules / "controller/controller_indi.c").unlink()
    (place / "mine.c").write_text(APP)
    return build(checkout, "cf21bl", [place / "mine.c"])


@pytest.fixture
def pair(newest):
    """A builtin drone and one of the newest release."""
    return Drone(0), Drone(load_library(newest))


@pytest.fixture
def rng():
    return np.random.default_rng(4)


# ----------------------------------------------------------------------------------------------- what it is


def test_parameters_and_logs_are_those_of_the_builtin_provider(pair):
    builtin, bitcraze = pair
    for which in ("parameters", "logs"):
        ours, theirs = builtin.variables(which), bitcraze.variables(which)
        assert {name: row[:2] for name, row in ours.items()} == {name: row[:2] for name, row in theirs.items()}
        for name in ours:
            mine, other = builtin.variable(which, name)[0], bitcraze.variable(which, name)[0]
            assert mine == other or (np.isnan(mine) and np.isnan(other)), name


FEATURES = {
    "2024.10": set(),
    "2025.02": {"plan_go_to_linear", "plan_spiral", "power_cap_result", "traj_eval_jerk"},
    "2026.08": {
        *("plan_go_to_linear", "plan_spiral", "power_cap_result", "traj_eval_jerk"),
        *("plan_start_trajectory_yaw", "setpoint_jerk", "tof_cone", "kalman_predict_params", "kalman_drag"),
        *("position_reset_at", "controller_lee"),
    },
}
ALWAYS = {"complementary", "kalman_attitude_reversion", "lighthouse_model_lh2"}


@pytest.mark.parametrize(("fixture", "release"), [("newest", "2026.08"), ("older", "2025.02"), ("oldest", "2024.10")])
def test_each_probe_answers_for_each_release(request, fixture, release):
    identity = request.getfixturevalue(fixture).identity
    assert set(identity["features"]) == FEATURES[release] | ALWAYS
    assert set(identity["missing_features"]) == FEATURES["2026.08"] - FEATURES[release]
    lee = ["controller_lee.c"] if "controller_lee" in FEATURES[release] else []
    assert [name.rpartition("/")[2] for name in identity["vehicle_mode"]] == [*lee, "controller_mellinger.c"]
    assert identity["notes"] == []


# ---------------------------------------------------------------------------------------------- controllers


def random_inputs(rng):
    """Return setpoint, sensors and estimate as they come in flight, and now and then as they should not."""

    def xyz(size):
        return dict(zip("xyz", rng.normal(0, size, 3).tolist(), strict=True))

    def rpy(size):
        return dict(zip(("roll", "pitch", "yaw"), rng.normal(0, size, 3).tolist(), strict=True))

    q = rng.normal(0, 1, 4) + np.array([0, 0, 0, 3])
    q = dict(zip("xyzw", (q / np.linalg.norm(q)).tolist(), strict=True))
    names = ("x", "y", "z", "roll", "pitch", "yaw", "quat")
    setpoint = {
        "mode": dict(zip(names, rng.choice([DISABLE, ABS, VELOCITY], 7).tolist(), strict=True)),
        "attitude": rpy(20),
        "attitudeRate": rpy(100),
        "attitudeQuaternion": q,
        "thrust": float(rng.choice([0, 500, 30000, 65535])),
        "position": xyz(1),
        "velocity": xyz(0.5),
        "acceleration": xyz(1),
        "jerk": xyz(1),
        "velocity_body": bool(rng.integers(2)),
    }
    estimate = {
        "attitude": rpy(20),
        "attitudeQuaternion": q,
        "position": xyz(1),
        "velocity": xyz(0.5),
        "acc": xyz(0.1),
    }
    sensors = {"gyro": {"axis": rng.normal(0, 50, 3).tolist()}, "acc": {"axis": rng.normal(0, 1, 3).tolist()}}
    return (
        ffi.new("setpoint_t *", setpoint),
        ffi.new("sensorData_t *", sensors),
        ffi.new("state_t *", estimate),
    )


def control_of(control):
    if control.controlMode == lib.controlModeLegacy:
        return [control.roll, control.pitch, control.yaw, control.thrust]
    return list(control.normalizedForces)


def motors_of(drone, control):
    """Return counts, compensated counts, duties and whether they were reduced."""
    uncapped = ffi.new("motors_thrust_uncapped_t *")
    compensated = ffi.new("motors_thrust_uncapped_t *")
    pwm = ffi.new("motors_thrust_pwm_t *")
    drone.power_distribution(control, uncapped)
    drone.battery_compensate(uncapped, 3.7, compensated)
    reduced = drone.power_cap(compensated, pwm)
    drone.motor_override(3.7, pwm)
    return [list(uncapped.list), list(compensated.list), list(pwm.list), reduced]


@pytest.mark.parametrize("number", [1, 2, 3, 4, 5])
def test_each_controller_gives_the_same_bits(pair, rng, number):
    for drone in pair:
        assert ffi.string(drone.table.controller_name(number)) == ffi.string(lib.cf_provider(0).controller_name(number))
        assert drone.controller_init(number) == lib.CF_OK
        assert drone.controller_type() == number
    controls = [ffi.new("control_t *") for _ in pair]
    outputs = set()
    for step in range(1, STEPS):
        if step % 20 == 1:
            inputs = random_inputs(rng)
        for drone, control in zip(pair, controls, strict=True):
            drone.controller(control, *inputs, step)
        assert controls[0].controlMode == controls[1].controlMode
        assert control_of(controls[0]) == control_of(controls[1]), step
        assert motors_of(pair[0], controls[0]) == motors_of(pair[1], controls[1])
        outputs.add(tuple(control_of(controls[0])))
    assert len(outputs) > 15, "the controllers were really at work"


def test_selecting_a_controller_in_flight_resets_as_much_as_on_the_vehicle(pair, rng):
    controls = [ffi.new("control_t *") for _ in pair]
    for step in range(1, STEPS):
        if step % 40 == 1:
            number = int(rng.integers(0, 6))
            assert [drone.controller_init(number) for drone in pair] == [lib.CF_OK, lib.CF_OK]
        if step % 60 == 1:
            inputs = random_inputs(rng)
        if step % 130 == 0:
            position = ffi.new("point_t *", {"x": 0.3, "y": -0.2, "z": 0.7})
            for drone in pair:
                drone.reset_position_control(position)
        for drone, control in zip(pair, controls, strict=True):
            drone.controller(control, *inputs, step)
        assert control_of(controls[0]) == control_of(controls[1]), step


@pytest.mark.parametrize("number", [-1, 6, 7, 99])
def test_a_controller_that_is_not_there_is_refused_and_the_other_flies_on(pair, number):
    for drone in pair:
        assert drone.table.controller_name(number) == ffi.NULL
        assert drone.controller_init(number) == lib.CF_ERR_UNKNOWN
        assert drone.controller_type() == lib.ControllerTypePID


def test_the_mixer_knows_every_mode(pair, rng):
    for mode in [lib.controlModeLegacy, lib.controlModeForceTorque, lib.controlModeForce, lib.controlModePWM, 9]:
        for _ in range(20):
            control = ffi.new("control_t *", {"normalizedForces": rng.normal(0.3, 0.5, 4).tolist()})
            if mode == lib.controlModeLegacy:
                control.roll, control.pitch, control.yaw = (int(x) for x in rng.integers(-32767, 32768, 3))
                control.thrust = float(rng.uniform(0, 65535))
            control.controlMode = ffi.cast("control_mode_t", mode)
            assert motors_of(pair[0], control) == motors_of(pair[1], control)
    assert pair[0].idle_thrust() == pair[1].idle_thrust() == 0


def test_the_test_override_acts_on_every_duty(pair):
    for drone in pair:
        drone.variable("parameters", "motorPowerSet.enable")[0] = 3
        drone.variable("parameters", "motorPowerSet.m1")[0] = 20000
    duties = [ffi.new("motors_thrust_pwm_t *") for _ in pair]
    for _ in range(3):
        for drone, pwm in zip(pair, duties, strict=True):
            drone.motor_override(3.5, pwm)
        assert list(duties[0].list) == list(duties[1].list) != [0] * 4


def test_the_brushless_platform_has_its_own_gains_and_motors(poor, rng):
    drones = [Drone(number, BRUSHLESS) for number in (0, load_library(poor))]
    controls = [ffi.new("control_t *") for _ in drones]
    inputs = random_inputs(rng)
    for step in range(1, 40):
        for drone, control in zip(drones, controls, strict=True):
            drone.controller(control, *inputs, step)
        assert motors_of(drones[0], controls[0]) == motors_of(drones[1], controls[1])
    assert drones[0].idle_thrust() == drones[1].idle_thrust() == 7000
    config, memory = ffi.new("cf_config_t *"), ffi.new("double[]", lib.cf_state_bytes(drones[1].provider) // 8)
    lib.cf_config_default(config, lib.CF_PLATFORM_CF2)
    config.provider = drones[1].provider
    assert lib.cf_init(ffi.cast("cf_t *", memory), config) != lib.CF_OK, "its gains are for another airframe"


# ----------------------------------------------------------------------------------------------- estimators

SWEEPS = {
    "sensor": ffi.new("vec3d *", (0.015, 0.0075, 0.0)),
    "origin": ffi.new("vec3d *", (-2.0, 1.0, 2.0)),
    "turn": ffi.new("mat3d *", ((1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "calibration": ffi.new("lighthouseCalibrationSweep_t *", {"phase": 0.01, "tilt": -0.02, "gibmag": 0.003}),
}


def random_measurement(rng):
    """Return one measurement of any type, near a drone that hovers at (0, 0, 1)."""
    near = (UP + rng.normal(0, 0.02, 3)).tolist()
    anchors = [dict(zip("xyz", rng.uniform(-3, 3, 3).tolist(), strict=True)) for _ in range(2)]
    kinds = {
        lib.MeasurementTypeTDOA: {
            "tdoa": {"anchorPositions": anchors, "distanceDiff": rng.normal(0, 0.5), "stdDev": 0.15}
        },
        lib.MeasurementTypePosition: {"position": {"pos": near, "stdDev": 0.01}},
        lib.MeasurementTypePose: {
            "pose": {"pos": near, "quat": {"z": 0.05, "w": 0.99}, "stdDevPos": 0.01, "stdDevQuat": 0.0045}
        },
        lib.MeasurementTypeDistance: {
            "distance": {"pos": list(anchors[0].values()), "distance": rng.uniform(1, 4), "stdDev": 0.25}
        },
        lib.MeasurementTypeTOF: {"tof": {"distance": near[2], "stdDev": 0.01, "coneHalfAngle": 0.1309}},
        lib.MeasurementTypeAbsoluteHeight: {"height": {"height": near[2], "stdDev": 0.02}},
        lib.MeasurementTypeFlow: {
            "flow": {"dpixel": rng.normal(0, 5, 2).tolist(), "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
        },
        lib.MeasurementTypeYawError: {"yawError": {"yawError": rng.normal(0, 0.02), "stdDev": 0.01}},
        lib.MeasurementTypeSweepAngle: {
            "sweepAngle": {
                "sensorPos": SWEEPS["sensor"],
                "rotorPos": SWEEPS["origin"],
                "rotorRot": SWEEPS["turn"],
                "rotorRotInv": SWEEPS["turn"],
                "t": 0.5236 * float(rng.choice([-1, 1])),
                "measuredSweepAngle": -0.4636 + rng.normal(0, 0.3),
                "stdDev": 0.0005,
                "calib": SWEEPS["calibration"],
                "calibrationMeasurementModel": ffi.addressof(lib, "lighthouseCalibrationMeasurementModelLh2"),
            }
        },
        lib.MeasurementTypeGyroscope: {"gyroscope": {"gyro": {"axis": near}}},
        lib.MeasurementTypeBarometer: {"barometer": {"baro": {"asl": 100.0}}},
    }
    kind = int(rng.choice(list(kinds)))
    return ffi.new("measurement_t *", {"type": kind, "data": kinds[kind]})


def filter_step(drone, now, inputs, acc, gyro):
    """Run one millisecond of the estimator's task; return the estimate."""
    average, turning = (
        ffi.new("Axis3f *", {"axis": (acc * 9.81).tolist()}),
        ffi.new("Axis3f *", {"axis": gyro.tolist()}),
    )
    felt, latest = ffi.new("Axis3f *", {"axis": acc.tolist()}), ffi.new("Axis3f *", {"axis": np.degrees(gyro).tolist()})
    if now % 10 == 0:
        drone.kalman_predict(average, turning, now, now > 300)
    drone.kalman_add_process_noise(now)
    for measurement in inputs:
        drone.kalman_update(measurement, latest, now)
    finished = drone.kalman_finalize()
    estimate = ffi.new("state_t *")
    drone.kalman_externalize(estimate, felt)
    return estimate, finished, drone.kalman_is_within_bounds()


def test_the_filter_gives_the_same_bits_for_every_measurement(pair, rng):
    seen = set()
    for drone in pair:
        drone.variable("parameters", "kalman.initialYaw")[0] = 0.3
        drone.variable("parameters", "flowdeck.flowdeckPos_x")[0] = 0.02
        drone.kalman_init(0)
    for now in range(1, STEPS):
        inputs = [random_measurement(rng) for _ in range(int(rng.integers(0, 3)))]
        seen |= {measurement.type for measurement in inputs}
        acc, gyro = UP + rng.normal(0, 0.05, 3), rng.normal(0, 0.3, 3)
        one, other = (filter_step(drone, now, inputs, acc, gyro) for drone in pair)
        assert same(one[0], other[0]), now
        assert one[1:] == other[1:]
    assert len(seen) == 11
    logs = [
        name
        for name in pair[0].variables("logs")
        if name.split(".")[0] in ("kalman", "kalman_pred", "outlierf", "tdoa")
    ]
    for name in logs:
        assert pair[0].variable("logs", name)[0] == pair[1].variable("logs", name)[0], name
    assert pair[0].variable("logs", "kalman_pred.measNX")[0] != 0


def test_the_robust_models_are_chosen_by_parameter(pair, rng):
    kinds = (lib.MeasurementTypeTDOA, lib.MeasurementTypeDistance)
    estimates = []
    for robust in (0, 1):
        for drone in pair:
            drone.variable("parameters", "kalman.robustTdoa")[0] = robust
            drone.variable("parameters", "kalman.robustTwr")[0] = robust
            drone.kalman_init(0)
        for now in range(1, 100):
            drawn = [random_measurement(np.random.default_rng([now, k])) for k in range(8)]
            inputs = [measurement for measurement in drawn if measurement.type in kinds]
            still = np.array([0.0, 0.0, 1.0]), np.zeros(3)
            one, other = (filter_step(drone, now, inputs, *still) for drone in pair)
            assert same(one[0], other[0]), now
        estimates.append(one[0].position.x)
    assert estimates[0] != estimates[1]


def test_a_drone_without_drift_to_its_first_attitude(pair):
    for drone in pair:
        drone.kalman_disable_attitude_reversion()
    tilted = np.array([0.0, 0.2, 1.0]), np.array([0.2, 0.0, 0.0])
    for now in range(1, 100):
        one, other = (filter_step(drone, now, [], *tilted) for drone in pair)
    assert same(one[0], other[0])
    assert one[0].attitude.roll == pytest.approx(np.degrees(0.2 * 0.09), rel=1e-2)


def test_a_lost_filter_is_told(pair):
    far = ffi.new(
        "measurement_t *",
        {"type": lib.MeasurementTypePosition, "data": {"position": {"pos": (200, 0, 0), "stdDev": 1e-3}}},
    )
    for drone in pair:
        drone.kalman_update(far, ffi.new("Axis3f *"), 1)
        assert not drone.kalman_is_within_bounds()
        drone.variable("parameters", "kalman.maxPos")[0] = 300
        assert drone.kalman_is_within_bounds()
        drone.variable("parameters", "kalman.pNVel")[0] = float("nan")
        drone.kalman_predict(ffi.new("Axis3f *"), ffi.new("Axis3f *"), 10, True)
        estimate = ffi.new("state_t *")
        drone.kalman_externalize(estimate, ffi.new("Axis3f *"))
        assert np.isnan(estimate.position.x), "noise that is no number must not be flown with"


def complementary_flight(drones, rng, steps=STEPS):
    """Fly the complementary estimator of several drones; yield their estimates after each step."""
    latest = ffi.new("cf_latest_samples_t *")
    estimates = [ffi.new("state_t *") for _ in drones]
    for drone in drones:
        drone.complementary_init()
    for step in range(1, steps):
        latest.gyro.axis = rng.normal(0, 20, 3).tolist()
        latest.acc.axis = (UP + rng.normal(0, 0.1, 3)).tolist()
        latest.baro.asl = 50 + rng.normal(0, 0.1)
        if step > steps / 2 and step % 25 == 0:
            latest.tof.timestamp, latest.tof.distance = step, 0.5
        for drone, estimate in zip(drones, estimates, strict=True):
            drone.complementary(latest, estimate, step, 1000 + step if step < steps / 2 else step)
        yield estimates


def test_the_complementary_estimator_gives_the_same_bits(pair, rng):
    for one, other in complementary_flight(pair, rng):
        assert same(one, other)
    assert one.position.z != 0 and one.attitude.roll != 0
    assert pair[1].variable("logs", "posEstAlt.estimatedZ")[0] == one.position.z
    assert pair[1].console() == ""


# -------------------------------------------------------------------------------------------------- planner

START = ffi.new("cf_plan_start_t *", {"pos": (0.1, -0.2, 0.3), "vel": (0.1, 0.0, 0.0), "yaw": 0.4})
GOAL = ffi.new("struct vec *", (1.0, 0.5, 1.2))[0]


def goals(drone, memory, times):
    found = []
    for t in times:
        goal = drone.plan_current_goal(memory, t)
        found.append([goal, drone.plan_state(), drone.plan_is_finished(memory, t)])
    return found


def assert_same_plans(pair, memory=None, times=None):
    times = np.arange(0, 4, 0.25).tolist() if times is None else times
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES) if memory is None else memory
    one, other = (goals(drone, memory, times) for drone in pair)
    for (goal, *rest), (their_goal, *their_rest) in zip(one, other, strict=True):
        assert same(ffi.new("struct traj_eval *", goal), ffi.new("struct traj_eval *", their_goal))
        assert rest == their_rest
    return one


def all_of(pair, name, *arguments):
    """Ask all drones; they must agree."""
    answers = [getattr(drone, name)(*arguments) for drone in pair]
    assert len(set(answers)) == 1, name
    return answers[0]


def test_a_flight_from_take_off_to_landing(pair):
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert all_of(pair, "plan_is_stopped")
    assert all_of(pair, "plan_takeoff", START, 1.0, 0.2, 1.0, 0.0) == 0
    assert all_of(pair, "plan_takeoff", START, 1.0, 0.2, 1.0, 0.0) == 1, "not from the air"
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, False, False, GOAL, 1.0, 2.0, 1.5) == 0
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, True, True, GOAL, 3.0, 2.0, 2.5) == 0
    assert_same_plans(pair, memory)
    spiral = {"angle": 4.0, "radius0": 0.5, "radiusF": 1.0, "ascent": 0.3, "duration": 2.0}
    for sideways, clockwise in [(False, False), (True, True)]:
        turn = ffi.new("cf_spiral_t *", {**spiral, "sideways": sideways, "clockwise": clockwise})
        assert all_of(pair, "plan_spiral", START, turn, 0.0) == 0
        assert_same_plans(pair, memory)
    all_of(pair, "plan_disable")
    assert all_of(pair, "plan_is_disabled")
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, False, False, GOAL, 1.0, 2.0, 0.0) == 0, "from where it is"
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_land", START, 0.0, 0.0, 1.0, 0.0) == 0
    assert all_of(pair, "plan_land", START, 0.0, 0.0, 1.0, 0.0) == 1
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_is_stopped"), "landed"
    all_of(pair, "plan_stop")
    assert all_of(pair, "plan_state") == lib.TRAJECTORY_STATE_IDLE


def pieces_of(rng, count):
    """Return the memory with `count` random pieces from 132 bytes on."""
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    pieces = ffi.cast("float *", memory + 132)
    for i in range(count):
        values = rng.normal(0, 0.3, 33)
        values[32] = 0.7 + 0.1 * i
        for k, value in enumerate(values.tolist()):
            pieces[33 * i + k] = value
    return memory


@pytest.mark.parametrize("reversed_", [False, True])
@pytest.mark.parametrize("relative", [(False, False), (True, False), (True, True)])
def test_uploaded_trajectories(pair, rng, reversed_, relative):
    memory = pieces_of(rng, 3)
    uploaded = ffi.new(
        "cf_uploaded_trajectory_t *",
        {
            "type": lib.CF_TRAJECTORY_TYPE_POLY4D,
            "offset": 132,
            "n_pieces": 3,
            "timescale": 1.5,
            "reversed": reversed_,
            "relative_position": relative[0],
            "relative_yaw": relative[1],
        },
    )
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.1) == 0
    flown = assert_same_plans(pair, memory)
    assert flown[-1][2], "it is over"
    # the planner keeps no address of the memory: another place, other bytes
    moved = pieces_of(rng, 3)
    assert_same_plans(pair, moved)
    assert flown[4][0].pos.x != goals(pair[1], moved, [1.0])[0][0].pos.x
    assert all_of(pair, "plan_go_to", moved, START, False, False, GOAL, 1.0, 2.0, 1.0) == 0
    assert_same_plans(pair, moved)


def compressed(rng, count, end=True):
    """Return a compressed trajectory: a start and `count` pieces of all storage types."""
    data = rng.integers(-1000, 1000, 4).astype("<i2").tobytes()
    for i in range(count):
        types = [(i + axis) % 4 for axis in range(4)]
        points = sum((0, 1, 3, 7)[kind] for kind in types)
        header = sum(kind << 2 * axis for axis, kind in enumerate(types))
        data += bytes([header]) + (400 + 50 * i).to_bytes(2, "little")
        data += rng.integers(-1500, 1500, points).astype("<i2").tobytes()
    return data + (bytes(3) if end else b"")


@pytest.mark.parametrize("relative", [False, True])
def test_compressed_trajectories(pair, rng, relative):
    data = compressed(rng, 4)
    memory = ffi.new("uint8_t[]", bytes(100) + data + bytes(lib.CF_TRAJECTORY_MEMORY_BYTES - 100 - len(data)))
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
    uploaded = ffi.new(
        "cf_uploaded_trajectory_t *", {"type": kind, "offset": 100, "timescale": 1.0, "relative_position": relative}
    )
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.1) == 0
    assert_same_plans(pair, memory)
    assert_same_plans(pair, ffi.new("uint8_t[]", ffi.buffer(memory)[:]), times=[0.3, 2.0, 0.5])


def test_a_compressed_trajectory_ends_with_the_memory_at_the_latest(pair, rng):
    data = compressed(rng, 100, end=False)[: lib.CF_TRAJECTORY_MEMORY_BYTES - 4000]
    memory = ffi.new("uint8_t[]", bytes(4000) + data)
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"type": kind, "offset": 4000, "timescale": 1.0})
    bitcraze = pair[1]
    assert bitcraze.plan_start_trajectory(memory, uploaded, START, 0.0) == 0
    assert np.isfinite([goal.pos.x for goal, *_ in goals(bitcraze, memory, [0.0, 1.0, 100.0])]).all()
    uploaded.offset = lib.CF_TRAJECTORY_MEMORY_BYTES - 7
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.0) == 1
    assert bitcraze.cf.onboard.fault == 0


def test_pieces_beyond_the_memory_are_refused(pair):
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"type": kind, "offset": 4000, "n_pieces": 1, "timescale": 1.0})
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert pair[1].plan_start_trajectory(memory, uploaded, START, 0.0) == 1
    assert pair[1].plan_is_stopped()


# ---------------------------------------------------------------------------------------- collision avoidance


def test_collision_avoidance_bends_setpoints_alike(pair, rng):
    bent = 0
    for drone in pair:
        assert not drone.collision_avoidance_is_enabled()
        drone.variable("parameters", "colAv.enable")[0] = 1
        drone.variable("parameters", "colAv.maxPeerLocAge")[0] = 100
        assert drone.collision_avoidance_is_enabled()
    for now in range(0, 3000, 15):
        setpoint, sensors, estimate = random_inputs(rng)
        setpoint.mode.x = setpoint.mode.y = setpoint.mode.z = int(rng.choice([ABS, VELOCITY]))
        peers = ffi.new("cf_peer_t[]", lib.PEER_LOCALIZATION_MAX_NEIGHBORS)
        for i in range(int(rng.integers(0, 10))):
            place = dict(zip("xyz", rng.normal(0, 1, 3).tolist(), strict=True))
            peers[i] = {"id": i, "pos": {"timestamp": max(0, now - int(rng.integers(0, 200))), **place}}
        results = [ffi.new("setpoint_t *", setpoint[0]) for _ in pair]
        for drone, result in zip(pair, results, strict=True):
            drone.collision_avoidance(result, peers, sensors, estimate, now)
        assert ffi.buffer(results[0])[:] == ffi.buffer(results[1])[:]
        bent += ffi.buffer(results[0])[:] != ffi.buffer(setpoint)[:]
    assert bent > 50


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
    """What they lack is told; the rest is the same as ever."""
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
