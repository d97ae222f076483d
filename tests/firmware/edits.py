"""Edits of a checkout, module by module, and what is seen of them in a flight."""

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crazychoir_fw.firmware.levels import ALGORITHMS, MODULES, STABILIZER


@dataclass(frozen=True)
class Edit:
    """One edit: a text of a file that is replaced by another one."""

    file: str
    """From src/modules/src/ on."""
    level: str
    """The lowest level at which the file flies."""
    text: str
    by: str
    seen: str
    """What is seen, for people."""
    observe: Callable[[Any], float]
    """What is measured in a flight of half a minute at most, given its world with one drone."""
    effect: Callable[[float, float], bool]
    """Whether that is as expected, given what was measured without and with the edit."""
    settings: dict[str, Any] = field(default_factory=dict)
    """How the drone is configured."""


def hover(world, height=0.5, seconds=3.0):
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(absolute_height_m=height, duration_s=1.5)
    world.run(seconds)
    return drone


def height(world):
    """Height (m) after a take-off to 0.5 m."""
    return float(hover(world).true_position[2])


def early_height(world):
    """Height (m) in the midst of a take-off."""
    return float(hover(world, seconds=0.8).true_position[2])


def most_tilt(world):
    """Largest tilt (deg) in the first second of a take-off."""
    drone = hover(world, seconds=0.0)
    tilts = []
    for _ in range(100):
        world.step(10)
        w, _, _, z = drone.true_quat_wxyz
        tilts.append(np.degrees(2.0 * np.arccos(min(1.0, np.hypot(w, z)))))
    return float(max(tilts))


def seen_error(world):
    """Largest distance (m) of the estimate from the truth while the drone hovers."""
    drone = hover(world, seconds=2.0)
    errors = []
    for _ in range(100):
        world.step(10)
        errors.append(np.linalg.norm(drone.estimated_position - drone.true_position))
    return max(errors)


def standing(world):
    """Whether the drone can fly after two and a half seconds."""
    world.run(2.5)
    return float(world.drones[0].can_fly)


def landed(world):
    """Time (s) from landing until the drone is no longer in state Flying."""
    drone = hover(world, seconds=2.5)
    drone.high_level_commander.land(absolute_height_m=0.0, duration_s=1.5)
    start = world.time
    while drone.supervisor_state == "Flying" and world.time < start + 10.0:
        world.step(10)
    return world.time - start


def position_setpoint(world):
    """Height (m) at which a drone hovers that receives setpoints of z = 0.6 m."""
    drone = hover(world, seconds=1.5)
    for _ in range(100):
        drone.receive_packet(7, 0, struct.pack("<B4f", 7, 0.0, 0.0, 0.6, 0.0))
        world.run(0.02)
    return float(drone.true_position[2])


def rpyt(world):
    """Roll (deg) that is flown when a packet asks for 5 deg."""
    drone = hover(world, seconds=1.5)
    drone.receive_packet(3, 0, struct.pack("<3fH", 0.0, 0.0, 0.0, 0))
    drone.receive_packet(3, 0, struct.pack("<3fH", 5.0, 0.0, 0.0, 40000))
    world.run(0.02)
    return float(drone.log["ctrltarget.roll"])


def controller(world):
    """Number of the controller that flies."""
    hover(world, seconds=0.2)
    return float(world.drones[0].param["stabilizer.controller"])


def rejected(world):
    """Measurements (1/s) for which the queue of the estimator had no room."""
    drone = hover(world)
    return float(drone.log["estimator.rtRej"])


def tilt(world):
    """Estimated roll (deg) of a drone that stands level, by the complementary estimator."""
    world.run(3.0)
    return float(abs(world.drones[0].log["stabilizer.roll"]))


def estimated_height(world):
    """Estimated height (m) of a drone that is held 1.2 m above the floor, by the complementary estimator."""
    drone = world.drones[0]
    for _ in range(300):
        drone.place((0.0, 0.0, 1.2))
        world.step(10)
    return float(drone.estimated_position[2])


def tested_motors(world):
    """Duty of the first motor while the propellers are tested."""
    drone = world.drones[0]
    world.run(2.5)
    drone.param["health.startPropTest"] = 1
    world.run(0.02)
    return float(max(drone.struct.onboard.motors.list))


def sidestep(world):
    """Distance (m) that a drone moves from its place when it receives the position of a peer beside it."""
    drone = hover(world, seconds=2.5)
    for _ in range(150):
        drone.struct.onboard.peers.peers[0].id = 7
        drone.struct.onboard.peers.peers[0].pos.x = 0.25
        drone.struct.onboard.peers.peers[0].pos.z = 0.5
        drone.struct.onboard.peers.peers[0].pos.timestamp = drone.struct.onboard.tick
        world.step(10)
    return float(abs(drone.true_position[0]))


def larger(by):
    return lambda before, after: after > before + by


def smaller(by):
    return lambda before, after: after < before - by


AVOIDING = {"parameters": {"colAv.enable": 1}}
COMPLEMENTARY = {"positioning": "none", "decks": ["zranger"], "estimator": "complementary"}

EDITS = (
    Edit(
        "planner.c",
        ALGORITHMS,
        "plan_vertical(p, curr_pos, curr_yaw, hover_height, hover_yaw",
        "plan_vertical(p, curr_pos, curr_yaw, hover_height + 0.3f, hover_yaw",
        "the drone rises 0.3 m higher",
        height,
        larger(0.2),
    ),
    Edit(
        "controller/controller_pid.c",
        ALGORITHMS,
        "control->thrust = actuatorThrust;",
        "control->thrust = 0.9f * actuatorThrust;",
        "the drone rises later",
        early_height,
        smaller(0.01),
    ),
    Edit(
        "controller/controller_mellinger.c",
        ALGORITHMS,
        "self->massThrust * force",
        "0.8f * self->massThrust * force",
        "the drone rises later",
        early_height,
        smaller(0.01),
        {"controller": "mellinger"},
    ),
    Edit(
        "kalman_core/kalman_core.c",
        ALGORITHMS,
        "state->position.z = this->S[KC_STATE_Z];",
        "state->position.z = this->S[KC_STATE_Z] + 0.2f;",
        "the drone hovers 0.2 m lower",
        height,
        smaller(0.1),
    ),
    Edit(
        "kalman_core/mm_pose.c",
        ALGORITHMS,
        "poseMeasurement_t *pose) {",
        "poseMeasurement_t *pose) {\n  pose->x += 0.2f;",
        "the estimate is 0.2 m off",
        seen_error,
        larger(0.1),
    ),
    Edit(
        "power_distribution_quadrotor.c",
        ALGORITHMS,
        "whole(control->thrust - r + p + control->yaw)",
        "whole(0.8f * control->thrust - r + p + control->yaw)",
        "the drone tilts at take-off",
        most_tilt,
        larger(0.3),
    ),
    Edit(
        "collision_avoidance.c",
        MODULES,
        ".ellipsoidRadii             = {.x = 0.3f, .y = 0.3f",
        ".ellipsoidRadii             = {.x = 0.62f, .y = 0.62f",
        "the drone keeps a larger distance",
        sidestep,
        larger(0.05),
        AVOIDING,
    ),
    Edit(
        "sensfusion6.c",
        ALGORITHMS,
        "sensfusion6UpdateQImpl(gx, gy, gz, ax, ay, az, dt);",
        "sensfusion6UpdateQImpl(gx, gy, gz, ax, ay + 0.3f, az, dt);",
        "the estimate tilts",
        tilt,
        larger(1.0),
        COMPLEMENTARY,
    ),
    Edit(
        "estimator/position_estimator_altitude.c",
        ALGORITHMS,
        "estimate->position.z = state.estimatedZ;",
        "estimate->position.z = state.estimatedZ + 0.3f;",
        "the estimate is 0.3 m higher",
        estimated_height,
        larger(0.2),
        COMPLEMENTARY,
    ),
    Edit(
        "commander.c",
        MODULES,
        "if (priority < currentPriority) {",
        "if (priority < currentPriority || priority > COMMANDER_PRIORITY_HIGHLEVEL) {",
        "setpoints of clients are ignored",
        position_setpoint,
        smaller(0.05),
    ),
    Edit(
        "crtp_commander_generic.c",
        MODULES,
        "= values->z;",
        "= values->z + 0.2f;",
        "the drone hovers 0.2 m above the setpoint",
        position_setpoint,
        larger(0.1),
    ),
    Edit(
        "crtp_commander_rpyt.c",
        MODULES,
        "mode == RATE ? 0 : value;",
        "mode == RATE ? 0 : 2.0f * value;",
        "the drone tilts twice as far",
        rpyt,
        larger(4.0),
    ),
    Edit(
        "crtp_commander_high_level.c",
        MODULES,
        "= ev->pos.z;",
        "= ev->pos.z + 0.2f;",
        "the drone hovers 0.2 m above its plan",
        height,
        larger(0.1),
    ),
    Edit(
        "supervisor.c",
        MODULES,
        "IS_FLYING_HYSTERESIS_THRESHOLD M2T(2000)",
        "IS_FLYING_HYSTERESIS_THRESHOLD M2T(500)",
        "the landing is noticed 1.5 s earlier",
        landed,
        smaller(1.0),
    ),
    Edit(
        "supervisor_state_machine.c",
        MODULES,
        ".triggers        = SUPERVISOR_CB_ARMED,",
        ".triggers        = SUPERVISOR_CB_ARMED | SUPERVISOR_CB_CRASHED,",
        "the drone never becomes ready to fly",
        standing,
        smaller(0.5),
    ),
    Edit(
        "controller/controller.c",
        MODULES,
        "#define DEFAULT_CONTROLLER ControllerTypePID",
        "#define DEFAULT_CONTROLLER ControllerTypeMellinger",
        "another controller flies by default",
        controller,
        larger(0.5),
    ),
    Edit(
        "estimator/estimator.c",
        MODULES,
        "#define MEASUREMENTS_QUEUE_SIZE (20)",
        "#define MEASUREMENTS_QUEUE_SIZE (2)",
        "measurements are lost",
        rejected,
        larger(10.0),
    ),
    Edit(
        "estimator/estimator_complementary.c",
        MODULES,
        "tof = m.data.tof;",
        "tof = m.data.tof;\n        tof.distance += 0.3f;",
        "the estimate is 0.3 m higher",
        estimated_height,
        larger(0.2),
        COMPLEMENTARY,
    ),
    Edit(
        "estimator/estimator_kalman.c",
        MODULES,
        "memcpy(state, &taskEstimatorState, sizeof(state_t));",
        "memcpy(state, &taskEstimatorState, sizeof(state_t));\n  state->position.z += 0.2f;",
        "the drone hovers 0.2 m lower",
        height,
        smaller(0.1),
    ),
    Edit(
        "peer_localization.c",
        MODULES,
        "return idx < PEER_LOCALIZATION_MAX_NEIGHBORS ? &other_positions[idx] : NULL;",
        "(void)idx;\n  return NULL;",
        "the drone does not see others",
        sidestep,
        smaller(0.05),
        AVOIDING,
    ),
    Edit(
        "stabilizer.c",
        STABILIZER,
        "commanderGetSetpoint(&setpoint, &state);",
        "commanderGetSetpoint(&setpoint, &state);\n  setpoint.position.z += 0.2f;",
        "the drone hovers 0.2 m above its plan",
        height,
        larger(0.1),
    ),
    Edit(
        "health.c",
        STABILIZER,
        "ratioOr(CONFIG_MOTORS_DEFAULT_PROP_TEST_PWM_RATIO,",
        "ratioOr(12345,",
        "the test of the propellers is gentler",
        tested_motors,
        lambda before, after: before > 20000 and after == 12345,
    ),
)
