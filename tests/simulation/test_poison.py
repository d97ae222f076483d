"""What is no number inside of one drone stops that drone, says why, and touches no bit of its neighbors."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.variables import parameter_table
from crazychoir_fw.simulation import DroneConfig, World

NAN = float("nan")
HIGH = 50.0  # [m], so that no drone falls to the floor, where MuJoCo solves all contacts together

# positions, velocities, attitudes and deviations of measurements, by the place of a NaN in them
POSE = {"pos": [0.5, 0.0, HIGH], "quat": {"w": 1.0}, "stdDevPos": 0.01, "stdDevQuat": 0.01}


def set_parameter(drone, name, value):
    """Write into the memory of the drone, past the client that refuses what is no number."""
    row = parameter_table()[name]
    drone.memory[row.offset : row.offset + 4].view(np.float32)[0] = value


def measure(drone, kind, **data):
    """Hand a measurement to the estimator, past the client that refuses what is no number."""
    measurement = ffi.new("measurement_t *", {"type": kind, "data": data})
    assert lib.cf_estimator_enqueue(ffi.addressof(drone.struct.onboard, "estimator"), measurement)


def parameter(name):
    return lambda drone: set_parameter(drone, name, NAN)


def measurement(kind, **data):
    return lambda drone: measure(drone, kind, **data)


def motion(array, index):
    return lambda drone: getattr(drone, array).__setitem__(index, NAN)


ESTIMATE, CONTROL = "the state estimate is not a number", "the controller's output is not a number"
MOTION = "the simulated motion is not finite"

POISONS = {
    "parameter: vertical gain": (parameter("velCtlPid.vzKp"), CONTROL),
    "parameter: roll gain": (parameter("pid_rate.roll_kp"), CONTROL),
    "parameter: pitch gain": (parameter("pid_attitude.pitch_kd"), CONTROL),
    "parameter: yaw gain": (parameter("pid_attitude.yaw_ki"), CONTROL),
    "parameter: process noise": (parameter("kalman.pNAtt"), ESTIMATE),
    "parameter: gyro noise": (parameter("kalman.mNGyro_yaw"), ESTIMATE),
    "parameter: deviation of poses": (parameter("locSrv.extPosStdDev"), ESTIMATE),
    "parameter: mounting angle": (parameter("imu_sensors.imuPhi"), CONTROL),
    "measurement: pose": (
        measurement(lib.MeasurementTypePose, pose={**POSE, "pos": [NAN, 0.0, HIGH]}),
        ESTIMATE,
    ),
    "measurement: attitude": (
        measurement(lib.MeasurementTypePose, pose={**POSE, "quat": {"x": NAN, "w": 1.0}}),
        ESTIMATE,
    ),
    "measurement: deviation": (
        measurement(lib.MeasurementTypePosition, position={"pos": [0.5, 0.0, HIGH], "stdDev": NAN}),
        ESTIMATE,
    ),
    "measurement: height": (
        measurement(lib.MeasurementTypeAbsoluteHeight, height={"height": NAN, "stdDev": 0.1}),
        ESTIMATE,
    ),
    "measurement: flow": (
        measurement(lib.MeasurementTypeFlow, flow={"dpixel": [0, NAN], "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}),
        ESTIMATE,
    ),
    "measurement: gyro": (measurement(lib.MeasurementTypeGyroscope, gyroscope={"gyro": {"x": NAN}}), ESTIMATE),
    "motion: velocity": (motion("_qvel", 2), MOTION),
    "motion: rates": (motion("_qvel", 4), MOTION),
    "motion: position": (motion("_qpos", 0), MOTION),
    "motion: attitude": (motion("_qpos", 5), MOTION),
}


class Flight:
    """Three drones in the air that fly about; the one in the middle is poisoned after three seconds."""

    def __init__(self, controller=None):
        self.world = World(
            [DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0, HIGH), controller=controller) for i in range(3)],
            seed=2,
            visuals=False,
        )
        self.world.run(1.8)  # falls while it boots
        for drone in self.world.drones:
            x, y, z = drone.true_position
            drone.high_level_commander.go_to(x + 0.3, y + 0.2, z - 8.0, 0.5, 2.5)
        self.world.run(1.2)

    def neighbors(self, poison=None):
        """Fly on for a while and return the neighbors' bytes, sampled on the way."""
        first, middle, last = self.world.drones
        assert first.is_flying
        assert middle.is_flying
        if poison is not None:
            poison(middle)
        samples = []
        for _ in range(8):
            self.world.run(0.05)
            for drone in (first, last):
                samples.append((drone.memory.tobytes(), drone._qpos.tobytes(), drone._qvel.tobytes()))
        return samples


@pytest.fixture(scope="module")
def flight():
    flight = Flight()
    flight.start = flight.world.snapshot()
    flight.undisturbed = flight.neighbors()
    return flight


@pytest.mark.parametrize(("poison", "reason"), POISONS.values(), ids=POISONS)
def test_poisoned_drone_locks_and_says_why_while_its_neighbors_fly_on(flight, poison, reason):
    flight.world.restore(flight.start)
    samples = flight.neighbors(poison)
    middle = flight.world.drones[1]
    assert reason in middle.failure
    assert middle.failure.startswith("cf2")
    assert f"SYS: Stopped, {reason}\n" in middle.console
    assert middle.is_locked
    assert not middle.is_flying
    assert not middle.can_fly
    assert [middle.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    assert (middle.log["supervisor.info"], middle.log["sys.isFlying"]) == (lib.CF_SUPERVISOR_INFO_IS_LOCKED, 0)

    assert samples == flight.undisturbed
    assert [drone.failure for drone in (flight.world.drones[0], flight.world.drones[2])] == [None, None]


def gains(controller, *names):
    return [(controller, name) for name in names]


@pytest.mark.parametrize(
    ("controller", "name"),
    [
        *gains(
            "pid", "pid_attitude.roll_kp", "pid_rate.pitch_ki", "pid_rate.yaw_kd", "posCtlPid.yKp", "velCtlPid.vxKFF"
        ),
        *gains("mellinger", "ctrlMel.kp_xy", "ctrlMel.massThrust", "ctrlMel.kR_xy", "ctrlMel.kw_z", "ctrlMel.ki_m_z"),
        *gains("indi", "ctrlINDI.g1_p", "ctrlINDI.ref_rate_q", "ctrlINDI.act_dyn_r", "posCtrlIndi.K_xi_z"),
        *gains("brescianini", "ctrlAtt.tau_rp", "ctrlAtt.zeta_z"),
        *gains("lee", "ctrlLee.KR_x", "ctrlLee.Kpos_Pz", "ctrlLee.mass"),
    ],
)
def test_gain_that_is_no_number_stops_the_drone_under_every_controller(controller, name):
    """Whole-numbered moments cannot show it: the drone would fall out of the sky without a word."""
    world = World([DroneConfig("cf1", controller=controller)])
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(1.0)
    assert drone.failure is None
    set_parameter(drone, name, NAN)
    world.run(0.1)
    assert CONTROL in drone.failure
    drone.reboot()
    assert drone.failure is None


@pytest.mark.parametrize("name", ["locSrv.extPosStdDev", "velCtlPid.vzKp", "kalman.pNAcc_z"])
def test_client_refuses_to_poison(flight, name):
    with pytest.raises(ValueError, match=rf"cf2: {name} is nan, allowed: a finite number"):
        flight.world.drones[1].param[name] = NAN
