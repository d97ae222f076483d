"""Flights of handlers over UDP, against the world that they really fly in."""

import math
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from lockstep import SILENCE_S, GoingOn, wait_for_odometry

from crazychoir_fw.radio import (
    LinkState,
    Mode,
    RadioHandlerFPQR,
    RadioHandlerFRPY,
    RadioHandlerVel,
    RadioHandlerVelLightHouse,
    RadioHandlerXYZ,
    ReconnectPolicy,
    SafetyArea,
)
from crazychoir_fw.simulation import DroneConfig, World

EXAMPLE = Path(__file__).parents[2] / "examples" / "radio" / "two_drones.py"
STARTS = {"cf1": (0.0, 0.0), "cf2": (1.0, 0.0)}


class Flight:
    """A served world and its handler."""

    def __init__(self, tmp_path, platform="cf2", starts=STARTS):
        self.world = World([DroneConfig(name, xy, platform=platform) for name, xy in starts.items()], seed=1)
        self.server = self.world.serve(port=0, silence=SILENCE_S)
        self.server.start()
        self.handler = None
        self.cache = tmp_path / "tables"

    def connect(self, handler_class, **options):
        # lockstep: the world advances only in `fly`, and while a call waits for a reply that needs time
        self.handler = handler_class(
            list(self.server.uris.values()),
            range(1, 1 + len(self.world.drones)),
            threaded=False,
            clock=lambda: self.world.time,
            cache=self.cache,
            **options,
        )
        with self.going_on():
            self.handler.connect()
        return self.handler

    def going_on(self):
        """Let time go on in another thread, for calls that wait for the drone."""
        return GoingOn(self.world)

    def fly(self, seconds, control=lambda: None, period=0.01):
        """Let time go on, with a control law at its rate."""
        self.catch_up()
        for _ in range(round(seconds / period)):
            control()
            self.handler.tick()
            self.world.run(period)
            self.catch_up()

    def catch_up(self):
        if not self.handler.options.odometry_hz:
            return
        while any(drone.odometry is None for drone in self.handler):
            self.world.run(0.01)
            time.sleep(0.001)
        wait_for_odometry(self.handler, self.world)

    def where(self, number):
        return self.world.drones[number - 1].true_position

    def close(self):
        if self.handler is not None:
            with self.going_on():
                self.handler.close()
        self.server.close()


@pytest.fixture
def flight(tmp_path):
    flights = []

    def make(**options):
        flights.append(Flight(tmp_path, **options))
        return flights[-1]

    yield make
    for one in flights:
        one.close()


def attitude(odometry):
    x, y, z, w = odometry.quat_xyzw
    return np.array(
        [
            math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
            math.asin(np.clip(2 * (w * y - z * x), -1, 1)),
            math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ]
    )


@pytest.mark.parametrize(
    ("handler_class", "platform"), [(RadioHandlerFPQR, "cf2"), (RadioHandlerFPQR, "cf21bl"), (RadioHandlerFRPY, "cf2")]
)
def test_hover_by_thrust(flight, handler_class, platform):
    air = flight(platform=platform)
    swarm = air.connect(handler_class, thrust=platform, odometry_hz=100, command_timeout_s=0.5)
    with air.going_on():
        swarm.takeoff()
    mass = air.world.drones[0].mass
    goals = {1: np.array([0.3, 0.2, 0.7]), 2: np.array([1.0, -0.2, 0.5])}

    def control():
        for number, goal in goals.items():
            odometry = swarm[number].odometry
            wanted = 4.0 * np.clip(goal - odometry.position, -0.5, 0.5) - 3.0 * odometry.velocity
            thrust = mass * (9.81 + wanted[2])
            tilt = np.array([-wanted[1], wanted[0], 0.0]) / 9.81
            if handler_class is RadioHandlerFRPY:
                swarm.command(number, thrust, *tilt)
            else:
                swarm.command(number, thrust, *(6.0 * (tilt - attitude(odometry))))

    air.fly(6.0, control)
    for number, goal in goals.items():
        np.testing.assert_allclose(air.where(number), goal, atol=0.05)


def test_angles_and_rates_have_the_right_signs(flight):
    """To the right, forward, and turned to the left, seen from the world."""
    air = flight()
    swarm = air.connect(RadioHandlerFRPY, command_timeout_s=0.5)
    with air.going_on():
        swarm.takeoff(1.0, 1.5)
    air.fly(2.0)
    weight = air.world.drones[0].mass * 9.81
    start = {number: air.where(number).copy() for number in (1, 2)}
    air.fly(0.5, lambda: (swarm.command(1, weight, 0.15, 0, 0), swarm.command(2, weight, 0, 0.15, 0.5)))
    one, two = (air.where(number) - start[number] for number in (1, 2))
    assert one[1] < -0.05
    assert abs(one[0]) < 0.05
    assert two[0] > 0.05
    w, x, y, z = air.world.drones[1].true_quat_wxyz
    assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(0.5, abs=0.15)


def test_velocity(flight):
    air = flight()
    swarm = air.connect(RadioHandlerVel, odometry_hz=50)
    with air.going_on():
        swarm.takeoff(0.6, 1.5)
    air.fly(2.0)
    assert air.where(1)[2] == pytest.approx(0.6, abs=0.06)
    start = {number: air.where(number).copy() for number in (1, 2)}
    swarm.command(1, 0.4, 0.0, 0.0)
    swarm.command(2, 0.0, -0.3, 0.1, 0.5)
    air.fly(0.9)  # repeated, without another command
    np.testing.assert_allclose((air.where(1) - start[1])[:2], (0.4 * 0.9, 0), atol=0.15)
    assert (air.where(1) - start[1])[0] > 0.15
    assert (air.where(2) - start[2])[1] < -0.1
    # no more commands: it hovers, longer than the timeout of the watchdog on board
    air.fly(1.0)
    still = air.where(1).copy()
    air.fly(3.0)
    assert np.linalg.norm((air.where(1) - still)[:2]) < 0.1
    assert air.world.drones[0].supervisor_state == "Flying"
    np.testing.assert_allclose(swarm[1].position, air.where(1), atol=0.05)
    swarm.land(duration=1.5)
    air.fly(2.2)
    assert swarm[1].mode is Mode.LANDED
    assert air.where(1)[2] < 0.03


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_go_to(flight, platform):
    air = flight(platform=platform)
    swarm = air.connect(RadioHandlerXYZ)
    with air.going_on():
        assert swarm.command(1, 0.5, 0.3, 0.8, 2.0, yaw=1.0)  # from the floor, and armed where it must be
        assert swarm.command(2, 1.0, -0.4, 0.5, 2.0)
    air.fly(3.5)
    np.testing.assert_allclose(air.where(1), (0.5, 0.3, 0.8), atol=0.1)
    np.testing.assert_allclose(air.where(2), (1.0, -0.4, 0.5), atol=0.1)
    w, x, y, z = air.world.drones[0].true_quat_wxyz
    assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(1.0, abs=0.1)
    # stopped, and up again
    swarm.stop(1)
    air.fly(1.5)
    assert air.where(1)[2] < 0.03
    assert air.where(2)[2] > 0.4
    swarm.recover(1)  # it fell
    swarm.resume(1)
    with air.going_on():
        assert swarm.command(1, 0.5, 0.3, 0.6, 2.0)
    air.fly(3.0)
    np.testing.assert_allclose(air.where(1), (0.5, 0.3, 0.6), atol=0.1)


def test_who_is_silent_with_a_thrust_comes_down_level(flight):
    air = flight()
    swarm = air.connect(RadioHandlerFRPY)
    with air.going_on():
        swarm.takeoff(0.8, 1.5)
    air.fly(2.0)
    weight = air.world.drones[0].mass * 9.81
    swarm.command(1, weight, 0.2, 0.0, 0.0)
    air.fly(1.5)
    _, x, y, _ = air.world.drones[0].true_quat_wxyz
    assert 1 - 2 * (x * x + y * y) > math.cos(math.radians(8))
    air.fly(1.5)
    assert air.where(1)[2] < 0.03
    assert swarm[1].is_stopped
    assert air.where(2)[2] == pytest.approx(0.8, abs=0.06)  # it was left to its planner


def test_the_safety_area_holds(flight):
    area = SafetyArea((-1, -1, -0.1), (1.5, 1, 1.5))
    air = flight()
    swarm = air.connect(RadioHandlerVel, safety_area=area, odometry_hz=50, on_silence="repeat")
    with air.going_on():
        swarm.takeoff(0.6, 1.5)
    air.fly(2.0)
    swarm.command(1, -1.0, 0.0, 0.0)
    swarm.command(2, 0.0, 1.0, 0.0)
    air.fly(4.0)
    assert air.where(1)[0] > -1.1
    assert air.where(2)[1] < 1.1
    assert swarm[1].mode is Mode.READY
    # a drone that is outside nevertheless lands
    swarm.land(agents=2)
    swarm[1]._options.safety_area._box[0, 0] = -0.2
    air.fly(3.0)
    assert swarm[1].mode is Mode.LANDED
    assert "outside of the safety area" in swarm[1].reason
    assert air.where(1)[2] < 0.03


def test_parameters_arrive_and_logs_tell_the_truth(flight):
    air = flight()
    swarm = air.connect(
        RadioHandlerVelLightHouse,
        parameters={"velCtlPid.vzKp": 20.0},
        log={"pm.vbat": 10, "stateEstimate.z": 100, "stabilizer.yaw": 50},
    )
    drone = air.world.drones[0]
    assert drone.param["velCtlPid.vzKp"] == pytest.approx(20.0)
    assert drone.param["stabilizer.estimator"] == 2
    with air.going_on():
        swarm.takeoff(0.5, 1.5)
    air.fly(2.0)
    assert swarm[1].latest["stateEstimate.z"].value == pytest.approx(drone.true_position[2], abs=0.03)
    assert swarm[1].latest["pm.vbat"].value == pytest.approx(drone.battery_voltage, abs=0.2)
    assert swarm[1].odometry.time_s == pytest.approx(air.world.time, abs=0.1)


def test_poses_from_outside_reach_the_estimator(flight):
    air = flight()
    swarm = air.connect(RadioHandlerVel, pose_hz=20)
    sent = []
    air.fly(1.0, lambda: sent.append(swarm.external_pose(1, air.where(1), (0, 0, 0, 1))))
    assert sum(sent) == pytest.approx(20, abs=1)


def test_a_server_that_ends_is_a_lost_link_and_comes_back(flight, eventually):
    air = flight(starts={"cf1": (0.0, 0.0)})
    swarm = air.connect(RadioHandlerXYZ, reconnect=ReconnectPolicy(100, 0.05, 1.0))
    with air.going_on():
        swarm.command(1, 0.2, 0.0, 0.5, 1.5)
    air.fly(2.0)
    uris = dict(air.server.uris)
    port = int(uris["cf1"].rsplit(":", 1)[1])
    air.server.close()
    eventually(lambda: all(drone.losses == 1 for drone in swarm))
    assert not swarm.command(1, 0.0, 0.0, 0.5, 1.5)
    air.server = air.world.serve(port=port, silence=SILENCE_S)
    air.server.start()
    with air.going_on():
        eventually(lambda: all(drone.link_state is LinkState.CONNECTED for drone in swarm))
    # its planner kept it up, and nothing of the handler disturbed that
    np.testing.assert_allclose(air.where(1), (0.2, 0.0, 0.5), atol=0.08)
    swarm.resume()
    with air.going_on():
        assert swarm.command(1, 0.0, 0.0, 0.6, 1.5)
    air.fly(2.5)
    np.testing.assert_allclose(air.where(1), (0.0, 0.0, 0.6), atol=0.06)


@pytest.fixture
def real_time():
    """A world at the pace of the wall, and where it is served."""
    world = World([DroneConfig(name, xy) for name, xy in STARTS.items()], seed=1)
    with world.serve(port=0) as server:
        runs = threading.Thread(target=server.run)
        runs.start()
        yield world, list(server.uris.values())
        server.stop()
        runs.join()


def test_the_example_flies(real_time, eventually):
    """In real time and with threads, as users do."""
    world, uris = real_time
    run = subprocess.run([sys.executable, EXAMPLE, *uris], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert "agent_0 ends its half circle at" in run.stdout
    # the diameter is speed times time over half of pi
    for drone, sign in zip(world.drones, (1, -1), strict=True):
        x, y = STARTS[drone.id]
        np.testing.assert_allclose(drone.true_position[:2], (x + sign * 0.3 * 5.2 / math.pi * 2, y), atol=0.25)
    eventually(lambda: all(drone.true_position[2] < 0.05 for drone in world.drones))


def test_the_example_says_what_to_start():
    run = subprocess.run([sys.executable, EXAMPLE, "udp://127.0.0.1:9"], capture_output=True, text=True, timeout=120)
    assert run.returncode == 1
    assert "agent_0: udp://127.0.0.1:9: nobody listens there; is `crazychoir serve` running?" in run.stderr
    assert "crazychoir serve --count 2" in run.stderr


STANDS_STILL = """
import ctypes, sys, time
from crazychoir_fw.radio import RadioHandlerVel

told = []
with RadioHandlerVel([sys.argv[1]], odometry_hz=50) as swarm:
    swarm.on_event = lambda agent, kind, text: told.append(kind)
    swarm.takeoff(0.4)
    time.sleep(2.5)
    ctypes.PyDLL(None).usleep(1_300_000)  # with the interpreter, that no other thread gets
    while "logs" not in told:
        time.sleep(0.01)
    known = swarm[0].odometry.time_s
    while swarm[0].odometry.time_s < known + 0.2:
        time.sleep(0.01)
    print(f"at {swarm[0].position[2]:.1f} m")
"""


def test_logs_go_on_after_a_program_that_stood_still(real_time):
    """For longer than the second after which a drone deletes them."""
    _, uris = real_time
    run = subprocess.run([sys.executable, "-c", STANDS_STILL, uris[0]], capture_output=True, text=True, timeout=120)
    assert (run.returncode, run.stdout) == (0, "at 0.4 m\n"), run.stderr


@pytest.mark.parametrize("before_ms", [-80, -40, 0, 20, 40, 80])
def test_no_goal_is_lost_to_a_reset_on_the_floor(flight, before_ms):
    """A drone drops commands at its pre-flight timeout.

    docs/reference/planner-commander.md#14.6.
    """
    air = flight(starts={"cf1": (0.0, 0.0)})
    swarm = air.connect(RadioHandlerXYZ, logger=False, odometry_hz=0)
    with air.going_on():
        swarm[1].make_ready()
    supervisor = air.world.drones[0].struct.onboard.supervisor
    supervisor.prefltTimeout = max(2000, air.world.tick - supervisor.arming_tick + 200)
    air.world.step(supervisor.arming_tick + supervisor.prefltTimeout + 40 - before_ms - air.world.tick)
    assert swarm[1].command(0.0, 0.0, 0.5, 1.0)
    air.fly(6.0)
    assert air.where(1)[2] == pytest.approx(0.5, abs=0.1)
