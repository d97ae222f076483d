"""Snapshots from files whose numbers were tampered with: refused with the member's name, or flown without harm."""

import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import DroneConfig, Snapshot, World
from crazychoir_fw.simulation.state_rules import fields

POSITIONING = ("mocap", "flow", "lighthouse", "loco_twr", "loco_tdoa2", "loco_tdoa3")
KINDS = [{"positioning": word} for word in POSITIONING]
KINDS += [{"estimator": "complementary"}, {"platform": "cf21bl", "controller": "lee"}]


def flying(**settings):
    world = World([DroneConfig("cf1", **settings)], seed=3, visuals=False)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(0.5, 1.0)
    world.run(1.3)
    return world


def tampered(world, tmp_path, change):
    """Return the snapshot of a world, as read from a file in which the memory of its drone was changed."""
    drone = world.drones[0]
    before = drone.memory.copy()
    change(drone.memory)
    world.snapshot().save(tmp_path / "here.npz")
    drone.memory[:] = before
    return Snapshot.load(tmp_path / "here.npz")


@pytest.mark.parametrize("settings", KINDS, ids=str)
def test_what_flies_is_within_the_rules(settings, tmp_path):
    world = flying(**settings)
    world.snapshot().save(tmp_path / "here.npz")
    other = World([DroneConfig("cf1", **settings)], seed=3, visuals=False)
    other.restore(Snapshot.load(tmp_path / "here.npz"))
    assert other.snapshot().tobytes() == world.snapshot().tobytes()


def checked(path):
    return next(field for field in fields() if field.path == path)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("vehicle.mocap.oldest", 40),
        ("vehicle.mocap.waiting", 2**31),
        ("onboard.estimator.queue_count", 21),
        ("onboard.sensors.gyro_bias.next", -1),
        ("onboard.sensors.gyro_bias.next", 512),
        ("onboard.health.motor", 4),
        ("onboard.controller_type", lib.ControllerTypeOot),
        ("onboard.estimator.type", lib.StateEstimatorTypeOutOfTree),
        ("onboard.supervisor.state", 99),
        ("has_last_velocity", 2),
        ("provider_state.planner.source", 7),
    ],
)
def test_a_number_that_leads_astray_is_refused_by_name(path, value, tmp_path):
    world = flying()
    state = world.snapshot().tobytes()

    def change(memory):
        checked(path).read(memory)[...] = value

    with pytest.raises(RangeError, match=f"cf1: the snapshot is damaged: {path} is {value}, allowed: "):
        world.restore(tampered(world, tmp_path, change))
    assert world.snapshot().tobytes() == state


def test_plans_outside_the_trajectory_memory_are_refused(tmp_path):
    world = flying()
    field = checked("provider_state.planner.n_pieces")
    with pytest.raises(RangeError, match="the plan has 31 pieces, allowed: 1"):
        world.restore(tampered(world, tmp_path, lambda memory: field.read(memory).fill(31)))

    def define(memory):
        definition = world.drones[0].struct.onboard.high_level.definitions[3]
        definition.location, definition.offset, definition.n_pieces = lib.CF_TRAJECTORY_LOCATION_MEMORY, 4000, 1

    with pytest.raises(RangeError, match="trajectory 3 lies at 4000 with 132 bytes, allowed: within 4096"):
        world.restore(tampered(world, tmp_path, define))


def test_a_sweep_of_a_station_that_is_not_there_is_refused(tmp_path):
    """It would be measured by a function at an address that the file names."""
    world = flying(positioning="lighthouse")

    def enqueue(memory):
        estimator = world.drones[0].struct.onboard.estimator
        estimator.queue_count = 1
        estimator.queue[0].type = lib.MeasurementTypeSweepAngle
        estimator.queue[0].data.sweepAngle.baseStationId = 9

    with pytest.raises(RangeError, match=r"queue\[0\] is no sweep of a station"):
        world.restore(tampered(world, tmp_path, enqueue))


@pytest.mark.parametrize("settings", KINDS, ids=str)
def test_bytes_at_random_are_refused_or_flown(settings, tmp_path):
    world = flying(**settings)
    rng = np.random.default_rng(11)
    snapshot = world.snapshot()
    refused = 0
    for _ in range(60):

        def scramble(memory):
            places = rng.integers(0, len(memory), rng.choice([1, 4, 64]))
            memory[places] = rng.integers(0, 256, len(places))

        try:
            world.restore(tampered(world, tmp_path, scramble))
        except RangeError:
            refused += 1
        else:
            world.run(0.05)
        world.restore(snapshot)
    assert 0 < refused < 60


def test_the_memory_of_another_platform_is_refused():
    one, other = World([DroneConfig("cf1")]), World([DroneConfig("cf1", platform="cf21bl")])
    with pytest.raises(RangeError, match="cf1: the snapshot is one of provider 0 and platform 1, allowed: 0 and 0"):
        one.drones[0].restore(other.drones[0].snapshot())


def test_every_integer_of_a_drone_has_a_rule(monkeypatch):
    """`fields` raises for a member that has none; without the rule of one, that one is named."""
    from crazychoir_fw.simulation import state_rules

    rules = tuple(rule for rule in state_rules._RULES if rule[0] != "vehicle.mocap.oldest")
    monkeypatch.setattr(state_rules, "_RULES", rules)
    with pytest.raises(Exception, match=r"the member vehicle\.mocap\.oldest of a drone's memory has no rule"):
        state_rules.fields.__wrapped__()


@pytest.mark.parametrize("time", [np.inf, np.nan, -1.0, 1e300])
def test_a_time_that_no_world_has_is_refused(time, tmp_path):
    world = flying()
    world.snapshot().save(tmp_path / "here.npz")
    good = Snapshot.load(tmp_path / "here.npz")
    state = good.state.copy()
    state[0] = time  # as `mj_getState` orders it
    before = world.snapshot().tobytes()
    with pytest.raises(RangeError, match=r"damaged: its time is .* s, allowed: 0 to 1e\+09 s"):
        world.restore(Snapshot(state, good.beside, good.fingerprint, good.time, is_trusted=False))
    assert world.snapshot().tobytes() == before
