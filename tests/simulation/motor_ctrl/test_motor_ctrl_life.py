"""The life of a motor control: rate, keep-alive, stop, safe zone, failure, reset, snapshots."""

import inspect

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.simulation import (
    DroneConfig,
    MotorCtrl,
    MotorCtrlFPQR,
    MotorCtrlVel,
    MotorCtrlXYZ,
    World,
    set_threads,
)


class Climb(MotorCtrlVel):
    """Rises to a height and stays there."""

    def init(self, drone, properties):
        self.height = float(properties.get("height", 0.4))
        self.ticks = []

    def step(self):
        self.ticks.append(self.world.tick)
        self.command(0.0, 0.0, 0.8 * (self.height - self.position[2]))


class Once(MotorCtrlVel):
    """Commands once, and leaves the rest to the keep-alive."""

    def step(self):
        if self.drone.struct.onboard.client_setpoint.timestamp == 0:
            self.command(0.0, 0.0, 0.3)


class Brief(Once):
    keep_alive_s = 0.3


class Clumsy(Climb):
    """Divides by zero after 2.2 s."""

    def step(self):
        super().step()
        if self.time > 2.2:
            self.command(1 / 0, 0.0, 0.0)


def world_of(*classes, **options):
    drones = [DroneConfig(f"cf{i + 1}", (0.6 * i, 0.0), motor_ctrl=cls, **options) for i, cls in enumerate(classes)]
    return World(drones, seed=2)


def ready(*classes, **options):
    world = world_of(*classes, **options)
    world.wait_until_ready()
    return world


@pytest.mark.parametrize("rate", [10, 100, 1000])
def test_steps_come_at_the_rate_of_the_class_once_motors_may_run(rate):
    cls = type("Rated", (Climb,), {"rate_hz": rate})
    world = world_of(cls)
    world.run(2.0)
    ticks = world.drones[0].motor_ctrl.ticks
    assert set(np.diff(ticks)) == {1000 // rate}
    assert all(tick % (1000 // rate) == 0 for tick in ticks)
    assert 1500 < ticks[0] < 1800
    assert world.drones[0].motor_ctrl.dt == 1 / rate


@pytest.mark.parametrize("rate", [0, 3, 2000, 50.0, True])
def test_other_rates_are_refused(rate):
    with pytest.raises(RangeError, match=r"cf1: Rated: rate_hz is .*, allowed: a divisor of 1000"):
        world_of(type("Rated", (Climb,), {"rate_hz": rate}))


def test_a_drone_that_must_be_armed_is_armed():
    world = world_of(Climb, platform="cf21bl")
    world.run(4.0)
    assert world.drones[0].is_flying


def test_the_last_command_is_repeated():
    world = ready(Once)
    world.run(3.0)
    assert world.drones[0].supervisor_state == "Flying"
    assert world.drones[0].true_velocity[2] == pytest.approx(0.3, abs=0.03)


def test_the_watchdog_takes_over_where_the_keep_alive_ends():
    world = ready(Brief)
    world.run(0.3 + 0.7)
    assert world.drones[0].supervisor_state == "Warning, level out"
    world.run(2.0)
    assert world.drones[0].is_locked


def test_another_client_may_take_over():
    world = ready(MotorCtrlVel)
    world.drones[0].motor_ctrl.command(0.0, 0.0, 0.3)
    world.run(1.0)
    world.drones[0].commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.3)
    world.run(0.4)
    assert world.drones[0].struct.onboard.client_setpoint.mode.z == 1


def test_stop_is_latched_until_resume():
    world = ready(Climb)
    drone = world.drones[0]
    world.run(2.0)
    drone.motor_ctrl.stop()
    world.run(3.0)
    assert drone.motor_ctrl.is_stopped
    assert not any(drone.motor_ctrl.motor_ratios)
    assert not drone.is_locked
    assert [event.kind for event in world.events if event.kind != "collision"] == ["stop"]
    drone.motor_ctrl.resume()
    world.run(3.0)
    assert not drone.motor_ctrl.is_stopped
    assert drone.true_position[2] > 0.2


def test_a_stopped_brushless_drone_stands_still_and_flies_again():
    world = ready(Climb, platform="cf21bl")
    drone = world.drones[0]
    world.run(0.3)
    drone.motor_ctrl.stop()
    world.run(2.0)
    assert not any(drone.motor_ctrl.motor_ratios)
    drone.motor_ctrl.resume()
    world.run(3.0)
    assert drone.true_position[2] > 0.2


def test_go_to_works_again_after_a_stop():
    world = ready(MotorCtrlXYZ)
    control = world.drones[0].motor_ctrl
    control.command(0.0, 0.0, 0.3, 1.0)
    world.run(0.5)
    control.stop()
    control.command(0.0, 0.0, 0.9, 1.0)  # dropped
    world.run(2.5)
    assert control.position[2] < 0.05
    control.resume()
    world.run(4.0)  # 3 s after a landing the supervisor resets, and drops plans
    assert control.drone.can_fly
    control.command(0.0, 0.0, 0.4, 1.5)
    world.run(3.0)
    assert control.position[2] == pytest.approx(0.4, abs=0.08)


@pytest.mark.parametrize("by_property", [False, True])
def test_leaving_the_safe_zone_stops_the_drone(by_property):
    zone = None if by_property else ((-1, -1, -0.1), (1, 1, 0.3))
    cls = type("Fenced", (Climb,), {"safe_zone": zone})
    properties = {"safe_zone": "-1,-1,-0.1,1,1,0.3"} if by_property else {}
    world = ready(cls, motor_ctrl_properties=properties)
    world.run(4.0)
    assert world.drones[0].motor_ctrl.is_stopped
    assert [event.kind for event in world.events if event.kind != "collision"] == ["safe_zone", "stop"]
    assert world.events[0].details["position"][2] == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize(
    "zone", [((0, 0, 0), (1, 1)), "a box", ((1, 1, 1), (0, 0, 0)), ((0, 0, 0), (1, 1, float("nan")))]
)
def test_a_safe_zone_is_a_finite_box(zone):
    with pytest.raises(RangeError, match="cf1: Fenced: safe_zone is .*, allowed: lowest and highest corner"):
        world_of(type("Fenced", (Climb,), {"safe_zone": zone}))


def test_a_class_that_raises_stops_its_own_drone_only():
    world = ready(Clumsy, Climb)
    world.run(2.0)
    clumsy, other = world.drones
    line = inspect.getsourcelines(Clumsy.step)[1] + 3
    assert clumsy.failure == (
        "cf1: its motor control failed: Clumsy: ZeroDivisionError: division by zero "
        f"(test_motor_ctrl_life.py:{line}) (at 2.210 s)"
    )
    assert not any(clumsy.motor_ctrl.motor_ratios)
    assert clumsy.is_locked
    assert [(event.kind, event.drone) for event in world.events if event.kind == "failure"] == [("failure", "cf1")]
    assert "ZeroDivisionError" in world.events[0].details["reason"]
    assert other.is_flying
    assert other.failure is None


def test_nobody_waits_for_a_drone_that_was_failed_by_its_class():
    cls = type("Dead", (MotorCtrl,), {"step": lambda self: self.nothing})
    world = ready(cls, Climb)
    world.run(3.0)
    assert "AttributeError" in world.drones[0].failure
    assert world.drones[1].true_position[2] > 0.2


def test_a_bad_command_fails_with_drone_value_and_range():
    cls = type("Dizzy", (MotorCtrlFPQR,), {"step": lambda self: self.command(0.2, float("nan"), 0, 0)})
    world = ready(cls)
    world.run(0.1)
    assert "RangeError: cf1: Dizzy: command: p is nan, allowed: a finite number" in world.drones[0].failure


def test_a_class_that_cannot_begin_makes_no_world():
    def init(self, drone, properties):
        properties["height"]

    with pytest.raises(
        StateError, match=r"cf1: Unready.init failed: KeyError: 'height' \(test_motor_ctrl_life.py:\d+\)"
    ):
        world_of(type("Unready", (MotorCtrl,), {"init": init}))


def test_a_reset_world_begins_again():
    world = ready(Climb, Clumsy)
    world.run(2.0)
    memory = world.drones[0].memory.copy()
    world.reset()
    assert world.drones[0].motor_ctrl.ticks == []
    assert world.drones[1].failure is None
    world.wait_until_ready()
    world.run(2.0)
    assert (world.drones[0].memory == memory).all()


def test_a_restored_world_flies_on_with_the_same_bits():
    world = ready(Once, Climb)
    world.run(0.512)
    world.drones[1].motor_ctrl.stop()
    snapshot = world.snapshot()
    world.run(0.7)
    expected = world.snapshot()
    # what Python remembers of the last command must not matter
    world.drones[0].motor_ctrl.command(0.5, 0.5, 0.5)
    world.drones[1].motor_ctrl.resume()
    world.run(0.3)
    world.restore(snapshot)
    world.run(0.7)
    assert world.snapshot().tobytes() == expected.tobytes()


def test_threads_change_nothing():
    ends = []
    for threads in (1, 2, 3):
        set_threads(threads)
        world = ready(Climb, Once, Climb)
        world.run(0.6)
        ends.append(world.snapshot())
    assert ends[0].tobytes() == ends[1].tobytes() == ends[2].tobytes()


def test_what_was_heard_of_it_flies_another_drone_alike():
    """A journal of the uplink replays the flight without the class."""
    world = world_of(Climb)
    heard = []
    world.drones[0].uplink.listeners.append(lambda verb, arguments: heard.append((world.tick, verb, arguments)))
    world.run(2.5)
    replay = World([DroneConfig("cf1")], seed=2)
    for tick, verb, arguments in heard:
        replay.agenda.at(
            tick, lambda verb=verb, arguments=arguments: replay.drones[0].uplink.dispatch(verb, *arguments)
        )
    replay.run(2.5)
    assert {verb for _, verb, _ in heard} == {"setpoint"}
    assert replay.data.qpos.tolist() == world.data.qpos.tolist()
