"""Controllers, mixer and the mathematics below them with numbers that break things."""

import math

import pytest
from extremes import EXTREMES, FEW, many

from crazychoir_fw._core import ffi, lib

FLIGHTS, STEPS = 100, 40
PLATFORMS = [lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL]
CONTROLLERS = {
    "pid": ("cf_controller_pid_t", lib.cf_controller_pid_init, lib.cf_controller_pid_update),
    "mellinger": ("controllerMellinger_t", lib.cf_controller_mellinger_init, lib.controllerMellinger),
    "lee": ("controllerLee_t", lib.cf_controller_lee_init, lib.controllerLee),
    "brescianini": ("controllerBrescianini_t", lib.cf_controller_brescianini_boot, lib.controllerBrescianini),
}


def spoil(base, table, values):
    """Give every float of a group of parameters an extreme value."""
    for i in range(table.count):
        if table.rows[i].type == lib.CF_TYPE_FLOAT:
            ffi.cast("float *", ffi.cast("char *", base) + table.rows[i].offset)[0] = values[i % len(values)]


def spoil_gains(controller, name, values):
    """Write extreme numbers where a client may write gains."""
    if name == "pid":
        controller.attitude.yaw_max_delta, controller.position.roll_max = values[0], values[1]
    elif name == "mellinger":
        for i, gain in enumerate(("massThrust", "kR_xy", "kd_omega_rp", "i_range_xy", "i_range_m_z")):
            setattr(controller, gain, values[i])
    elif name == "lee":
        controller.mass, controller.Kpos_P_limit = values[0], values[1]
        controller.KR = controller.J = {"x": values[2], "y": values[3], "z": values[4]}
    else:
        spoil(controller, lib.cf_controller_brescianini_parameters(), values)


def duties(power, control):
    """Return the duties of four motors, whatever a controller wrote."""
    uncapped, pwm = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_pwm_t *")
    lib.cf_power_distribution_update(power, control, uncapped)
    lib.cf_power_distribution_cap(power, uncapped, pwm)
    return list(pwm.list)


@pytest.fixture(params=PLATFORMS, ids=["cf2", "cf21bl"])
def platform(request):
    return request.param


@pytest.fixture
def power(platform):
    power = ffi.new("cf_power_distribution_t *")
    assert lib.cf_power_distribution_init(power, platform) == lib.CF_OK
    return power


def flights(calm):
    """Yield gains and, step by step, the inputs of a controller."""
    count = FLIGHTS * STEPS
    setpoints, states = many("setpoint_t", count, 1, calm), many("state_t", count, 2, calm)
    sensors, gains = many("sensorData_t", count, 3, calm), many("float", 32 * FLIGHTS, 4, calm)
    for flight in range(FLIGHTS):
        steps = range(flight * STEPS, (flight + 1) * STEPS)
        yield (
            list(gains[32 * flight : 32 * flight + 32]),
            [(step % STEPS + 1, setpoints + step, sensors + step, states + step) for step in steps],
        )


@pytest.mark.parametrize("calm", [0.0, 0.75])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_controllers_stay_within_their_ranges(name, calm, platform, power):
    kind, init, update = CONTROLLERS[name]
    idle = lib.cf_power_distribution_idle_thrust(power)
    for flight, (gains, steps) in enumerate(flights(calm)):
        controller, control = ffi.new(f"{kind} *"), ffi.new("control_t *")
        assert init(controller, platform) == lib.CF_OK
        if flight % 3 == 1:
            spoil_gains(controller, name, gains)
        for step, setpoint, sensors, state in steps:
            update(controller, control, setpoint, sensors, state, step)
            if control.controlMode == lib.controlModeLegacy:
                limit = 32000 if name == "mellinger" and step % 2 == 0 else 32767
                assert min(control.roll, control.pitch, control.yaw) >= -limit
            else:
                assert control.controlMode == lib.controlModeForceTorque
            if name == "pid" and step % 2 == 0 and control.thrust != 0:
                yaw = controller.attitude_desired.yaw
                assert math.isnan(yaw) or abs(yaw) <= 180
            if name == "brescianini":
                assert setpoint.mode.z != lib.modeDisable or control.thrustSi == 0
                assert not control.thrustSi > 18 * controller.mass
            assert min(duties(power, control)) >= idle


def new_indi(platform=lib.CF_PLATFORM_CF2):
    indi, pid = ffi.new("controllerINDI_t *"), ffi.new("cf_controller_pid_t *")
    lib.cf_controller_indi_boot(indi)
    assert lib.cf_controller_pid_init(pid, platform) == lib.CF_OK
    return indi, pid


def test_indi_stays_within_its_ranges(platform, power):
    idle = lib.cf_power_distribution_idle_thrust(power)
    for flight, (gains, steps) in enumerate(flights(0.0)):
        (indi, pid), control = new_indi(platform), ffi.new("control_t *")
        if flight % 3 == 1:
            spoil(indi, lib.cf_controller_indi_parameters(), gains)
            spoil(ffi.addressof(indi.position), lib.cf_position_controller_indi_parameters(), gains)
        indi.outerLoopActive = 0 if flight % 4 == 3 else 255
        lib.controllerINDIInit(indi, pid)
        for step, setpoint, sensors, state in steps:
            lib.controllerINDI(indi, pid, control, setpoint, sensors, state, step)
            assert control.controlMode == lib.controlModeLegacy
            assert min(control.roll, control.pitch, control.yaw) >= -32767
            assert min(duties(power, control)) >= idle


@pytest.mark.parametrize("yaw", EXTREMES)
def test_indi_wraps_yaw_angles_of_every_size(yaw):
    indi, pid = new_indi()
    lib.controllerINDIInit(indi, pid)
    setpoint = ffi.new("setpoint_t *", {"attitude": {"yaw": yaw}, "thrust": 30000})
    empty = [ffi.new(f"{kind} *") for kind in ("control_t", "sensorData_t", "state_t")]
    lib.controllerINDI(indi, pid, empty[0], setpoint, *empty[1:], 2)
    wrapped = indi.attitudeDesired.yaw
    assert abs(wrapped) <= math.pi + 1e-6 if math.isfinite(yaw) else math.isnan(wrapped)


NAN_STATES = {
    "pid": {"position": {"x": math.nan, "z": math.nan}, "attitude": {"roll": math.nan, "yaw": math.nan}},
    "lee": {"attitudeQuaternion": {"x": math.nan, "w": 1}},
    "brescianini": {"position": {"x": math.nan}, "attitudeQuaternion": {"w": 1}},
    "indi": {"attitude": {"roll": math.nan, "pitch": math.nan, "yaw": math.nan}},
}


@pytest.mark.parametrize("name", NAN_STATES)
def test_a_poisoned_controller_recovers(name):
    """At zero thrust, or at its next step; INDI when it is initialized."""
    control, sensors = ffi.new("control_t *"), ffi.new("sensorData_t *", {"acc": {"z": 1}})
    hover = ffi.new("setpoint_t *", {"mode": dict.fromkeys("xyz", lib.modeAbs), "thrust": 30000 * (name == "indi")})
    hover.mode.yaw = lib.modeAbs if name == "pid" else lib.modeDisable
    null, good = ffi.new("setpoint_t *"), ffi.new("state_t *", {"attitudeQuaternion": {"w": 1}})
    if name == "indi":
        hover.mode.z = lib.modeDisable
        indi, pid = new_indi()
        lib.controllerINDIInit(indi, pid)

        def update(setpoint, state, step):
            lib.controllerINDI(indi, pid, control, setpoint, sensors, state, step)

    else:
        kind, init, function = CONTROLLERS[name]
        controller = ffi.new(f"{kind} *")
        assert init(controller, lib.CF_PLATFORM_CF2) == lib.CF_OK

        def update(setpoint, state, step):
            function(controller, control, setpoint, sensors, state, step)

    update(hover, ffi.new("state_t *", NAN_STATES[name]), 10)
    if name in ("lee", "brescianini"):
        assert math.isnan(control.thrustSi) or math.isnan(control.torqueX)
    else:
        assert (control.roll, control.pitch, control.yaw) == (0, 0, 0)
    if name == "indi":
        lib.controllerINDIInit(indi, pid)
    else:
        update(null, good, 12)
    update(hover, good, 20)
    if name == "indi":
        assert math.isfinite(indi.indi.u_in.p) and math.isfinite(indi.indi.u_in.q)
    elif name in ("lee", "brescianini"):
        assert control.thrustSi > 0
        assert all(map(math.isfinite, [control.thrustSi, control.torqueX, control.torqueY, control.torqueZ]))
    else:
        assert (control.thrust, control.roll, control.pitch, control.yaw) == (36000, 0, 0, 0)


def test_mixer_in_every_mode():
    power, controls = ffi.new("cf_power_distribution_t *"), many("control_t", 5000, 9)
    assert lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF21BL) == lib.CF_OK
    forces = many("float", 20000, 10)
    for i in range(5000):
        control = ffi.new("control_t *", {"controlMode": i % 4})
        control.normalizedForces = list(forces[4 * i : 4 * i + 4])
        uncapped = ffi.new("motors_thrust_uncapped_t *", {"list": [-1] * 4})
        lib.cf_power_distribution_update(power, control, uncapped)
        if control.controlMode == lib.controlModeForceTorque:
            assert min(uncapped.list) >= 0
        elif control.controlMode in (lib.controlModeForce, lib.controlModePWM):
            assert 0 <= min(uncapped.list) <= max(uncapped.list) <= 65535
        duties(power, controls + i)
    for mode in (4, 200):
        control = ffi.new("control_t *", {"controlMode": mode})
        lib.cf_power_distribution_update(power, control, uncapped)
    uncapped.list = [-1] * 4
    lib.cf_power_distribution_update(power, control, uncapped)
    assert list(uncapped.list) == [-1] * 4


@pytest.mark.parametrize("voltage", FEW)
def test_battery_compensation_and_motor_override(voltage):
    curve = ffi.addressof(lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust)
    for thrust in EXTREMES:
        assert not lib.cf_battery_compensate(curve, thrust, voltage) < 0
        override, pwm = ffi.new("cf_motor_override_t *"), ffi.new("motors_thrust_pwm_t *")
        lib.cf_motor_override_init(override)
        override.enable, override.motor[0] = 3, 65535
        lib.cf_motor_override_apply(override, curve, voltage, pwm)
        assert pwm.list[0] == pwm.list[3]
    power = ffi.new("cf_power_distribution_t *")
    lib.cf_power_distribution_init(power, lib.CF_PLATFORM_CF21BL)
    uncapped, compensated = ffi.new("motors_thrust_uncapped_t *"), ffi.new("motors_thrust_uncapped_t *")
    pwm = ffi.new("motors_thrust_pwm_t *")
    uncapped.list = [2147483647, -2147483648, 65536, 0]
    lib.cf_power_distribution_compensate(power, uncapped, voltage, compensated)
    lib.cf_power_distribution_cap(power, compensated, pwm)
    assert min(pwm.list) >= lib.cf_power_distribution_idle_thrust(power)


@pytest.mark.parametrize("number", EXTREMES)
def test_pid_and_filters(number):
    for other in EXTREMES:
        pid = ffi.new("PidObject *")
        lib.pidInit(pid, number, 1, 1, 1, 1, 0.01, 100, 20, number > 0)
        pid.outputLimit = 10
        assert not abs(lib.pidUpdate(pid, other, number < 0)) > 10
        assert not math.isnan(pid.deriv)

    lpf = ffi.new("lpf2pData *")
    lib.lpf2pInit(lpf, 100, number)
    lib.lpf2pInit(lpf, number, 20)
    lib.lpf2pInit(lpf, 100, 20)
    lib.lpf2pReset(lpf, number)
    lib.lpf2pApply(lpf, number)
    output = [lib.lpf2pApply(lpf, 1) for _ in range(200)][-1]
    assert abs(output - 1) < 1e-3 or not abs(number) < 1e20  # whatever came in, the filter settles again
    butterworth = ffi.new("Butterworth2LowPass *")
    lib.init_butterworth_2_low_pass(butterworth, number, 0.002, number)
    lib.update_butterworth_2_low_pass(butterworth, number)


def test_integer_filter_at_its_borders():
    borders = [-(2**31), -(2**31) + 1, -65536, -1, 0, 1, 65535, 2**31 - 1]
    for number in borders:
        for share in borders:
            for start in borders:
                lib.iirLPFilterSingle(number, share, ffi.new("int32_t *", start))
    # a full share takes the input over at once
    state = ffi.new("int32_t *")
    assert lib.iirLPFilterSingle(-1234, 256, state) == -1234
    assert lib.iirLPFilterSingle(1234, 2**31 - 1, state) == 1234


def test_mathematics():
    v, q, t = (
        many(kind, 4000, seed, calm=0.75) for kind, seed in (("struct vec", 1), ("struct quat", 2), ("float", 3))
    )
    for i in range(0, 4000, 2):
        a, b, p, r, s = v[i], v[i + 1], q[i], q[i + 1], t[i]
        lib.qvrot(lib.qqmul(p, lib.qnormalize(r)), lib.vnormalize(a))
        lib.qslerp(p, r, s)
        lib.qnlerp(p, r, s)
        lib.quat2angle(p)
        lib.qanglebetween(p, r)
        lib.quat2rpy(lib.mat2quat(lib.quat2rotmat(p)))
        lib.rpy2quat(a)
        lib.rpy2quat_small(a)
        lib.qaxisangle(a, s)
        lib.qvectovec(a, lib.quat2axis(p))
        lib.maxisangle(b, s)
        lib.vclampnorm(a, s)
        assert not abs(lib.clamp(s, -1, 1)) > 1
        assert lib.fcloseulps(s, s, 0)
    # the two zeros are as many floats apart as an int32 cannot count
    assert not lib.fcloseulps(-0.0, 0.0, 2**31 - 1)


def test_polytopes():
    points, numbers = many("struct vec", 4000, 4, calm=0.75), many("float", 40000, 5, calm=0.75)
    rows, limits, work, row = (ffi.new(kind) for kind in ("float[12]", "float[4]", "float[12]", "int *"))
    for i in range(0, 4000, 2):
        rows[0:12], limits[0:4] = list(numbers[10 * i : 10 * i + 12]), list(numbers[10 * i + 12 : 10 * i + 16])
        lib.rayintersectpolytope(points[i], points[i + 1], rows, limits, 4, row)
        assert -1 <= row[0] < 4
        lib.vprojectpolytope(points[i], rows, limits, work, 4, numbers[10 * i + 16], 100)
    for number in EXTREMES:
        point = {"x": number, "y": number, "z": number}
        assert lib.vinpolytope(point, rows, limits, 0, number)
        assert math.isinf(lib.rayintersectpolytope(point, point, rows, limits, 0, ffi.NULL))
        same = lib.vprojectpolytope(point, rows, limits, work, 0, 1e-5, 100)
        assert same.x == number or math.isnan(number)
