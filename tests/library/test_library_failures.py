"""Code that crashes stops its own drone with a reason, and no other drone."""

import platform
from pathlib import Path

import pytest

from crazychoir_fw._core import lib

ONLY_WHERE_DIVISIONS_TRAP = pytest.mark.skipif(platform.machine() != "x86_64", reason="an integer by zero is zero here")
OOT = lib.ControllerTypeOot
COUNT, FAULT = 10, 20
SOURCE = Path(__file__).parent / "apps/app_faults.c"
ASSERTION_LINE = next(n for n, line in enumerate(SOURCE.read_text().splitlines(), 1) if "ASSERT(" in line)
FAULTS = [
    (0, "segmentation fault in controllerOutOfTree"),
    pytest.param(1, "division by zero in controllerOutOfTree", marks=ONLY_WHERE_DIVISIONS_TRAP),
    (2, f"assertion 'kind < ASSERTION' failed in app_faults.c:{ASSERTION_LINE}"),
    (3, "abort in controllerOutOfTree"),
    (4, "segmentation fault in controllerOutOfTree"),
]


@pytest.fixture
def fly(host):
    control = host.ffi.new("control_t *")
    setpoint, sensors, state = (host.ffi.new(f"{kind} *") for kind in ("setpoint_t", "sensorData_t", "state_t"))

    def call(copy, drone):
        copy.controller(drone.block, control, setpoint, sensors, state, 0)
        return tuple(control.normalizedForces)

    return call


def flying(copy, mode):
    drone = copy.drone()
    copy.set(drone, "testApp.mode", mode)
    assert copy.controller_init(drone.block, OOT) == lib.CF_OK
    return drone


@pytest.mark.parametrize("kind, reason", FAULTS)
@pytest.mark.parametrize("in_one_go", [False, True])
def test_stops_the_drone_with_a_reason(app, fly, kind, reason, in_one_go):
    bad, good = flying(app, FAULT + kind), flying(app, COUNT)
    assert fly(app, good)[0] == 1
    before = bad.save(app.host.ffi)
    if in_one_go:
        app.begin(bad.block)
    fly(app, bad)
    assert app.host.reason == reason
    assert (app.host.failures, app.host.drone) == (1, bad.block)
    if in_one_go:
        app.end(bad.block)
    # nothing half done is kept
    assert bad.save(app.host.ffi) == before
    assert fly(app, good)[0] == 2
    assert app.host.failures == 1


def test_fails_again_and_again(app, fly):
    bad = flying(app, FAULT)
    for n in range(1, 6):
        fly(app, bad)
        assert app.host.failures == n


def test_functions_of_the_provider_work_for_a_drone_that_failed(app, fly):
    bad = flying(app, FAULT)
    app.begin(bad.block)
    fly(app, bad)
    app.kalman_init(bad.block, 5)
    assert app.kalman_is_within_bounds(bad.block)
    app.end(bad.block)
    assert app.host.failures == 1


def test_what_another_drone_did_before_its_end_survives_a_failure(app, fly):
    good, bad = flying(app, COUNT), flying(app, FAULT)
    app.begin(good.block)
    assert fly(app, good)[0] == 1
    fly(app, bad)
    assert fly(app, good)[0] == 2
    app.end(good.block)
    assert fly(app, good)[0] == 3


def test_answers_of_functions_that_fail_are_harmless(app, host):
    drone = flying(app, COUNT)
    null = host.ffi.NULL
    assert app.plan_takeoff(drone.block, null, 1.0, 0.0, 2.0, 0.0) == 1
    assert app.host.reason == "segmentation fault in plan_takeoff"
    assert not app.power_cap(drone.block, null, host.ffi.new("motors_thrust_pwm_t *"))
    assert app.host.reason == "segmentation fault in power_cap"
    app.kalman_update(drone.block, null, host.ffi.new("Axis3f *"), 10)
    assert app.host.reason == "segmentation fault in kalman_update"


def test_a_false_test_stops_the_drone(app):
    drone = app.drone()
    app.set(drone, "testApp.refuse", 1)
    assert app.controller_init(drone.block, OOT) == lib.CF_ERR_STATE
    assert app.host.reason == "controllerOutOfTreeTest returned false"
    assert app.controller_type(drone.block) == lib.ControllerTypePID
