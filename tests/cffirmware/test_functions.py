"""Calls: arguments, arrays, errors."""

import math

import numpy as np
import pytest


def controller_inputs(firm):
    return [firm.control_t(), firm.setpoint_t(), firm.sensorData_t(), firm.state_t()]


def test_wrong_count_is_a_type_error(firm):
    inputs = controller_inputs(firm)
    for arguments in ([], inputs, [*inputs, 1, 2]):
        with pytest.raises(TypeError):
            firm.controllerPid(*arguments)
    with pytest.raises(TypeError):
        firm.vzero(1)


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (0, None, "control must be control_t, not None"),
        (1, 1.0, "setpoint must be setpoint_t, not float"),
        (4, 1.0, "stabilizerStep must be int, not float"),
        (4, None, "stabilizerStep must be int, not None"),
    ],
)
def test_wrong_argument_is_named(firm, place, value, says):
    arguments = [*controller_inputs(firm), 100]
    arguments[place] = value
    with pytest.raises(TypeError, match=f"controllerPid\\(\\): {says}"):
        firm.controllerPid(*arguments)


def test_struct_of_another_kind_is_named(firm):
    control, setpoint, sensors, state = controller_inputs(firm)
    with pytest.raises(TypeError, match="setpoint must be setpoint_t, not state_t"):
        firm.controllerPid(control, state, sensors, setpoint, 100)
    with pytest.raises(TypeError, match="b must be vec, not mat33"):
        firm.vadd(firm.vzero(), firm.meye())


def test_number_that_is_none_is_named(firm):
    with pytest.raises(TypeError, match=r"radians\(\): degrees must be float, not str"):
        firm.radians("1")
    with pytest.raises(TypeError, match="y must be float, not None"):
        firm.mkvec(1, None, 3)


def test_structs_of_another_provider_are_refused(modules):
    builtin, bitcraze = modules["builtin"](), modules["bitcraze"]()
    with pytest.raises(TypeError):
        builtin.vneg(bitcraze.vzero())


def test_keywords_are_the_names_of_the_parameters(firm):
    assert list(firm.mkvec(z=3, x=1, y=2)) == [1, 2, 3]
    assert firm.clamp(value=5, min=0, max=1) == 1


def test_results_are_python_numbers(firm):
    assert type(firm.radians(180)) is float
    assert firm.radians(180) == float(np.float32(math.pi))
    assert firm.veq(firm.vzero(), firm.vzero()) is True
    assert firm.fcloseulps(1.0, 1.0 + 2**-23, 1) is True


def test_arrays_come_in_as_any_sequence(firm):
    for values in ([1, 2, 3], (1.0, 2.0, 3.0), np.array([1, 2, 3]), np.array([1, 2, 3], np.float32), range(1, 4)):
        assert list(firm.vloadf(values)) == [1, 2, 3]
        assert list(firm.vload(values)) == [1, 2, 3]
    strided = np.arange(6, dtype=np.float32)[::2]
    assert list(firm.vloadf(strided)) == [0, 2, 4]


def test_arrays_of_structs_are_arrays(firm):
    matrix = firm.mdiag(1, 2, 3)
    assert list(firm.vloadf(matrix.m[1])) == [0, 2, 0]
    firm.vstoref(firm.mkvec(7, 8, 9), matrix.m[2])
    assert list(firm.mrow(matrix, 2)) == [7, 8, 9]


def test_results_are_written_to_lists_and_arrays(firm):
    for target in ([0.0] * 3, np.zeros(3, np.float32), np.zeros(3), np.zeros(6)[::2], [0.0] * 5):
        firm.vstoref(firm.mkvec(1, 2, 3), target)
        assert list(target[:3]) == [1, 2, 3]
    doubles = np.zeros(4)
    firm.qstore(firm.mkquat(1, 2, 3, 4), doubles)
    assert doubles.tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("target", "error", "says"),
    [
        ((0, 0, 0), TypeError, "is written to"),
        ([0, 0], ValueError, "f has 2 numbers, 3 are needed"),
        ("abc", TypeError, "f must be a sequence of 3 numbers"),
        (3.0, TypeError, "f must be a sequence of 3 numbers"),
    ],
)
def test_target_that_cannot_be_written_is_refused(firm, target, error, says):
    with pytest.raises(error, match=says):
        firm.vstoref(firm.vzero(), target)


def test_read_only_array_is_not_written(firm):
    target = np.zeros(3, np.float32)
    target.flags.writeable = False
    with pytest.raises(TypeError, match="is written to"):
        firm.vstoref(firm.vzero(), target)


def test_polynomials(firm):
    p = [0.0] * 8
    firm.polylinear(p, 2.0, 1.0, 5.0)
    assert p == [1, 2, 0, 0, 0, 0, 0, 0]
    assert firm.polyval(p, 1.5) == 4.0
    firm.polyder(p)
    assert p == [2, 0, 0, 0, 0, 0, 0, 0]
    quintic = np.zeros(8, np.float32)
    firm.poly5(quintic, 1.0, 0, 0, 0, 1, 0, 0)
    assert quintic.tolist() == [0, 0, 0, 10, -15, 6, 0, 0]
    bezier = [0.0] * 8
    firm.polybezier(bezier, 1.0, [0, 1], 2)
    assert bezier[:2] == [0, 1]


def cube():
    """Return rows and bounds of the cube from -1 to 1."""
    rows = np.vstack([np.eye(3), -np.eye(3)])
    return rows, np.ones(6)


def test_convex_sets(firm):
    rows, bounds = cube()
    assert firm.vinpolytope(firm.mkvec(0.5, 0.5, 0.5), rows, bounds, 6, 0.0)
    assert not firm.vinpolytope(firm.mkvec(1.5, 0, 0), rows, bounds, 6, 0.0)
    hit = [0]
    distance = firm.rayintersectpolytope(firm.vzero(), firm.mkvec(0, -2, 0), rows, bounds, 6, hit)
    assert (distance, hit) == (0.5, [4])
    assert firm.rayintersectpolytope(firm.vzero(), firm.mkvec(0, -2, 0), rows, bounds, 6, None) == 0.5
    closest = firm.vprojectpolytope(firm.mkvec(3, 0.5, 0), rows, bounds, None, 6, 1e-6, 100)
    assert np.allclose(np.array(closest), [1, 0.5, 0], atol=1e-5)
    with pytest.raises(ValueError, match="A has 18 numbers, 21 are needed"):
        firm.vinpolytope(firm.vzero(), rows, np.ones(7), 7, 0.0)


def test_block_of_a_larger_matrix(firm):
    large = np.zeros((5, 5), np.float32)
    firm.set_block33_rowmaj(large, 5, firm.mdiag(1, 2, 3))
    assert np.array_equal(large[:3, :3], np.diag([1, 2, 3]))


def avoidance_inputs(firm):
    params, memory = firm.collision_avoidance_params_t(), firm.collision_avoidance_state_t()
    params.ellipsoidRadii = firm.mkvec(0.3, 0.3, 0.9)
    params.bboxMin, params.bboxMax = firm.vrepeat(-10), firm.vrepeat(10)
    params.horizonSecs, params.maxSpeed, params.sidestepThreshold = 1.0, 0.5, 0.25
    params.maxPeerLocAgeMillis = 5000
    params.voronoiProjectionTolerance, params.voronoiProjectionMaxIters = 1e-5, 100
    memory.lastFeasibleSetPosition = firm.vrepeat(math.nan)
    setpoint = firm.setpoint_t()
    setpoint.mode.x = setpoint.mode.y = setpoint.mode.z = firm.modeAbs
    setpoint.position.x = 2.0
    return params, memory, setpoint


def test_collision_avoidance_counts_floats_in_the_wrapper(firm):
    others = [1.0, 0.0, 0.0]
    params, memory, setpoint = avoidance_inputs(firm)
    firm.collisionAvoidanceUpdateSetpointWrap(params, memory, 3, others, setpoint, firm.sensorData_t(), firm.state_t())
    params, memory, direct = avoidance_inputs(firm)
    firm.collisionAvoidanceUpdateSetpointCore(
        params, memory, 1, others, None, direct, firm.sensorData_t(), firm.state_t()
    )
    # half of the way, less the ellipsoid
    assert setpoint.position.x == direct.position.x == pytest.approx(0.2, abs=1e-3)
    params, memory, alone = avoidance_inputs(firm)
    firm.collisionAvoidanceUpdateSetpointWrap(params, memory, 0, [], alone, firm.sensorData_t(), firm.state_t())
    assert alone.position.x == pytest.approx(0.5)


def test_conversions_of_vectors(firm):
    stabilizer = firm.svec2vec(firm.mkvec(1, 2, 3))
    assert isinstance(stabilizer, firm.vec3_s)
    assert (stabilizer.timestamp, stabilizer.x, stabilizer.y, stabilizer.z) == (0, 1, 2, 3)
    assert list(firm.vec2svec(stabilizer)) == [1, 2, 3]
    with pytest.raises(TypeError):
        firm.vec2svec(firm.mkvec(1, 2, 3))


def test_instances_remember_things_of_their_own(fresh):
    """One integrates, its twin does not."""
    twin = fresh.instance()
    assert twin.provider == fresh.provider

    def thrust(module, error):
        control, setpoint, sensors, state = controller_inputs(module)
        setpoint.mode.z = module.modeAbs
        setpoint.position.z = error
        for step in range(0, 1000, 10):
            module.controllerPid(control, setpoint, sensors, state, step)
        setpoint.position.z = 0
        module.controllerPid(control, setpoint, sensors, state, 0)
        return control.thrust

    for module in (fresh, twin):
        module.controllerPidInit()
    assert thrust(fresh, 1.0) > thrust(twin, 0.0) == 36000


def test_second_init_of_pid_leaves_attitude_loops_alone(fresh):
    def rolled(module, steps):
        control, setpoint, sensors, state = controller_inputs(module)
        setpoint.thrust, setpoint.attitude.roll = 30000, 5.0
        setpoint.mode.roll = setpoint.mode.pitch = module.modeAbs
        for step in range(0, steps, 2):
            module.controllerPid(control, setpoint, sensors, state, step)
        return control.roll

    fresh.controllerPidInit()
    integrated = rolled(fresh, 400)
    fresh.controllerPidInit()
    again = rolled(fresh, 2)
    other = fresh.instance()
    other.controllerPidInit()
    assert again >= integrated > rolled(other, 2)


def test_parts_say_that_they_are_ready(fresh):
    assert not fresh.controllerPidTest()
    for part in ("controllerPid", "controllerBrescianini", "powerDistribution"):
        getattr(fresh, f"{part}Init")()
        assert getattr(fresh, f"{part}Test")()
    motors = range(4)
    assert [fresh.powerDistributionMotorType(motor) for motor in motors] == [1, 1, 1, 1], "each drives a rotor"
    assert [fresh.powerDistributionStopRatio(motor) for motor in motors] == [0, 0, 0, 0]
