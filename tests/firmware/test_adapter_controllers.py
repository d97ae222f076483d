"""Controllers, mixer and collision avoidance of a checkout beside those of the builtin provider: the same bits.

The miniature has the same laws, but keeps its state at file scope. Whatever the adapter loses or swaps shows here.
"""

import pytest
from flight_inputs import ABS, VELOCITY, random_inputs
from side_by_side import STEPS, Drone, control_of, motors_of

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.core import load_library

BRUSHLESS = lib.CF_PLATFORM_CF21BL


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
