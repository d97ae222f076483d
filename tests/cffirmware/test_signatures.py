"""Old and new call forms, over old and new releases (docs/reference/cffirmware-api.md#8)."""

import gc

import numpy as np
import pytest


@pytest.fixture(params=["builtin", "bitcraze", "old"])
def any_firm(request, modules):
    return request.getfixturevalue("old_firm") if request.param == "old" else modules[request.param]()


def flying(firm):
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_takeoff(planner, firm.vzero(), 0, 1.0, 0, 2, 0)
    return planner


def goals(firm, planner, times=(2.0, 2.5, 3.0, 4.0)):
    """Return where the planner goes."""
    found = [firm.plan_current_goal(planner, t) for t in times]
    return [(*goal.pos, *goal.vel, goal.yaw) for goal in found]


def test_go_to_with_and_without_linear(any_firm):
    firm = any_firm
    new, old, named = flying(firm), flying(firm), flying(firm)
    goal = firm.mkvec(1, 0, 1)
    assert firm.plan_go_to(new, False, False, goal, 0.5, 2, 2) == 0
    assert firm.plan_go_to(old, False, goal, 0.5, 2, 2) == 0
    assert firm.plan_go_to(named, relative=False, hover_pos=goal, hover_yaw=0.5, duration=2, t=2) == 0
    assert goals(firm, new) == goals(firm, old) == goals(firm, named)
    assert goals(firm, new)[-1][0] == pytest.approx(1, abs=1e-6)


def test_go_to_from_with_and_without_linear(any_firm):
    firm = any_firm
    start = firm.traj_eval_zero()
    start.pos = firm.mkvec(0, 0, 1)
    new, old = flying(firm), flying(firm)
    firm.plan_go_to_from(new, start, False, False, firm.mkvec(1, 0, 1), 0.5, 2, 2)
    firm.plan_go_to_from(old, start, False, firm.mkvec(1, 0, 1), 0.5, 2, 2)
    assert goals(firm, new) == goals(firm, old)


def test_linear_flies_at_constant_speed(firm):
    planner = flying(firm)
    firm.plan_go_to(planner, False, True, firm.mkvec(1, 0, 1), 0.0, 2, 2)
    assert firm.plan_current_goal(planner, 2.5).vel.x == pytest.approx(0.5, abs=1e-5)


def test_what_a_release_cannot_do_is_refused(old_firm):
    firm = old_firm
    planner = flying(firm)
    with pytest.raises(TypeError, match="linear is unknown to this release"):
        firm.plan_go_to(planner, False, True, firm.mkvec(1, 0, 1), 0.0, 2, 2)
    with pytest.raises(TypeError, match="linear is unknown"):
        firm.plan_go_to_from(planner, firm.traj_eval_zero(), False, True, firm.vzero(), 0.0, 2, 2)
    with pytest.raises(TypeError, match="relative_yaw is unknown"):
        firm.plan_start_trajectory(planner, sideways(firm), False, True, True, firm.vzero(), 1.0)


def sideways(firm):
    trajectory = firm.piecewise_traj()
    trajectory.timescale = 1
    trajectory.n_pieces = 1
    trajectory.pieces = firm.poly4d_malloc(1)
    piece = firm.piecewise_get(trajectory, 0)
    piece.duration = 2
    firm.poly4d_set(piece, 0, 1, 1.0)
    return trajectory


def test_start_trajectory_with_and_without_yaw(any_firm):
    firm = any_firm
    ends = []
    for arguments in ((False, True, firm.mkvec(0, 3, 0)), (False, True, False, firm.mkvec(0, 3, 0), 1.0)):
        planner = flying(firm)
        assert firm.plan_start_trajectory(planner, sideways(firm), *arguments) == 0
        gc.collect(1)
        ends.append(goals(firm, planner, (0.0, 1.0)))
    assert ends[0] == ends[1]
    assert ends[0][1][:3] == (1, 3, 0)


def test_start_trajectory_turns_with_the_vehicle(firm):
    planner = flying(firm)
    firm.plan_start_trajectory(planner, sideways(firm), False, True, True, firm.vzero(), firm.M_PI_F / 2)
    goal = firm.plan_current_goal(planner, 1.0)
    assert np.allclose(np.array(goal.pos), [0, 1, 0], atol=1e-6)


def test_spirals(firm):
    planner = flying(firm)
    assert firm.plan_spiral(planner, False, False, firm.M_PI_F, 1.0, 1.0, 0.0, 4.0, 2.0) == 0
    other = flying(firm)
    start = firm.plan_current_goal(other, 2.0)
    assert firm.plan_spiral_from(other, start, False, False, firm.M_PI_F, 1.0, 1.0, 0.0, 4.0, 2.0) == 0
    assert goals(firm, planner, (2, 4, 6)) == goals(firm, other, (2, 4, 6))


@pytest.mark.parametrize("count", [0, 5, 8])
def test_wrong_count_names_the_allowed_ones(any_firm, count):
    with pytest.raises(TypeError, match=f"takes 6 or 7 arguments, {count} given"):
        any_firm.plan_go_to(*[0] * count)


def test_wrong_names_are_a_type_error(firm):
    with pytest.raises(TypeError, match="the last parameters are"):
        firm.plan_go_to(flying(firm), False, firm.vzero(), 0.0, duration=2, time=0)


def test_crazyswarm2_falls_back_only_where_it_must(any_firm):
    """Its own way to tell releases apart: the new form first, the old one after a TypeError."""
    firm = any_firm
    planner = flying(firm)
    try:
        firm.plan_go_to(planner, False, False, firm.mkvec(1, 0, 1), 0, 2, 2)
    except TypeError:
        firm.plan_go_to(planner, False, firm.mkvec(1, 0, 1), 0, 2, 2)
    assert goals(firm, planner)[-1][0] == pytest.approx(1, abs=1e-6)


def test_mellinger_without_self(firm):
    def run(*self):
        control, setpoint, sensors, state = firm.control_t(), firm.setpoint_t(), firm.sensorData_t(), firm.state_t()
        setpoint.mode.x = setpoint.mode.y = setpoint.mode.z = setpoint.mode.yaw = firm.modeAbs
        setpoint.position.x = 0.5
        state.attitudeQuaternion.w = 1
        firm.controllerMellinger(*self, control, setpoint, sensors, state, 0)
        return control.roll, control.pitch, control.yaw, control.thrust

    mellinger = firm.controllerMellinger_t()
    firm.controllerMellingerInit(mellinger)
    firm.controllerMellingerInit()
    assert firm.controllerMellingerTest() is True
    assert run(mellinger) == run()
    assert run() != (0, 0, 0, 0)


def test_cap_says_whether_also_where_c_does_not(old_firm):
    thrust, pwm = old_firm.motors_thrust_uncapped_t(), old_firm.motors_thrust_pwm_t()
    assert old_firm.powerDistributionCap(thrust, pwm) is False
    thrust.list = [0, 5, 1000, 65545]
    assert old_firm.powerDistributionCap(thrust, pwm) is True
    assert list(pwm.list) == [0, 0, 990, 65535]


def test_prediction_takes_both_forms_over_an_old_release(old_firm):
    firm = old_firm
    acc, gyro, params = firm.Axis3f(), firm.Axis3f(), firm.kalmanCoreParams_t()
    acc.z = 9.81
    firm.kalmanCoreDefaultParams(params)
    cores = [firm.kalmanCoreData_t(), firm.kalmanCoreData_t()]
    for core in cores:
        firm.kalmanCoreInit(core, params, 0)
    firm.kalmanCorePredict(cores[0], params, acc, gyro, 10, False)
    firm.kalmanCorePredict(cores[1], acc, gyro, 10, False)
    assert np.array_equal(cores[0].P, cores[1].P)
    assert cores[0].lastPredictionMs == cores[1].lastPredictionMs == 10
