"""Flights of drones whose provider brings more than the algorithms."""

import struct

import numpy as np

from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart
from crazychoir_fw.simulation import DroneConfig, World

RPYT, GENERIC, HIGH_LEVEL, SUPERVISOR = 3, 7, 8, 9  # ports


def world_of(*words, seed=1, spacing=1.0, threads=None, **settings):
    """Return a world with a drone of each provider in a row, all with the same settings."""
    configs = [DroneConfig(f"cf{i}", (spacing * i, 0.0), provider=word, **settings) for i, word in enumerate(words)]
    return World(configs, seed=seed, visuals=False, threads=threads)


def airborne(*words, height=0.5, **settings):
    """Return such a world after take-off."""
    world = world_of(*words, **settings)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=height, duration_s=1.5)
    world.run(2.0)
    return world


def pieces():
    """Return an uploaded trajectory of two seconds: sideways and back."""
    there = np.zeros(33, dtype="<f4")
    there[1], there[2] = 0.3, -0.1  # of x: c1, c2
    there[32] = 1.0
    back = np.zeros(33, dtype="<f4")
    back[0], back[1], back[2] = 0.2, 0.1, -0.3
    back[32] = 1.0
    return np.array([there, back])


def compressed():
    return CompressedStart(0.0, 0.0, 0.0, 0.0), [CompressedSegment(1.0, [0.0, 0.2, 0.2], [], [0.1], [])]


class Sampled:
    """A world, and what was seen of it every 10 ms."""

    def __init__(self, world):
        self.world = world
        self.rows = []

    def run(self, seconds, each=None):
        for _ in range(round(seconds * 100)):
            if each is not None:
                each()
            self.world.step(10)
            self.rows.append(np.concatenate([self.world.data.qpos, self.world.data.qvel]))

    @property
    def path(self):
        return np.array(self.rows)


def everything(world):
    """Fly all that a client can ask for with the first drone, and return what was seen."""
    drone, seen = world.drones[0], Sampled(world)
    plans, setpoints = drone.high_level_commander, drone.commander
    seen.run(2.0)
    plans.takeoff(absolute_height_m=0.5, duration_s=1.2)
    seen.run(1.4)
    plans.go_to(0.4, 0.1, 0.7, 0.5, duration_s=1.0)
    seen.run(0.6)
    plans.go_to(0.1, 0.0, -0.1, 0.0, duration_s=1.0, relative=True, linear=True)
    seen.run(1.2)
    plans.spiral(2.0, 0.3, 0.4, 0.1, duration_s=1.5)
    seen.run(1.6)
    plans.upload_trajectory(1, pieces(), offset=64)
    plans.start_trajectory(1, time_scale=0.8, relative_position=True)
    seen.run(1.8)
    plans.start_trajectory(1, relative_position=True, reversed=True)
    seen.run(1.0)
    plans.upload_compressed_trajectory(2, *compressed(), offset=1000)
    plans.start_trajectory(2, relative_position=True)
    seen.run(1.2)
    seen.run(0.4, lambda: setpoints.send_position_setpoint(0.5, 0.2, 0.6, 10.0))
    seen.run(0.4, lambda: setpoints.send_velocity_world_setpoint(0.2, -0.1, 0.1, 5.0))
    seen.run(0.4, lambda: setpoints.send_hover_setpoint(0.1, 0.1, 20.0, 0.7))
    seen.run(0.2, lambda: setpoints.send_zdistance_setpoint(1.0, -1.0, 0.0, 0.7))
    seen.run(
        0.2,
        lambda: setpoints.send_full_state_setpoint(
            (0.5, 0.2, 0.7), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1), (0.0, 0.0, 0.1, 0.995), 0.0, 0.0, 0.1
        ),
    )
    setpoints.send_setpoint(0.0, 0.0, 0.0, 0)
    seen.run(0.1, lambda: setpoints.send_setpoint(1.0, -1.0, 5.0, 40000))
    seen.run(0.2, lambda: setpoints.send_position_setpoint(0.5, 0.2, 0.6, 10.0))
    setpoints.send_notify_setpoint_stop()
    plans.go_to(0.2, 0.0, 0.5, 0.0, duration_s=1.2)
    seen.run(1.4)
    plans.land(absolute_height_m=0.0, duration_s=1.5)
    seen.run(7.0)  # long enough for the supervisor to see that it has landed, and to be ready again
    return seen.path


def record(command, layout, *values):
    """Return a packet of the high-level commander, for every group."""
    return struct.pack(f"<BB{layout}", command, 0, *values)
