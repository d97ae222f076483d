"""The builtin provider in a library is the builtin provider of the core, to the bit."""

import random

import pytest

from crazychoir_fw._core import lib

TICKS = 1500
CONTROLLERS = [
    lib.ControllerTypePID,
    lib.ControllerTypeMellinger,
    lib.ControllerTypeINDI,
    lib.ControllerTypeBrescianini,
    lib.ControllerTypeLee,
]


class Onboard:
    """A rough loop around a provider, which takes every function along; everything it says is written down."""

    def __init__(self, ffi, provider, block):
        self.ffi, self.provider, self.block = ffi, provider, block
        self.said = []
        self.new = {
            name: ffi.new(f"{kind} *")
            for name, kind in {
                "acc": "Axis3f",
                "gyro": "Axis3f",
                "measurement": "measurement_t",
                "sensors": "sensorData_t",
                "estimate": "state_t",
                "complementary": "state_t",
                "latest": "cf_latest_samples_t",
                "setpoint": "setpoint_t",
                "control": "control_t",
                "uncapped": "motors_thrust_uncapped_t",
                "compensated": "motors_thrust_uncapped_t",
                "pwm": "motors_thrust_pwm_t",
                "start": "cf_plan_start_t",
                "spiral": "cf_spiral_t",
            }.items()
        }
        self.memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
        self.peers = ffi.new("cf_peer_t[]", lib.PEER_LOCALIZATION_MAX_NEIGHBORS)
        self.peers[0] = {"id": 3, "pos": {"x": 0.4, "y": 0.1, "z": 0.8}}

    def say(self, *answers):
        for answer in answers:
            is_data = isinstance(answer, self.ffi.CData)
            self.said.append(bytes(self.ffi.buffer(self.ffi.addressof(answer))) if is_data else answer)

    def sense(self, random_numbers):
        n = self.new
        for name in ("acc", "gyro"):
            for axis in "xyz":
                setattr(n[name], axis, random_numbers.gauss(0.0, 0.1) + (name == "acc" and axis == "z"))
        n["sensors"].acc, n["sensors"].gyro = n["acc"][0], n["gyro"][0]
        n["latest"].acc, n["latest"].gyro = n["acc"][0], n["gyro"][0]
        n["latest"].baro.asl = random_numbers.gauss(100.0, 0.1)
        position = n["measurement"].data.position
        n["measurement"].type = lib.MeasurementTypePosition
        position.x, position.y, position.z = (random_numbers.gauss(0.0, 0.01) for _ in range(3))
        position.stdDev = 0.01

    def estimate(self, now):
        p, n = self.provider, self.new
        if now % 10 == 0:
            p.kalman_predict(self.block, n["acc"], n["gyro"], now, now > 200)
            p.kalman_update(self.block, n["measurement"], n["gyro"], now)
        p.kalman_add_process_noise(self.block, now)
        self.say(p.kalman_finalize(self.block), p.kalman_is_within_bounds(self.block))
        p.kalman_externalize(self.block, n["estimate"], n["acc"])
        p.complementary(self.block, n["latest"], n["complementary"], now, now)
        self.say(n["estimate"][0], n["complementary"][0])

    def command(self, now):
        p, n, t = self.provider, self.new, now / 1000
        if now == 100:
            self.say(p.plan_takeoff(self.block, n["start"], 1.0, 0.5, 0.4, t))
        if now == 600:
            goal = {"x": 0.5, "y": -0.5, "z": 1.2}
            self.say(p.plan_go_to(self.block, self.memory, n["start"], False, False, goal, 0.0, 0.3, t))
        if now == 1000:
            n["spiral"][0] = {"angle": 3.0, "radius0": 0.5, "radiusF": 0.3, "duration": 0.4}
            self.say(p.plan_spiral(self.block, n["start"], n["spiral"], t))
        if now == 1300:
            self.say(p.plan_land(self.block, n["start"], 0.0, 0.0, 0.2, t))
        if now % 10 == 0:
            goal = p.plan_current_goal(self.block, self.memory, t)
            self.say(goal, p.plan_is_finished(self.block, self.memory, t), p.plan_state(self.block))
            if now > 100:
                self.follow(goal)

    def follow(self, goal):
        setpoint = self.new["setpoint"]
        for axis in "xyz":
            setattr(setpoint.position, axis, getattr(goal.pos, axis))
            setattr(setpoint.velocity, axis, getattr(goal.vel, axis))
            setattr(setpoint.mode, axis, lib.modeAbs)
        setpoint.attitude.yaw, setpoint.mode.yaw = goal.yaw, lib.modeAbs

    def control(self, now):
        p, n = self.provider, self.new
        if now % 100 == 0 and p.collision_avoidance_is_enabled(self.block):
            p.collision_avoidance(self.block, n["setpoint"], self.peers, n["sensors"], n["estimate"], now)
        p.controller(self.block, n["control"], n["setpoint"], n["sensors"], n["estimate"], now)
        p.power_distribution(self.block, n["control"], n["uncapped"])
        p.battery_compensate(self.block, n["uncapped"], 4.0, n["compensated"])
        self.say(p.power_cap(self.block, n["compensated"], n["pwm"]))
        p.motor_override(self.block, 4.0, n["pwm"])
        self.say(n["setpoint"][0], n["control"][0], n["pwm"][0], p.idle_thrust(self.block))

    def run(self, ticks, in_one_go):
        random_numbers = random.Random(4)
        for now in range(1, ticks + 1):
            self.sense(random_numbers)
            if in_one_go:
                self.provider.begin(self.block)
            self.estimate(now)
            self.command(now)
            self.control(now)
            if in_one_go:
                self.provider.end(self.block)
        return self.said


@pytest.fixture(scope="module")
def reference(host):
    """What the core's own provider says, per platform and controller."""
    known = {}

    def said(platform, controller):
        if (platform, controller) not in known:
            provider = host.builtin
            memory = host.ffi.new("uint64_t[]", provider.state_bytes // 8 + 1)
            block = host.ffi.cast("char *", memory)
            assert provider.init(block, platform, 0) == lib.CF_OK
            assert provider.controller_init(block, controller) == lib.CF_OK
            provider.kalman_init(block, 0)
            provider.complementary_init(block)
            enable_collision_avoidance(host, provider, block)
            known[platform, controller] = Onboard(host.ffi, provider, block).run(TICKS, in_one_go=False)
        return known[platform, controller]

    return said


def enable_collision_avoidance(host, provider, block):
    tables = host.ffi.new("cf_variables_t[]", lib.CF_PROVIDER_MAX_TABLES)
    for table in tables[0 : provider.parameters(tables, len(tables))]:
        for row in table.rows[0 : table.count]:
            if host.ffi.string(row.group) == b"colAv" and host.ffi.string(row.name) == b"enable":
                host.ffi.cast("uint8_t *", block + table.base + row.offset)[0] = 1
                return
    raise AssertionError("no parameter colAv.enable")


def boot(copy, platform, controller):
    drone = copy.drone(platform)
    assert copy.controller_init(drone.block, controller) == lib.CF_OK
    copy.kalman_init(drone.block, 0)
    copy.complementary_init(drone.block)
    enable_collision_avoidance(copy.host, copy.provider, drone.block)
    return drone


@pytest.mark.parametrize("in_one_go", [True, False])
def test_same_bits(open_library, plain_library, host, reference, in_one_go):
    copy = open_library(plain_library)
    drone = boot(copy, lib.CF_PLATFORM_CF2, lib.ControllerTypePID)
    said = Onboard(host.ffi, copy.provider, drone.block).run(TICKS, in_one_go)
    assert said == reference(lib.CF_PLATFORM_CF2, lib.ControllerTypePID)
    assert len({word for word in said if isinstance(word, bytes)}) > TICKS


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_an_app_that_forwards_to_a_controller_is_that_controller(app, host, reference, controller):
    drone = app.drone(lib.CF_PLATFORM_CF21BL)
    app.set(drone, "testApp.mode", controller)
    assert app.controller_init(drone.block, lib.ControllerTypeOot) == lib.CF_OK
    app.kalman_init(drone.block, 0)
    app.complementary_init(drone.block)
    enable_collision_avoidance(host, app.provider, drone.block)
    said = Onboard(host.ffi, app.provider, drone.block).run(TICKS, in_one_go=True)
    assert said == reference(lib.CF_PLATFORM_CF21BL, controller)
    assert host.failures == 0


def test_controllers_are_named_and_numbered_as_in_the_firmware(app, open_library, plain_library, host):
    plain = open_library(plain_library)
    names = [host.builtin.controller_name(number) for number in range(lib.ControllerType_COUNT)]
    text = lambda pointer: None if pointer == host.ffi.NULL else host.ffi.string(pointer).decode()
    assert [text(plain.controller_name(number)) for number in range(lib.ControllerType_COUNT)] == list(map(text, names))
    assert text(app.controller_name(lib.ControllerTypeOot)) == "OutOfTree"
    assert text(app.controller_name(lib.ControllerTypePID)) == "PID"


def test_controllers_are_selected(app):
    drone = app.drone()
    assert app.controller_type(drone.block) == lib.ControllerTypePID
    assert app.controller_init(drone.block, lib.ControllerTypeOot) == lib.CF_OK
    assert app.controller_type(drone.block) == lib.ControllerTypeOot
    assert app.controller_init(drone.block, 99) == lib.CF_ERR_UNKNOWN
    assert app.controller_type(drone.block) == lib.ControllerTypeOot
    assert app.controller_init(drone.block, lib.ControllerTypeLee) == lib.CF_OK
    assert app.controller_type(drone.block) == lib.ControllerTypeLee
    assert app.controller_init(drone.block, lib.ControllerTypeAutoSelect) == lib.CF_OK
    assert app.controller_type(drone.block) == lib.ControllerTypePID


def test_without_an_app_there_is_nothing_out_of_tree(open_library, plain_library, host):
    copy = open_library(plain_library)
    drone = copy.drone()
    assert copy.controller_init(drone.block, lib.ControllerTypeOot) == lib.CF_ERR_UNKNOWN
    assert copy.out_of_tree_estimator == host.ffi.NULL
    assert copy.out_of_tree_estimator_init == host.ffi.NULL


def test_an_unknown_platform_is_refused(app):
    drone = app.drone()
    assert app.init(drone.block, 77, 0) == lib.CF_ERR_UNKNOWN
    assert app.host.failures == 0


def test_an_estimator_takes_what_is_in_the_queue(app, host):
    drone, other = app.drone(), app.drone()
    queue = host.ffi.new("measurement_t[]", 3)
    queue[0].type = lib.MeasurementTypeGyroscope
    queue[1].type, queue[1].data.height.height = lib.MeasurementTypeAbsoluteHeight, 1.25
    queue[2].type = lib.MeasurementTypeBarometer
    estimate = host.ffi.new("state_t *")
    for each in (drone, other):
        app.out_of_tree_estimator_init(each.block)
    app.out_of_tree_estimator(drone.block, queue, 3, estimate, 42, 42)
    assert (estimate.position.z, estimate.position.timestamp) == (1.25, 42)
    app.out_of_tree_estimator(drone.block, queue, 0, estimate, 43, 43)
    app.out_of_tree_estimator(other.block, queue, 1, estimate, 43, 43)
    assert app.get(drone, "logs", "testEstimator.taken") == 3
    assert app.get(other, "logs", "testEstimator.taken") == 1
    assert host.failures == 0


def test_an_estimator_that_crashes_stops_the_drone(app, host):
    drone = app.drone()
    estimate = host.ffi.new("state_t *")
    app.out_of_tree_estimator(drone.block, host.ffi.cast("measurement_t *", 8), 1, estimate, 1, 1)
    assert host.reason == "segmentation fault in estimatorOutOfTree"


def test_an_estimator_that_forwards_to_the_complementary_one_is_that(app, host):
    drone = app.drone()
    app.set(drone, "testEstimator.forward", 1)
    app.out_of_tree_estimator_init(drone.block)
    queue = host.ffi.new("measurement_t[]", 4)
    latest = host.ffi.new("cf_latest_samples_t *")
    expected, estimate = host.ffi.new("state_t *"), host.ffi.new("state_t *")
    memory = host.ffi.new("uint64_t[]", host.builtin.state_bytes // 8 + 1)
    builtin, block = host.builtin, host.ffi.cast("char *", memory)
    assert builtin.init(block, lib.CF_PLATFORM_CF2, 0) == lib.CF_OK
    builtin.complementary_init(block)
    random_numbers = random.Random(8)
    for now in range(1, 400):
        latest.acc = {"x": random_numbers.gauss(0, 0.1), "y": 0.0, "z": 1.0}
        latest.gyro = {"x": random_numbers.gauss(0, 1.0), "y": 0.0, "z": 1.0}
        latest.baro.asl = random_numbers.gauss(50, 0.1)
        queue[0].type, queue[0].data.gyroscope.gyro = lib.MeasurementTypeGyroscope, latest.gyro
        queue[1].type, queue[1].data.acceleration.acc = lib.MeasurementTypeAcceleration, latest.acc
        queue[2].type, queue[2].data.barometer.baro = lib.MeasurementTypeBarometer, latest.baro
        queue[3].type = lib.MeasurementTypeFlow
        app.out_of_tree_estimator(drone.block, queue, 4, estimate, now, now)
        builtin.complementary(block, latest, expected, now, now)
        assert bytes(host.ffi.buffer(estimate)) == bytes(host.ffi.buffer(expected))
    assert estimate.attitude.roll != 0.0 and estimate.acc.z != 0.0


def test_loops_mixer_and_airframe_by_their_names(app, host):
    control, state = host.ffi.new("control_t *"), host.ffi.new("state_t *")
    setpoint, sensors = host.ffi.new("setpoint_t *"), host.ffi.new("sensorData_t *")
    setpoint.mode.z, setpoint.position.z = lib.modeAbs, 0.1
    for platform in (lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL):
        drone = app.drone(platform)
        app.set(drone, "testApp.mode", 13)
        assert app.controller_init(drone.block, lib.ControllerTypeOot) == lib.CF_OK
        app.controller(drone.block, control, setpoint, sensors, state, 0)
        get = lambda name, drone=drone: app.get(drone, "parameters", name)
        rates = {
            axis: int(n * (get(f"pid_rate.{axis}_kp") + 0.002 * get(f"pid_rate.{axis}_ki")))
            for n, axis in enumerate(("roll", "pitch", "yaw"), 1)
        }
        idle = get("powerDist.idleThrust")
        m4 = 1000 + int(rates["roll"] / 2) + int(rates["pitch"] / 2) - rates["yaw"]
        facts = lib.cf_platform_facts(platform)
        # 0.1 m above, by both vertical loops
        climb = 0.1 * get("posCtlPid.zKp") + 0.1 * 0.01 * get("posCtlPid.zKi")
        thrust = 1000 * climb * (get("velCtlPid.vzKp") + 0.01 * get("velCtlPid.vzKi")) + get("posCtlPid.thrustBase")
        assert tuple(control.normalizedForces) == pytest.approx(
            (
                max(m4, idle),
                get("pid_attitude.roll_kp") + 0.002 * get("pid_attitude.roll_ki"),
                thrust,
                facts.mass + 4 * facts.thrust.thrust_max,
            ),
            rel=1e-6,
        )
