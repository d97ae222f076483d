"""Estimator, commander and supervisor meet faults as the reference says.

docs/reference/planner-commander.md#8.3, #14.2, #14.3, #14.5; docs/reference/estimators.md#7, #8.2, #12.3, #18;
docs/reference/vehicle.md#6, #14.2; docs/reference/control-pid.md#12.
"""

import math

import mujoco
import numpy as np
import pytest

from crazychoir_fw.simulation import (
    BatteryFault,
    DroneConfig,
    Gust,
    ImuFault,
    Kick,
    MotorFault,
    PayloadDrop,
    PositioningFault,
    RadioFault,
    World,
)


def states(world, drone, seconds):
    """Step and return the states that the supervisor entered, with their times (s)."""
    entered, last = [], drone.supervisor_state
    for _ in range(round(seconds * 1000)):
        world.step(1)
        if drone.supervisor_state != last:
            last = drone.supervisor_state
            entered.append((world.time, last))
    return entered


def horizontal(drone):
    return math.hypot(drone.true_position[0], drone.true_position[1])


# ---------------------------------------------------------------- motors


def test_drone_without_a_motor_turns_over_and_is_crashed(hovering):
    """14.3, 14.5: below -0.2 g for 100 ms, or below 0.5 g for a second, and Flying becomes Crashed."""
    world = hovering()
    drone = world.drones[0]
    start = world.time + 0.1
    world.add_fault(MotorFault(at=start, motor=2))
    entered = states(world, drone, 3.0)
    assert [state for _, state in entered] == ["Crashed"]
    # one rotor less: the torque of its arm turns the drone over within the fall from 1 m; it is tumbled when it lies
    assert 0.1 < entered[0][0] - start < 2.2
    assert drone.is_crashed
    assert not drone.can_fly
    assert [drone.log[f"motor.m{i}"] for i in range(1, 5)] == [0, 0, 0, 0]
    assert drone.true_position[2] < 0.1
    assert drone.struct.vehicle.rotors.rpm[1] == 0.0
    # crashed, not locked: the drone flies again after it was put upright
    world.add_fault(MotorFault(at=world.time, motor=2, efficiency=1.0))
    drone.place((0.0, 0.0, 0.02))
    world.run(0.5)
    drone.recover_from_crash()
    world.run(0.3)
    assert drone.can_fly


def test_weak_motor_is_borne_and_its_share_shows_in_the_command(hovering, follow):
    world = hovering()
    drone = world.drones[0]
    before = np.mean(follow(world, 1.0, lambda: drone.log["motor.m1"]))
    world.add_fault(MotorFault(at=world.time, motor=1, efficiency=0.8, duration=3.0))
    follow(world, 2.0, lambda: None)
    thrust = follow(world, 1.0, lambda: list(drone.struct.vehicle.rotors.thrust))
    during = drone.log["motor.m1"]
    assert drone.is_flying
    assert drone.true_position[2] == pytest.approx(1.0, abs=0.1)
    # the command rises until the thrusts are even again
    assert np.mean(thrust, axis=0)[0] == pytest.approx(np.mean(thrust), rel=0.08)
    assert during > 1.1 * before
    follow(world, 3.0, lambda: None)
    assert list(drone.struct.vehicle.rotors.efficiency) == [1.0] * 4
    assert drone.true_position[2] == pytest.approx(1.0, abs=0.05)


# ---------------------------------------------------------------- inertial sensors


@pytest.mark.parametrize(("sensor", "axis"), [("gyro", "x"), ("acc", "z")])
def test_a_stuck_axis_gives_its_first_reading_for_ever(hovering, sensor, axis):
    world = hovering()
    drone = world.drones[0]
    world.add_fault(ImuFault(at=world.time, sensor=sensor, axis=axis, stuck=True, duration=0.05))
    raw = drone.struct.onboard.sensors.gyro_raw
    seen, others = [], []
    for _ in range(40):
        world.step(1)
        seen.append(raw.x)
        others.append(raw.y)
    assert len(set(others)) > 10
    assert (len(set(seen)) == 1) == (sensor == "gyro")
    filtered = getattr(drone.struct.onboard.sensors.data, sensor)
    assert math.isfinite(getattr(filtered, axis))
    world.run(0.1)
    assert drone.is_flying


def test_stuck_gyro_ends_in_a_crash_and_not_in_numbers_that_are_none(hovering):
    """The attitude loop flies blind on that axis: the drone turns over, the supervisor sees it, nothing is NaN."""
    world = hovering()
    drone = world.drones[0]
    world.add_fault(ImuFault(at=world.time + 0.1, sensor="gyro", axis="all", stuck=True))
    world.add_fault(Kick(at=world.time + 0.2, impulse=(0.002, 0.0, 0.0), point=(0.0, 0.03, 0.02)))
    entered = states(world, drone, 6.0)
    assert entered, "it should not fly on"
    assert entered[0][1] == "Crashed"
    assert drone.failure is None
    assert np.isfinite(drone.estimated_position).all()


def test_gyro_bias_in_flight_is_borne_by_the_filter_with_poses(hovering, follow):
    """The still calibration is over (12.3): 3 deg/s are a slope of the attitude that poses hold against."""
    world = hovering()
    drone = world.drones[0]
    world.add_fault(ImuFault(at=world.time, sensor="gyro", axis="y", bias=3.0))
    seen = follow(world, 5.0, lambda: (horizontal(drone), drone.log["gyro.y"]))
    away = [place for place, _ in seen]
    assert drone.is_flying
    assert np.mean([rate for _, rate in seen[100:]]) == pytest.approx(3.0, abs=1.0)
    # it is off by a hand, and stays there
    assert 0.01 < max(away) < 0.4
    assert away[-1] == pytest.approx(np.mean(away[-100:]), abs=0.05)


def test_noise_of_a_bad_accelerometer_is_as_strong_as_asked(hovering):
    world = hovering()
    drone = world.drones[0]
    hardware = drone.struct.onboard.sensors.data
    quiet = [hardware.acc.x for _ in range(500) if world.step(1) is None]
    world.add_fault(ImuFault(at=world.time, sensor="acc", axis="x", noise=0.5))
    noisy = [hardware.acc.x for _ in range(2000) if world.step(1) is None]
    # through the 30 Hz low-pass of two poles: 2 * 30 / 1000 * 1.11 of the power
    assert np.std(noisy) == pytest.approx(np.hypot(np.std(quiet), 0.5 * math.sqrt(0.0667)), rel=0.15)


# ---------------------------------------------------------------- positioning


def test_lost_motion_capture_lets_the_drone_drift_and_poses_bring_it_back(hovering, follow):
    world = hovering()
    drone = world.drones[0]
    start = drone.true_position
    world.add_fault(PositioningFault(at=world.time, lost=True, duration=5.0))
    drift = follow(world, 5.0, lambda: np.linalg.norm(drone.true_position - start))
    # no position arrives: the estimate stays near the setpoint while the drone drifts away
    error = np.linalg.norm(drone.estimated_position - drone.true_position)
    assert 0.05 < drift[-1] < 1.0
    assert error > 0.05
    assert drone.is_flying
    back = follow(world, 5.0, lambda: np.linalg.norm(drone.estimated_position - drone.true_position))
    assert min(np.flatnonzero(np.array(back) < 0.05)) < 100  # within a second
    assert np.linalg.norm(drone.true_position - [0.0, 0.0, 1.0]) < 0.05
    assert [event.details["state"] for event in world.events] == ["begins", "ends"]


@pytest.mark.parametrize("positioning", ["mocap_position", "lighthouse", "loco_tdoa3", "flow"])
def test_every_system_can_be_lost(hovering, positioning):
    world = hovering(positioning=positioning, height=0.6, settle=3.0)
    drone = world.drones[0]
    queue = drone.struct.onboard.estimator
    world.add_fault(PositioningFault(at=world.time, lost=True, duration=0.3))
    variance = ("kalman.varX", "kalman.varPX")
    world.run(0.02)
    early = [drone.log[name] for name in variance]
    world.run(0.27)
    late = [drone.log[name] for name in variance]
    # nothing measures: the filter knows less and less
    assert late[1] > early[1]
    world.run(0.7)
    assert drone.log["kalman.varPX"] < late[1]
    assert queue is not None
    assert drone.is_flying


def test_filter_that_leaves_its_bounds_resets_itself(hovering):
    """7, 8.2: beyond 10 m/s or 100 m the next loop resets the filter, and poses correct its position again."""
    world = hovering()
    drone = world.drones[0]
    world.add_fault(PositioningFault(at=world.time, lost=True, duration=4.0))
    # 2 g more than there is: the filter believes to climb at 20 m/s^2
    world.add_fault(ImuFault(at=world.time, sensor="acc", axis="z", bias=2.0, duration=1.0))
    fastest = 0.0
    drops = 0
    for _ in range(1000):
        before = drone.log["stateEstimate.vz"]
        world.step(1)
        now = drone.log["stateEstimate.vz"]
        fastest = max(fastest, abs(now))
        drops += before > 8.0 and abs(now) < 2.0
    assert drops >= 1
    assert fastest < 10.5


def test_late_poses_swing_more(hovering, follow):
    """Beside 8 ms: 150 ms more let the position loop swing after a kick; 18.15: 15 ms change hover hardly."""

    def swing(extra):
        world = hovering(settle=3.0)
        drone = world.drones[0]
        if extra:
            world.add_fault(PositioningFault(at=world.time, delay=extra))
        world.add_fault(Kick(at=world.time + 0.5, impulse=(0.015, 0.0, 0.0)))
        world.run(1.5)
        places = np.array(follow(world, 3.0, lambda: drone.true_position[0]))
        assert drone.is_flying
        return np.sqrt(np.mean((places - places.mean()) ** 2))

    usual, slightly, very = swing(0.0), swing(0.007), swing(0.15)
    assert slightly < 1.5 * usual
    assert very > 2.0 * usual


# ---------------------------------------------------------------- radio


def test_silent_radio_levels_out_after_half_a_second_and_ends_the_flight_after_two(hovering, follow):
    """8.3, 14.5: the first updates after 0.5 s and 2.0 s of silence, 40 ms apart; then locked."""
    world = hovering()
    drone = world.drones[0]
    hold = lambda: drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 1.0)
    follow(world, 2.0, lambda: None, each=hold)
    begin = world.time
    world.add_fault(RadioFault(at=begin, loss=1.0, poses=False))
    entered, last = [], drone.supervisor_state
    for _ in range(2300):
        hold()
        world.step(1)
        if drone.supervisor_state != last:
            last = drone.supervisor_state
            entered.append((world.time - begin, last))
    assert [state for _, state in entered] == ["Warning, level out", "Exception, free fall", "Locked"]
    assert entered[0][0] == pytest.approx(0.5, abs=0.06)
    assert entered[1][0] == pytest.approx(2.0, abs=0.06)
    assert entered[2][0] - entered[1][0] == pytest.approx(0.04, abs=1e-6)
    assert drone.is_locked


def test_drone_flies_on_when_the_radio_speaks_again_in_time(hovering, follow):
    world = hovering()
    drone = world.drones[0]
    hold = lambda: drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 1.0)
    follow(world, 2.0, lambda: None, each=hold)
    world.add_fault(RadioFault(at=world.time, loss=1.0, duration=1.2))
    seen = follow(world, 3.0, lambda: drone.supervisor_state, each=hold)
    assert "Warning, level out" in seen
    assert seen[-1] == "Flying"
    assert drone.true_position[2] == pytest.approx(1.0, abs=0.1)


def test_planned_flight_goes_on_without_radio(hovering):
    """7.4: setpoints of the high-level commander are made on board and never too old."""
    world = hovering(settle=3.0)
    drone = world.drones[0]
    drone.high_level_commander.go_to(0.6, 0.0, 1.0, 0.0, 2.0)
    world.add_fault(RadioFault(at=world.time + 0.1, loss=1.0, poses=False))
    world.run(4.0)
    assert drone.supervisor_state == "Flying"
    assert drone.true_position[0] == pytest.approx(0.6, abs=0.05)


# ---------------------------------------------------------------- battery


@pytest.mark.parametrize(("platform", "limit"), [("cf2", 3.2), ("cf21bl", 3.35)])
def test_low_battery_is_told_after_five_seconds(platform, limit):
    """docs/reference/control-pid.md#12: below 3.2 V (3.35 V) for 5 s; pm.state 3 is low power."""
    world = World([DroneConfig("cf1", platform=platform)], seed=1, visuals=False)
    drone = world.drones[0]
    world.wait_until_ready()
    assert drone.log["pm.state"] == 0
    start = world.time
    world.add_fault(BatteryFault(at=start, charge=0.0))
    low = None
    for _ in range(700):
        world.step(10)
        if low is None and drone.log["pm.state"] == 3:
            low = world.time - start
    assert drone.log["pm.vbat"] < limit
    assert drone.log["pm.batteryLevel"] == 0
    # judged now and then
    assert low == pytest.approx(5.0, abs=0.6)


def test_empty_battery_ends_the_flight(hovering):
    """docs/reference/vehicle.md#6: below zero charge the voltage is too low to carry the drone."""
    world = hovering()
    drone = world.drones[0]
    world.add_fault(BatteryFault(at=world.time, charge=0.0))
    world.run(20.0)
    # it sinks, or lies on the floor with full motors
    assert drone.true_position[2] < 0.3
    assert drone.battery_voltage < 3.2


def test_bad_contact_sags_by_its_resistance_times_the_current(hovering):
    world = hovering(battery=1.0)
    drone = world.drones[0]
    before = drone.battery_voltage
    current = drone.struct.vehicle.battery.current
    world.add_fault(BatteryFault(at=world.time, resistance=0.1, duration=1.0))
    world.run(0.5)
    assert drone.is_flying
    # less voltage for the same power is more current, which also falls off inside of the cell
    now, inside = drone.struct.vehicle.battery.current, drone.struct.config.vehicle.airframe.battery.resistance
    assert before - drone.battery_voltage == pytest.approx(0.1 * now + inside * (now - current), abs=0.02)
    world.run(1.0)
    assert drone.battery_voltage == pytest.approx(before, abs=0.05)


def test_cut_battery_ends_the_software_and_a_reboot_brings_it_back(hovering):
    world = hovering()
    drone = world.drones[0]
    world.add_fault(BatteryFault(at=world.time + 0.1, cut=True, duration=3.0))
    world.run(1.0)
    assert drone.failure == f"cf1: the battery was cut (at {drone.struct.onboard.fault_tick / 1000:.3f} s)"
    assert drone.battery_voltage == 0.0
    assert max(drone.struct.vehicle.rotors.rpm) < 1.0
    assert drone.true_position[2] < 0.5
    drone.reboot()
    world.run(0.1)
    assert drone.failure is not None  # still without power
    world.run(3.0)
    assert drone.battery_voltage > 3.5
    assert drone.failure is not None
    drone.place((0.0, 0.0, 0.02))
    drone.reboot()
    world.run(2.5)
    assert drone.failure is None
    assert drone.can_fly


# ---------------------------------------------------------------- kicks, gusts, payloads


def test_kick_gives_the_velocity_of_its_impulse_and_the_drone_recovers(hovering, follow):
    world = hovering()
    drone = world.drones[0]
    mass = world.model.body("cf1").mass[0]
    before = drone.true_velocity
    world.add_fault(Kick(at=world.time, impulse=(0.02, -0.01, 0.0)))
    assert drone.true_velocity - before == pytest.approx([0.02 / mass, -0.01 / mass, 0.0], abs=1e-9)
    places = follow(world, 5.0, lambda: horizontal(drone))
    assert 0.1 < max(places) < 1.0
    assert drone.supervisor_state == "Flying"
    assert max(places[-50:]) < 0.05


def test_kick_off_the_center_turns_the_drone(hovering):
    world = hovering()
    drone = world.drones[0]
    body = world.model.body("cf1")
    impulse, point = np.array([0.0, 0.0, 0.0005]), np.array([0.03, -0.02, 0.0])
    before = drone.true_rates.copy()
    world.add_fault(Kick(at=world.time, impulse=tuple(impulse), point=tuple(point), frame="body"))
    # the change of the angular momentum about the center of mass is the moment of the impulse
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, body.iquat)
    inertia = axes.reshape(3, 3) @ np.diag(body.inertia) @ axes.reshape(3, 3).T
    momentum = inertia @ (drone.true_rates - before)
    assert momentum == pytest.approx(np.cross(point - body.ipos, impulse), rel=1e-6, abs=1e-12)
    world.run(3.0)
    assert drone.supervisor_state == "Flying"
    assert horizontal(drone) < 0.1


def test_gust_pushes_as_drag_does_and_passes(hovering, follow):
    """Acceleration drag v / m at its height; the drone leans into the wind and comes back.

    docs/reference/vehicle.md#7.
    """
    world = hovering()
    drone = world.drones[0]
    world.add_fault(Gust(at=world.time, velocity=(3.0, 0.0, 0.0), duration=1.0))
    seen = follow(world, 1.0, lambda: (drone.true_position[0], drone.struct.vehicle.wind.velocity[0]))
    winds = [wind for _, wind in seen]
    assert max(winds) == pytest.approx(3.0, abs=0.01)
    assert winds[-1] == pytest.approx(0.0, abs=1e-4)
    assert winds[24] == pytest.approx(1.5, abs=0.02)  # a quarter of the time
    assert max(place for place, _ in seen) > 0.02
    world.run(4.0)
    assert horizontal(drone) < 0.05
    assert list(drone.struct.vehicle.wind.velocity) == pytest.approx([0.0] * 3, abs=1e-6)


PAYLOAD = 0.004  # kg

LOADED = f"""
<mujoco>
  <option timestep="0.001" gravity="0 0 -9.81"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="load" pos="0 0 0.04">
      <freejoint/>
      <geom type="sphere" size="0.005" mass="{PAYLOAD}" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <equality>
    <weld name="cf1/payload" body1="cf1" body2="load"/>
  </equality>
</mujoco>
"""


def test_payload_drop_lets_the_drone_jump_up_and_come_back(tmp_path, follow):
    """Thrust for 5 g too much: 1.7 m/s^2 at once; the integrator of the height takes seconds."""
    scene = tmp_path / "loaded.xml"
    scene.write_text(LOADED)
    world = World([DroneConfig("cf1")], scene=scene, seed=1, visuals=False)
    drone = world.drones[0]
    world.wait_until_ready()
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(10.0)
    loaded = drone.log["stabilizer.thrust"]
    hovers_at = drone.true_position[2]
    world.add_fault(PayloadDrop(at=world.time))
    heights = follow(world, 8.0, lambda: drone.true_position[2])
    assert world.data.eq_active.tolist() == [0]
    assert 0.02 < max(heights) - hovers_at < 0.4
    assert heights[-1] == pytest.approx(hovers_at, abs=0.04)
    mass = world.model.body("cf1").mass[0]
    assert drone.log["stabilizer.thrust"] / loaded == pytest.approx(mass / (mass + PAYLOAD), rel=0.08)
