"""How a mission is flown and abandoned, in a world whose drones are where their commands put them at once."""

from types import SimpleNamespace

import numpy as np
import pytest

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.simulation import DroneConfig

READY_AT = 1.5  # [s]


class ObedientDrone:
    """Carries out a command at once, and remembers it."""

    def __init__(self, world, name, position):
        self.world = world
        self.id = name
        self.position = np.array([*position, 0.0])
        self.high_level_commander = self
        self.can_fly = self.can_arm = True
        self.motor_ctrl = None
        self.sentence = None
        self.supervisor_state = "Ready to fly"
        self.battery_voltage = 4.0
        self.config = DroneConfig(name)
        self.calls = []

    def takeoff(self, absolute_height_m, duration_s, yaw):
        self.calls.append((self.world.tick, "takeoff"))
        self.position[2] = absolute_height_m

    def land(self, absolute_height_m, duration_s, yaw):
        self.calls.append((self.world.tick, "land"))
        self.position[2] = absolute_height_m

    def go_to(self, x, y, z, yaw, duration_s, linear):
        self.calls.append((self.world.tick, "go_to"))
        self.position[:] = x, y, z

    def upload_trajectory(self, trajectory_id, pieces, offset):
        self.calls.append((self.world.tick, "upload", trajectory_id, pieces.shape, offset))

    def start_trajectory(self, trajectory_id, time_scale, relative_position, reversed):
        self.calls.append((self.world.tick, "start", trajectory_id, time_scale))

    def arm(self):
        self.calls.append((self.world.tick, "arm"))

    def outage(self, now):
        return self.sentence and self.sentence.format(now)


class ObedientWorld:
    """Time, drones, and an event that a test may schedule."""

    def __init__(self, fleet):
        self.tick = 0
        self.data = SimpleNamespace(qpos=np.zeros(7 * len(fleet)))
        self.drones = [ObedientDrone(self, drone.id, drone.position) for drone in fleet]
        self.scheduled = {}
        self.events = []

    @property
    def time(self):
        return self.tick / 1000

    def step(self, n_ticks):
        assert n_ticks > 0
        for _ in range(n_ticks):
            self.tick += 1
            self.scheduled.get(self.tick, lambda: None)()

    def wait_until_ready(self, timeout_s):
        self.step(round(READY_AT * 1000))


class ObedientBackend:
    """The drones of `ObedientWorld`, and a log of what there is of them."""

    def __init__(self, world):
        self.world = world
        self.names = [drone.id for drone in world.drones]
        self.faults = []
        self.times = []
        self.positions = []

    @property
    def time(self):
        return self.world.time

    def advance(self, seconds):
        self.world.step(round(seconds * 1000))

    def record(self, extra):
        assert extra == {}
        self.times.append(self.world.time)
        self.positions.append(np.array([drone.position for drone in self.world.drones]))

    def run_alone(self, count):
        return 0, 0.0

    def log(self, metadata):
        positions = np.array(self.positions)
        signals = {
            f"{group}.{axis}": positions[:, :, i]
            for group in ("sim", "stateEstimate", "ctrltarget")
            for i, axis in enumerate("xyz")
        }
        signals["stabilizer.thrust"] = np.full(positions.shape[:2], 32767.5)
        signals["supervisor.info"] = np.where(positions[:, :, 2] > 0, 0x0018, 0x0008)
        return SimpleNamespace(time=np.array(self.times), signals=signals, metadata=metadata)

    def close(self):
        self.is_closed = True


class Setup:
    """A flight that is ready to run."""

    def __init__(self, mission, observe=None):
        self.mission = parse_mission(mission)
        self.world = ObedientWorld(self.mission.fleet)
        self.backend = ObedientBackend(self.world)
        self.given = {"observe": observe}

    def at(self, seconds, action):
        """Schedule *action* at a time of the plan (s)."""
        self.world.scheduled[round((READY_AT + seconds) * 1000)] = action

    def run(self):
        result = fly(self.mission, backend=self.backend, **self.given)
        assert self.backend.is_closed
        return result


def calls_of(setup, drone=0):
    return [(call[0] - round(READY_AT * 1000), *call[1:]) for call in setup.world.drones[drone].calls]


def test_commands_arrive_at_their_ticks_counted_from_ready(hop):
    setup = Setup(hop)
    result = setup.run()
    assert result.success
    assert result.failures == []
    assert calls_of(setup) == calls_of(setup, drone=1) == [(0, "takeoff"), (5000, "land")]
    assert result.summary["sim_seconds"] == READY_AT + 9.5
    assert result.summary["drones"][0]["hover_thrust_percent"] == 50.0


def test_log_has_a_sample_every_10_ms_and_says_what_was_flown(hop):
    result = Setup(hop).run()
    np.testing.assert_allclose(np.diff(result.log.time), 0.01)
    assert len(result.log.time) == 951
    assert result.log.metadata["mission"] == "hop"


def test_trajectory_is_uploaded_before_the_flight_and_started_in_it(hop):
    pieces = [{"duration": 1, "x": [0.0]}, {"duration": 1, "x": [0.0]}]
    hop["flight"][1] = {"trajectory": {"pieces": pieces, "time_scale": 1.5}}
    setup = Setup(hop)
    assert setup.run().success
    assert calls_of(setup)[0] == (0, "upload", 0, (2, 33), 0)
    assert (2000, "start", 0, 1.5) in calls_of(setup)


def test_log_says_when_each_phase_was(hop):
    hop["flight"][1] = {"together": [{"hover": {"duration": 1, "drones": [k]}} for k in ("cf1", "cf2")]}
    windows = Setup(hop).run().log.metadata["windows"]
    assert [name for name, *_ in windows] == ["takeoff", "hover", "land"]
    begins, ends = (np.array([window[k] for window in windows]) for k in (1, 2))
    assert begins == pytest.approx(READY_AT + np.array([0.0, 2.0, 3.0]))
    assert ends[:-1] == pytest.approx(begins[1:])


def test_observer_sees_the_flight_advance(hop):
    seen = []
    Setup(hop, observe=lambda world, progress: seen.append(progress.sim_seconds)).run()
    assert seen == pytest.approx(np.arange(0, 9.505, 0.01))


def test_flight_goes_on_after_a_drone_fails_and_says_why(hop):
    setup = Setup(hop)
    setup.at(3.01, lambda: setattr(setup.world.drones[1], "sentence", "cf2: crashed at {:.2f} s"))
    result = setup.run()
    assert result.failures == ["cf2: crashed at 4.54 s"]
    assert not result.success
    assert setup.world.time == pytest.approx(READY_AT + 9.5)
    assert result.summary["drones"][0]["rms_error_m"] == 0.0


def test_refused_command_fails_its_drone_with_its_sentence(hop):
    setup = Setup(hop)

    def refuse(**arguments):
        raise StateError("cf1: land is refused: already landing")

    setup.world.drones[0].land = refuse
    assert setup.run().failures == ["cf1: land is refused: already landing"]


def test_drone_that_cannot_take_off_is_asked_for_nothing_more(hop):
    setup = Setup(hop)
    setup.world.drones[1].can_fly = False
    assert setup.run().failures == ["cf2: is not ready to take off (Ready to fly)"]
    assert calls_of(setup, drone=1) == []
    assert calls_of(setup, drone=0)[-1][1] == "land"


def test_world_that_never_gets_ready_gives_a_summary_all_the_same(hop):
    setup = Setup(hop)

    def never(timeout_s):
        raise StateError("cf1: not ready after 10 s, state 'Locked'")

    setup.world.wait_until_ready = never
    result = setup.run()
    assert result.failures == ["cf1: not ready after 10 s, state 'Locked'"]
    assert result.log.metadata["windows"] == []
    assert result.summary["drones"][0]["rms_error_m"] is None


def test_drone_that_misses_its_target_is_reported_and_flies_on(hop):
    setup = Setup(hop)
    setup.world.drones[0].takeoff = lambda **arguments: None
    result = setup.run()
    assert result.failures[0].startswith("cf1: missed the target of flight[0].takeoff by 1.00 m")
    assert calls_of(setup, drone=1) == [(0, "takeoff"), (5000, "land")]


def test_vehicle_is_armed_again_only_when_it_can_be(hop):
    hop["flight"] = ["takeoff", "land", {"hover": {"duration": 5}}, "takeoff", "land"]
    setup = Setup(hop)
    setup.at(9.1, lambda: setattr(setup.world.drones[0], "can_arm", False))
    assert setup.run().success
    assert [call for call in calls_of(setup) if call[1] == "arm"] == [(9000, "arm")]
    assert [call for call in calls_of(setup, drone=1) if call[1] == "arm"] == [(9000, "arm"), (9250, "arm")]
