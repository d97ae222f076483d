"""Programs in the manner of those who use upstream's module (docs/reference/cffirmware-api.md#9).

They are written for these tests; only which functions they call, and how, is theirs.
"""

import math

import numpy as np
import pytest

G = 9.81


class PointMass:
    """A vehicle that tilts at once: enough to see that loops close."""

    def __init__(self, mass):
        self.mass = mass
        self.position, self.velocity = np.zeros(3), np.zeros(3)

    def step(self, force, dt):
        self.velocity += (np.asarray(force) / self.mass - [0, 0, G]) * dt
        self.position += self.velocity * dt
        if self.position[2] < 0:
            self.position[2], self.velocity[2] = 0, 0


def estimate(firm, body):
    state = firm.state_t()
    state.position.x, state.position.y, state.position.z = body.position
    state.velocity.x, state.velocity.y, state.velocity.z = body.velocity
    state.attitudeQuaternion.w = 1
    return state


def force_of(pwm):
    """Return newtons of one rotor by the curve that Crazyswarm2 has."""
    grams = 1.71479058e-9 * pwm**2 + 8.80284482e-5 * pwm - 0.221152097
    return max(0.0, grams * G / 1000)


class SoftwareInTheLoop:
    """One Crazyflie of a server like that of Crazyswarm2 (9.1)."""

    def __init__(self, firm, controller):
        self.firm, self.controller = firm, controller
        self.planner = firm.planner()
        firm.plan_init(self.planner)
        self.sensors, self.setpoint, self.control = firm.sensorData_t(), firm.setpoint_t(), firm.control_t()
        self.uncapped, self.pwm = firm.motors_thrust_uncapped_t(), firm.motors_thrust_pwm_t()
        self.mellinger = firm.controllerMellinger_t()
        {
            "pid": firm.controllerPidInit,
            "mellinger": lambda: firm.controllerMellingerInit(self.mellinger),
            "brescianini": firm.controllerBrescianiniInit,
        }[controller]()

    def go_to(self, goal, yaw, duration, relative, t):
        firm = self.firm
        try:
            firm.plan_go_to(self.planner, relative, False, firm.mkvec(*goal), yaw, duration, t)
        except TypeError:
            firm.plan_go_to(self.planner, relative, firm.mkvec(*goal), yaw, duration, t)

    def upload(self, pieces):
        firm = self.firm
        trajectory = firm.piecewise_traj()
        trajectory.t_begin, trajectory.timescale = 0, 1
        trajectory.shift = firm.mkvec(0, 0, 0)
        trajectory.n_pieces = len(pieces)
        trajectory.pieces = firm.poly4d_malloc(len(pieces))
        for i, (duration, coefficients) in enumerate(pieces):
            piece = firm.piecewise_get(trajectory, i)
            piece.duration = duration
            for dim in range(4):
                for power in range(8):
                    firm.poly4d_set(piece, dim, power, coefficients[dim][power])
        return trajectory

    def ask_planner(self, t):
        firm, setpoint = self.firm, self.setpoint
        goal = firm.plan_current_goal(self.planner, t)
        if not firm.is_traj_eval_valid(goal):
            return False
        for member, value in (("position", goal.pos), ("velocity", goal.vel), ("acceleration", goal.acc)):
            target = getattr(setpoint, member)
            target.x, target.y, target.z = value.x, value.y, value.z
        setpoint.attitude.yaw = math.degrees(goal.yaw)
        setpoint.attitudeRate.roll = math.degrees(goal.omega.x)
        setpoint.attitudeRate.pitch = math.degrees(goal.omega.y)
        setpoint.attitudeRate.yaw = math.degrees(goal.omega.z)
        for axis in ("x", "y", "z", "yaw"):
            setattr(setpoint.mode, axis, firm.modeAbs)
        for axis in ("roll", "pitch", "quat"):
            setattr(setpoint.mode, axis, firm.modeDisable)
        return True

    def motors(self, state, t):
        firm, step = self.firm, int(t * 1000)
        inputs = (self.control, self.setpoint, self.sensors, state, step)
        match self.controller:
            case "pid":
                firm.controllerPid(*inputs)
            case "mellinger":
                firm.controllerMellinger(self.mellinger, *inputs)
            case "brescianini":
                firm.controllerBrescianini(*inputs)
        firm.powerDistribution(self.control, self.uncapped)
        firm.powerDistributionCap(self.uncapped, self.pwm)
        motors = self.pwm.motors
        return motors.m1, motors.m2, motors.m3, motors.m4


@pytest.mark.parametrize("controller", ["pid", "mellinger", "brescianini"])
def test_crazyswarm2_takes_off(fresh, controller):
    drone, body = SoftwareInTheLoop(fresh, controller), PointMass(0.029)
    fresh.plan_takeoff(drone.planner, fresh.vzero(), 0.0, 0.5, 0.0, 2.0, 0.0)
    for i in range(3000):
        t = i / 1000
        if i % 10 == 0:
            assert drone.ask_planner(t)
        lift = sum(map(force_of, drone.motors(estimate(fresh, body), t)))
        body.step((0, 0, lift), 0.001)
    assert body.position[2] == pytest.approx(0.5, abs=0.15)


def test_crazyswarm2_uploads_a_trajectory(fresh):
    drone = SoftwareInTheLoop(fresh, "mellinger")
    ramp, stay, zero = [0, 1] + [0] * 6, [2] + [0] * 7, [0] * 8
    trajectory = drone.upload([(2.0, (ramp, zero, zero, zero)), (1.0, (stay, zero, zero, zero))])
    assert fresh.piecewise_duration(trajectory) == 3
    trajectory.timescale = 2
    assert fresh.plan_start_trajectory(drone.planner, trajectory, False, True, fresh.mkvec(0, 0, 1)) == 0
    assert drone.ask_planner(2.0)
    assert (drone.setpoint.position.x, drone.setpoint.position.z, drone.setpoint.velocity.x) == (1.0, 1.0, 0.5)
    fresh.plan_start_trajectory(drone.planner, trajectory, True, False, fresh.vzero())
    assert drone.ask_planner(0.0)
    assert drone.setpoint.position.x == 2.0


def test_crazyswarm2_goes_and_lands(fresh):
    drone = SoftwareInTheLoop(fresh, "pid")
    fresh.plan_takeoff(drone.planner, fresh.vzero(), 0.0, 1.0, 0.0, 1.0, 0.0)
    drone.go_to((1, 1, 1), math.pi / 2, 2.0, False, 1.0)
    assert drone.ask_planner(3.0)
    assert drone.setpoint.attitude.yaw == pytest.approx(90, abs=1e-4)
    goal = fresh.plan_current_goal(drone.planner, 3.0)
    assert fresh.plan_land(drone.planner, goal.pos, goal.yaw, 0.05, 0.0, 2.0, 3.0) == 0
    assert drone.ask_planner(4.0)
    assert drone.ask_planner(5.5)  # the call that finds the landing ended still has a goal
    assert not drone.ask_planner(5.6)
    assert fresh.plan_is_stopped(drone.planner)


class WebotsPlugin:
    """A plugin like CrazyChoir's (9.2): constant step 100, motors mixed in Python."""

    def __init__(self, firm):
        self.firm = firm
        self.setpoint = firm.setpoint_t()
        firm.controllerPidInit()

    def sense(self, roll, pitch, yaw, position, rates):
        firm = self.firm
        state, sensors = firm.state_t(), firm.sensorData_t()
        state.attitude.roll = math.degrees(roll)
        state.attitude.pitch = -math.degrees(pitch)
        state.attitude.yaw = math.degrees(yaw)
        state.position.x, state.position.y, state.position.z = position
        sensors.gyro.x, sensors.gyro.y, sensors.gyro.z = (math.degrees(rate) for rate in rates)
        return state, sensors

    def motors(self, state, sensors):
        control = self.firm.control_t()
        self.firm.controllerPid(control, self.setpoint, sensors, state, 100)
        roll, pitch, yaw = (math.radians(command) for command in (control.roll, control.pitch, -control.yaw))
        thrust = control.thrust
        return (
            -(thrust - roll + pitch + yaw) / 800,
            (thrust - roll - pitch - yaw) / 800,
            -(thrust + roll - pitch + yaw) / 800,
            (thrust + roll + pitch - yaw) / 800,
        )


def test_crazychoir_flies_thrust_and_body_rates(fresh):
    plugin = WebotsPlugin(fresh)
    mode = plugin.setpoint.mode
    mode.roll = mode.pitch = mode.yaw = fresh.modeVelocity
    mode.z = fresh.modeDisable

    def motors(force, p=0.0, q=0.0, r=0.0):
        plugin.setpoint.attitudeRate.roll = math.degrees(p)
        plugin.setpoint.attitudeRate.pitch = -math.degrees(q)
        plugin.setpoint.attitudeRate.yaw = math.degrees(r)
        plugin.setpoint.thrust = float(np.clip(force * 38615 / 0.372652, 10001, 60000))
        return np.array(plugin.motors(*plugin.sense(0, 0, 0, (0, 0, 1), (0, 0, 0)))) * [-1, 1, -1, 1]

    assert motors(0.372652) == pytest.approx([38615 / 800] * 4)
    assert motors(100) == pytest.approx([60000 / 800] * 4)
    # to the left: the right side is lifted less
    assert np.all(np.sign(motors(0.3, p=1.0) - motors(0.3)) == [-1, -1, 1, 1])
    assert np.all(np.sign(motors(0.3, q=1.0) - motors(0.3)) == [-1, 1, 1, -1])


def test_crazychoir_goes_to_points(fresh):
    plugin = WebotsPlugin(fresh)
    planner, start = fresh.planner(), fresh.traj_eval_zero()
    fresh.plan_init(planner)
    start.pos = fresh.mkvec(0.0, 0.0, 1.0)
    # its call has no `linear`
    fresh.plan_go_to_from(planner, start, False, fresh.mkvec(1.0, 0.0, 1.0), 0.0, 2.0, 10.0)
    assert not fresh.plan_is_finished(planner, 11.0)
    goal = fresh.plan_current_goal(planner, 11.0)
    setpoint = plugin.setpoint
    setpoint.position.x, setpoint.position.y, setpoint.position.z = goal.pos.x, goal.pos.y, goal.pos.z
    setpoint.velocity.x, setpoint.velocity.y, setpoint.velocity.z = goal.vel.x, goal.vel.y, goal.vel.z
    mode = setpoint.mode
    mode.x = mode.y = mode.z = mode.yaw = fresh.modeAbs
    mode.roll = mode.pitch = mode.quat = fresh.modeDisable
    motors = plugin.motors(*plugin.sense(0, 0, 0, (0, 0, 1), (0, 0, 0)))
    # forwards: the rear rotors turn faster
    assert abs(motors[1]) > abs(motors[0])
    assert abs(motors[2]) > abs(motors[3])
    assert fresh.plan_is_finished(planner, 12.5)


def test_crazyflie_simulation_holds_its_height_and_speed(fresh):
    """A loop like that of Bitcraze's simulation (9.3): new structs at every step."""
    fresh.controllerPidInit()

    def command(velocity):
        state, sensors, setpoint, control = fresh.state_t(), fresh.sensorData_t(), fresh.setpoint_t(), fresh.control_t()
        state.position.z = 1.0
        setpoint.mode.z = fresh.modeAbs
        setpoint.position.z = 1.0
        setpoint.mode.yaw = fresh.modeVelocity
        setpoint.mode.x = setpoint.mode.y = fresh.modeVelocity
        setpoint.velocity.x = velocity
        setpoint.velocity_body = True
        for _ in range(5):
            fresh.controllerPid(control, setpoint, sensors, state, 100)
        return control

    assert command(0.0).thrust == pytest.approx(36000, abs=1)
    assert command(0.5).pitch < 0 < command(-0.5).pitch


class Gym:
    """An environment in the manner of safe-control-gym (9.4), for one drone."""

    def __init__(self, firm):
        self.firm = firm
        self.accelerations = [firm.lpf2pData() for _ in range(3)]
        self.rates = [firm.lpf2pData() for _ in range(3)]
        for filters, cutoff in ((self.accelerations, 80), (self.rates, 30)):
            for one in filters:
                firm.lpf2pInit(one, 1000, cutoff)
        firm.crtpCommanderHighLevelInit()
        self.control, self.setpoint = firm.control_t(), firm.setpoint_t()
        self.setpoint.mode.yaw = firm.modeDisable
        firm.controllerMellingerInit()
        assert firm.controllerMellingerTest()

    def step(self, t, position):
        firm = self.firm
        state, sensors = firm.state_t(), firm.sensorData_t()
        state.position.x, state.position.y, state.position.z = position
        state.attitudeQuaternion.w = 1
        sensors.acc.z = firm.lpf2pApply(self.accelerations[2], 1.0)
        sensors.gyro.x = firm.lpf2pApply(self.rates[0], 0.0)
        firm.crtpCommanderHighLevelUpdateTime(t)
        told = firm.crtpCommanderHighLevelGetSetpoint(self.setpoint, state)
        firm.controllerMellinger(self.control, self.setpoint, sensors, state, 0)
        return told, state


def test_safe_control_gym_takes_off_goes_and_lands(fresh):
    firm, gym = fresh, Gym(fresh)
    gym.step(0.0, (1, 2, 0))
    assert firm.crtpCommanderHighLevelTakeoff(1.0, 2.0) == 0
    assert gym.step(2.0, (1, 2, 1))[0]
    position = gym.setpoint.position
    assert (position.x, position.y, position.z) == (1, 2, 1)
    assert firm.crtpCommanderHighLevelTakeoff(1.0, 2.0) == 1  # it flies
    firm.crtpCommanderHighLevelGoTo(0.5, 0.0, 0.0, 0.5, 2.0, True)
    gym.step(4.0, (1.5, 2, 1))
    assert gym.setpoint.position.x == pytest.approx(1.5, abs=1e-6)
    assert gym.setpoint.attitude.yaw == pytest.approx(math.degrees(0.5), abs=1e-3)
    assert gym.control.thrust > 0
    firm.crtpCommanderHighLevelLandYaw(0.0, 1.0, 0.0)
    gym.step(5.5, (1.5, 2, 0))
    gym.step(5.6, (1.5, 2, 0))
    assert gym.setpoint.mode.z == firm.modeDisable  # the null setpoint
    assert firm.crtpCommanderHighLevelIsStopped()


@pytest.mark.parametrize("relative", [True, False])
def test_high_level_commander_with_velocity(fresh, relative):
    firm, gym = fresh, Gym(fresh)
    gym.step(0.0, (0, 0, 0.5))
    firm.crtpCommanderHighLevelTakeoffWithVelocity(1.0, 0.25, relative)
    end, duration = (1.5, 4.0) if relative else (1.0, 2.0)
    gym.step(duration / 2, (0, 0, 0.5))
    assert gym.setpoint.position.z == pytest.approx((0.5 + end) / 2, abs=1e-5)
    gym.step(duration, (0, 0, end))
    assert gym.setpoint.position.z == pytest.approx(end)
    firm.crtpCommanderHighLevelLandWithVelocity(0.5, -1, relative)
    bottom = end - 0.5 if relative else 0.5
    takes = (end - bottom) / 0.5  # at the speed of the firmware
    gym.step(duration + takes - 0.001, (0, 0, bottom))
    assert gym.setpoint.position.z == pytest.approx(bottom, abs=1e-5)
    gym.step(duration + takes + 0.001, (0, 0, bottom))
    assert firm.crtpCommanderHighLevelIsStopped()


def test_high_level_commanders_are_independent(fresh):
    one, other = fresh.HighLevelCommander(), fresh.HighLevelCommander()
    one.Takeoff(1.0, 1.0)
    setpoint, state = fresh.setpoint_t(), fresh.state_t()
    one.UpdateTime(1.0)
    assert one.GetSetpoint(setpoint, state)
    assert setpoint.position.z == 1
    assert not one.GetSetpoint(setpoint, state, 5)  # between the ticks of 100 Hz
    assert other.IsStopped()
    one.Disable()
    assert not one.GetSetpoint(setpoint, state)
    assert setpoint.position.z == 1
