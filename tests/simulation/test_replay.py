"""A flight can be flown again from its journal, to the last bit; where it cannot, that is said."""

import dataclasses
import json

import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation import DroneConfig, Episodes, FlightRecorder, World, replay
from crazychoir_fw.simulation.replay import ReplayError, compare

EMPTY_SCENE = '<mujoco><worldbody><geom type="plane" size="5 5 {}"/></worldbody></mujoco>'


def everything(world, recorder):
    """A flight with every kind of request."""
    world.wait_until_ready()
    first, second, third = world.drones
    first.high_level_commander.takeoff(0.5, 1.0)
    second.high_level_commander.takeoff(0.6, 1.0, yaw=None)
    with pytest.raises(StateError):
        second.high_level_commander.takeoff(0.6, 1.0)  # a refusal is part of the flight
    start, segment = CompressedStart(0.0, 0.0, 0.5, 0.0), CompressedSegment(0.5, [0.1], [], [0.7], [])
    first.high_level_commander.upload_compressed_trajectory(1, start, [segment])
    third.param.set_value("pid_rate.roll_kp", "240")
    recorder.run(1.1)
    first.high_level_commander.start_trajectory(1, relative_position=True)
    second.high_level_commander.spiral(1.0, 0.1, 0.2, 0.1, 1.0)
    third.receive_packet(8, 0, bytes([7, 0, 0, 0, 0, 63, 0, 0, 0, 0, 0, 0, 0, 128, 63]))
    for i in range(40):
        first.send_extpose(0.0, 0.001 * i, 0.5, 0.0, 0.0, 0.0, 1.0)
        second.loc.send_extpos([0.5, 0.0, 0.6])
        third.commander.send_full_state_setpoint((1.0, 0.0, 0.4), (0, 0, 0), (0, 0, 0), (0, 0, 0, 1), 0, 0, 0.1)
        recorder.run(0.01)
    first.commander.send_position_setpoint(np.float32(0.1), 0, 0.6, 10)
    second.reboot()
    third.place((1.0, 0.5, 0.5), 20.0)
    recorder.run(0.1)
    third.loc.send_emergency_stop_watchdog()
    world.note("gust", "cf1", speed=3.5)
    recorder.run(0.2)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The file of a flight with every kind of request."""
    world = make_world(3, seed=6, threads=1)
    world.note("start")
    recorder = FlightRecorder(world)
    everything(world, recorder)
    path = tmp_path_factory.mktemp("flight") / "log.npz"
    recorder.finish({"mission": "everything"}).save(path)
    return path


@pytest.fixture
def log(recorded):
    return FlightLog.load(recorded)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_replay_has_the_same_bits(log, threads):
    flown = replay(log, threads=threads)
    assert flown.deviation is None
    assert flown.warnings == ()
    assert flown.log.signals.keys() == log.signals.keys()
    assert all(flown.log.signals[name].tobytes() == samples.tobytes() for name, samples in log.signals.items())
    assert list(flown.world.journal) == list(log.journal)


def test_the_replay_of_a_replay_too(log, tmp_path):
    flown = replay(log)
    flown.log.save(tmp_path / "log.npz")
    assert replay(tmp_path).deviation is None


def test_the_first_tick_drone_and_signal_of_a_difference_are_named(log):
    for sample, drone, name in (
        (150, 2, "pm.vbat"),
        (120, 1, "stateEstimate.z"),
        (120, 1, "gyro.x"),
        (120, 2, "acc.x"),
    ):
        bits = log.signals[name].view(np.uint32)
        bits[sample, drone] ^= 1
    flown = replay(log)
    deviation = flown.deviation
    assert deviation.tick == round(log.time[120] * 1000)
    assert deviation.drone == "cf2"
    assert set(deviation.signals) == {"stateEstimate.z", "gyro.x"}
    assert f"at tick {deviation.tick} cf2 " in str(deviation)
    assert deviation.recorded == pytest.approx(deviation.replayed, rel=1e-5)
    assert deviation.recorded != deviation.replayed


def test_a_request_that_is_missing_is_noticed(log):
    arrays = log.journal.to_arrays()
    verbs = [request.verb for request in log.journal]
    spiral = verbs.index("cf_spiral")
    journal = Journal(log.journal.recipe)
    for i, request in enumerate(log.journal):
        if i != spiral:
            journal.add(*request)
    journal.samples = [count - (count > spiral) for count in log.journal.samples]
    deviation = replay(dataclasses.replace(log, journal=journal)).deviation
    assert deviation.drone == "cf2"
    assert deviation.tick > 1000 * log.time[0]
    assert arrays["samples"][-1] == len(journal) + 1


def test_plugins_are_in_the_journal_and_do_not_run_again(monkeypatch):
    runs = []
    world = make_world(1, seed=3)
    world.wait_until_ready()
    drone = world.drones[0]

    def plugin():
        runs.append(world.tick)
        drone.commander.send_hover_setpoint(0.1 * np.sin(world.time), 0.0, 0.0, 0.4)

    cancel = world.agenda.every(10, plugin)
    recorder = FlightRecorder(world)
    recorder.run(1.0)
    cancel()
    assert len(runs) == 100
    flown = replay(recorder.finish())
    assert flown.deviation is None
    assert len(runs) == 100
    assert flown.world.is_replay
    assert not world.is_replay


def test_a_replay_does_without_the_classes_that_flew_and_does_not_miss_them():
    world = World([DroneConfig("cf1", motor_ctrl="MotorCtrlXYZ", motor_ctrl_properties={"a": 1})], seed=3)
    recorder = FlightRecorder(world)
    world.wait_until_ready()
    world["cf1"].motor_ctrl.command(0.0, 0.0, 0.5, 1.0)
    recorder.run(0.5)
    flown = replay(recorder.finish())
    assert flown.deviation is None
    assert flown.warnings == ()


def test_requests_between_two_samples_come_at_their_ticks():
    world = make_world(1, seed=3)
    recorder = FlightRecorder(world, rate_hz=10)
    world.wait_until_ready()
    for tick in (3, 17, 31):
        world.step(tick)
        world.drones[0].commander.send_hover_setpoint(0.1, 0.0, tick, 0.4)
    recorder.run(0.3)
    log = recorder.finish()
    flown = replay(log)
    assert flown.deviation is None
    assert list(flown.world.journal) == list(log.journal)


def test_what_an_agenda_requests_with_a_handler_of_its_own_is_carried_out_once(monkeypatch):
    """As faults do: their verbs have handlers in every world, and a replay is given no faults."""
    set_up = World._set_up

    def with_handler(self, *arguments):
        set_up(self, *arguments)
        for drone in self.drones:
            drone.uplink.handle("kick", lambda speed, drone=drone: drone._qvel.__setitem__(slice(3), speed))

    monkeypatch.setattr(World, "_set_up", with_handler)
    world = make_world(2, seed=3)
    recorder = FlightRecorder(world)
    world.agenda.at(250, lambda: world.drones[1].uplink.dispatch("kick", [0.0, 0.0, 1.5]))
    recorder.run(0.5)
    log = recorder.finish()
    assert log.signals["sim.z"][:, 1].max() > 0.1
    assert replay(log).deviation is None


def test_forks_snapshots_and_episodes_are_replayed_from_the_start(tmp_path):
    world = make_world(2, seed=3)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(0.5, 1.0)
    world.run(0.5)
    here = world.snapshot()
    (fork,) = world.fork()
    episodes = Episodes(world, 2, 1)
    episodes.drones(1)[1].high_level_commander.takeoff(0.7, 1.0)
    episodes.run(0.3)
    world.run(1.0)
    world.restore(episodes.snapshot(1))
    for flight in (fork, world):
        recorder = FlightRecorder(flight)
        flight.drones[1].high_level_commander.go_to(0.4, 0.4, 0.4, 0.0, 1.0)
        recorder.run(0.5)
        assert replay(recorder.finish()).deviation is None
    world.restore(here)
    recorder = FlightRecorder(world)
    recorder.run(0.1)
    assert replay(recorder.finish()).deviation is None


def test_a_reset_world_has_a_journal_of_its_own():
    world = make_world(1, seed=3)
    world.drones[0].param["pid_rate.roll_kp"] = 200.0
    world.run(0.1)
    world.reset()
    assert len(world.journal) == 0
    recorder = FlightRecorder(world)
    recorder.run(0.1)
    assert replay(recorder.finish()).deviation is None


def test_configurations_are_rebuilt(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(EMPTY_SCENE.format(1))
    configs = [
        DroneConfig("a", (0, 0), yaw_deg=30, mass=0.035, controller="mellinger", noise=0.5, battery=0.8),
        DroneConfig("b", (1.0, 0.0, 0.4), platform="cf21bl", positioning="lighthouse", parameters={"colAv.enable": 1}),
        DroneConfig("c", np.array([2.0, 0.0]), color=(1, 0, 0), attributes={"mocap_noise": 0.002}),
    ]
    world = World(configs, scene=scene, seed=12)
    recorder = FlightRecorder(world, rate_hz=50)
    world.wait_until_ready()
    recorder.run(0.2)
    log = recorder.finish()
    json.dumps(log.journal.recipe)
    flown = replay(log)
    assert flown.deviation is None
    assert flown.warnings == ()

    scene.write_text(EMPTY_SCENE.format(2))
    flown = replay(log)
    assert flown.warnings[0] == f"the scene {scene} has changed since the flight"
    assert "has another scene or other vehicles" in flown.warnings[1]
    scene.unlink()
    with pytest.raises(ReplayError, match="is gone"):
        replay(log)


def test_another_version_is_said_before_the_flight(log):
    log.metadata["mujoco"] = "3.9.9"
    log.journal.recipe["fingerprint"]["providers"] = "builtin 0.0.1"
    said = []
    flown = replay(log, warn=said.append)
    assert said == list(flown.warnings)
    assert said[0].startswith("recorded with mujoco 3.9.9, this is ")
    assert said[1].startswith("the recorded world has other onboard software: builtin 0.0.1, here flies builtin ")
    assert flown.deviation is None


def _without_journal(log):
    log.journal = None


def _with_gap(log):
    log.journal.gap = "'restore' at 1.500 s carries a DroneSnapshot"


def _of_another_flight(log):
    log.journal.samples = log.journal.samples[:-1]


def _with_an_unknown_verb(log, verb="cf_teleport", arguments=(1.0,)):
    log.journal.add(10_000, 0, verb, arguments)
    log.journal.samples[-1] += 1
    log.time[-1] = 10.0


def _with_a_function_that_is_no_request(log):
    _with_an_unknown_verb(log, "cf_refresh_logs", (1000, 4096))


def _with_more_bytes_than_there_are(log):
    _with_an_unknown_verb(log, "cf_write_trajectory", (0, 4000, b"few"))


def _with_an_incomplete_vector(log):
    _with_an_unknown_verb(log, "cf_inject_gust", ([1.0], 100))


def _with_another_drone(log):
    log.journal.add(10_000, 7, "cf_stop", ())


def _with_an_unknown_field(log):
    log.journal.recipe["drones"][1]["wings"] = 2


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (_without_journal, "has no journal"),
        (_with_gap, "has a gap: 'restore' at 1.500 s"),
        (_of_another_flight, "not of the same flight"),
        (_with_an_unknown_verb, "asks for 'cf_teleport' at 10.000 s, which this version does not understand"),
        (_with_a_function_that_is_no_request, "asks for 'cf_refresh_logs' at 10.000 s, which this version does not"),
        (_with_more_bytes_than_there_are, "asks for 'cf_write_trajectory' at 10.000 s, which this version does not"),
        (_with_an_incomplete_vector, "asks for 'cf_inject_gust' at 10.000 s, which this version does not"),
        (_with_another_drone, "names drones that the log does not have"),
        (_with_an_unknown_field, "cf2: this version knows nothing of wings"),
    ],
)
def test_what_cannot_be_replayed_says_why(log, spoil, says):
    spoil(log)
    with pytest.raises(CrazychoirError, match=says):
        replay(log)


def test_a_drone_that_was_restored_leaves_a_gap():
    world = make_world(1)
    recorder = FlightRecorder(world)
    drone = world.drones[0]
    drone.restore(drone.snapshot())
    recorder.run(0.1)
    with pytest.raises(ReplayError, match="'restore' at 0.000 s"):
        replay(recorder.finish())


@pytest.mark.parametrize("back", ["stay", "reset", "restore", "fork"])
def test_a_world_without_a_journal_is_not_replayed(back):
    world = World([DroneConfig("cf1")], visuals=False)
    world["cf1"].param["ring.effect"] = 3
    before = world.snapshot()
    world.stop_journal("the drones were served")
    if back == "reset":
        world.reset()
    elif back == "restore":
        world.restore(before)
    elif back == "fork":
        (world,) = world.fork()
    recorder = FlightRecorder(world)
    world["cf1"].param["ring.effect"] = 5
    recorder.run(0.02)
    assert len(world.journal) == 0
    with pytest.raises(ReplayError, match="the journal has a gap: the drones were served"):
        replay(recorder.finish())


def test_a_world_that_went_back_in_time_while_it_was_recorded_leaves_a_gap():
    world = make_world(1)
    recorder = FlightRecorder(world)
    here = world.snapshot()
    recorder.run(0.1)
    world.restore(here)
    world.run(0.1)
    recorder.run(0.1)
    with pytest.raises(ReplayError, match="taken back in time"):
        replay(recorder.finish())


def test_records_of_other_shapes_differ(log):
    other = dataclasses.replace(log, signals=dict(list(log.signals.items())[1:]))
    assert compare(log, other).signals == (next(iter(log.signals)),)
    assert compare(log, dataclasses.replace(log, drone_ids=["x", "y", "z"])).signals == ("drones",)
    later = dataclasses.replace(log, time=log.time + 0.001)
    assert compare(log, later).signals == ("time",)
    assert compare(log, dataclasses.replace(log)) is None
