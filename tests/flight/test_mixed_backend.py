"""Mixed reality: real drones, and what motion capture sees, among simulated ones."""

import numpy as np
import pytest
from flown_layers import NAMES, formation, hover, mission, within

from crazychoir_fw.common.errors import MissionError, RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.flight.engine import fly
from crazychoir_fw.flight.mixed_backend import MixedBackend
from crazychoir_fw.flight.sim_backend import SimBackend
from crazychoir_fw.flight.watched_backend import WatchedBackend
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.mirrored import MirroredConfig


class Cameras:
    """Motion capture of bodies that move as a function of time says; None is not seen."""

    def __init__(self, clock, rate=50, **bodies):
        self.clock, self.rate, self.bodies = clock, rate, bodies
        self.seen, self.frames, self.closed = {}, {}, False

    def latest(self):
        frame = int(self.clock() * self.rate + 1e-6)
        for name, at in self.bodies.items():
            position = at(frame / self.rate)
            if position is not None and self.frames.get(name) != frame:
                self.frames[name] = frame
                level = np.array([0.0, 0.0, 0.0, 1.0])
                self.seen[name] = Pose(np.array(position, float), level, time=frame / self.rate)
        return dict(self.seen)

    def close(self):
        self.closed = True


def no_wait(seconds):
    """Time goes on with the world."""


class Real:
    """Stand-in for real drones that only records its commands."""

    is_real_time = True

    def __init__(self, *names):
        self.names, self.masses = list(names), np.full(len(names), 0.03)
        self.told, self.sick = [], {}

    def poses(self):
        count = len(self.names)
        still = np.zeros((count, 3))
        return Pose(still + np.array([5.0, 0.0, 1.0]), np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), still, still, 0.0)

    def true_positions(self):
        return self.poses().position

    def unlock(self, indices):
        return [i for i in indices if i in self.sick]

    def send(self, indices, twist, kind):
        self.told.append((list(indices), twist.linear.tolist(), kind))

    def go_to(self, index, point):
        self.told.append((index, point))

    def stop(self, indices):
        self.told.append(("stop", list(indices)))

    def failures(self):
        return self.sick

    def advance(self, seconds):
        self.told.append(seconds)

    def close(self):
        self.told.append("closed")


def simulated(*names, mirrored):
    world = World(
        [DroneConfig(id=name, position=(float(i), 0.0)) for i, name in enumerate(names)],
        mirrored=[MirroredConfig(name, (0.0, 2.0, 0.5)) for name in mirrored],
        visuals=False,
    )
    world.wait_until_ready()
    return SimBackend(world, "truth")


def with_cameras(at, **options):
    """Return a backend with a simulated drone `b` and a body `a` that cameras see."""
    sim = simulated("b", mirrored=["a"])

    def clock():
        return sim.world.time

    cameras = Cameras(clock, cf1=at)
    return MixedBackend(["a", "b"], sim, [WatchedBackend({"a": "cf1"}, cameras, clock=clock, sleep=no_wait, **options)])


def test_each_backend_gets_its_own():
    sim, first, second = simulated("b", mirrored=["a", "c", "d"]), Real("c", "a"), Real("d")
    backend = MixedBackend(NAMES, sim, [first, second])
    poses = backend.poses()
    assert poses.position[[0, 2, 3]].tolist() == [[5.0, 0.0, 1.0]] * 3
    assert poses.position[1] == pytest.approx([0.0, 0.0, 0.015], abs=1e-3)
    assert backend.pose_of(2).position.tolist() == [5.0, 0.0, 1.0]
    assert backend.masses == pytest.approx([0.03, sim.masses[0], 0.03, 0.03])
    linear = np.arange(6.0).reshape(2, 3)
    backend.send(np.array([0, 3]), Twist(linear, np.zeros((2, 3))), "fpqr")
    assert first.told.pop() == ([1], [[0.0, 1.0, 2.0]], "fpqr")
    assert second.told.pop() == ([0], [[3.0, 4.0, 5.0]], "fpqr")
    point = TrajectoryPoint(1.0, np.ones(3))
    backend.go_to(2, point)
    assert first.told.pop() == (0, point)
    backend.stop([2, 0])
    assert first.told.pop() == ("stop", [0, 1])
    first.sick = {1: "a: is sick"}
    assert backend.unlock([0, 1, 2, 3]) == [0]
    assert backend.failures() == {0: "a: is sick"}
    begin = backend.time
    backend.advance(0.02)
    assert backend.time == pytest.approx(begin + 0.02)
    assert first.told == second.told == [0.02]
    backend.close()
    assert first.told[-1] == second.told[-1] == "closed"


def test_who_is_nowhere_or_twice_is_refused():
    sim = simulated("b", mirrored=["a"])
    with pytest.raises(RangeError, match="backends have the drones b, allowed: a, b, each once"):
        MixedBackend(["a", "b"], sim, [])
    with pytest.raises(RangeError, match="c: the world has no mirrored body"):
        MixedBackend(["c", "b"], sim, [Real("c")])


def test_a_body_moves_smoothly_with_its_velocity():
    backend = with_cameras(lambda now: [0.8 * now, 2.0, 1.0])
    backend.look()
    body, places = backend.world.mirrored["a"], []
    for _ in range(150):
        backend.advance(0.01)
        places.append(body.position)
    steps = np.diff([place[0] for place in places[50:]])
    assert steps == pytest.approx(0.008, abs=0.003)  # also between frames, which come every second round
    assert body.velocity == pytest.approx([0.8, 0.0, 0.0], abs=0.1)
    assert body.position[0] == pytest.approx(0.8 * backend.time, abs=0.03)
    assert backend.poses().velocity[0] == pytest.approx([0.8, 0.0, 0.0], abs=0.05)


def test_who_is_not_heard_of_stays_and_is_told_to_be_stale():
    backend = with_cameras(lambda now: None if 3.0 < now < 5.0 else [0.0, 2.0, 1.0], stale_s=0.4)
    backend.look()
    body = backend.world.mirrored["a"]
    while backend.time < 4.5:
        backend.advance(0.02)
    assert backend.mirror.stale == {"a"}
    assert np.isnan(backend.poses().position[0]).all()
    assert body.position == pytest.approx([0.0, 2.0, 1.0], abs=1e-6)
    while backend.time < 5.5:
        backend.advance(0.02)
    assert not backend.mirror.stale
    assert [(event.kind, event.drone) for event in backend.world.events] == [("stale", "a"), ("heard_again", "a")]
    (report,) = backend.mirror.report()
    assert report["gaps"] == 1 and report["longest_stale_s"] == pytest.approx(1.6, abs=0.1) and not report["stale"]


def test_who_was_never_seen_stays_where_the_mission_says():
    backend = with_cameras(lambda now: None)
    backend.look()
    backend.advance(1.0)
    assert backend.world.mirrored["a"].position == pytest.approx([0.0, 2.0, 0.5], abs=1e-6)
    assert backend.mirror.report() == [{"id": "a", "heard": 0.0, "gaps": 0, "longest_stale_s": 0.0, "stale": True}]


@pytest.mark.parametrize("likeness", ["sphere", "cf2", "cf21bl"])
@pytest.mark.parametrize("collides", [False, True])
def test_a_body_can_be_an_obstacle(likeness, collides):
    body = MirroredConfig("a", (0.0, 0.0, 2.0), likeness, collides=collides)
    world = World([DroneConfig(id="b", position=(0.0, 0.0))], mirrored=[body], visuals=False)
    world.wait_until_ready()
    world["b"].high_level_commander.takeoff(0.5, 1.5)
    world.run(2.0)
    above = world.positions()[0] + [0.0, 0.0, 0.25]
    world.mirrored["a"].put(above, [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, -0.5], np.zeros(3))
    world.run(0.6)
    hits = [event for event in world.events if event.kind == "collision"]
    assert bool(hits) == collides
    if collides:
        assert hits[0].details["other"].startswith("a")
        assert 0.3 < hits[0].details["speed"] < 1.0
    assert world.mirrored["a"].position[2] == pytest.approx(above[2] - 0.3, abs=0.05)  # hardly moved by it


def test_mirrored_bodies_fall_through_nothing_and_stand_on_nothing():
    world = World([DroneConfig(id="b")], mirrored=[MirroredConfig("a", (1.0, 0.0, 0.0), collides=True)], visuals=False)
    world.run(1.0)
    assert world.mirrored["a"].position == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    (other,) = world.fork(1)
    other.mirrored["a"].put([2.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], np.zeros(3), np.zeros(3))
    assert world.mirrored["a"].position[0] == pytest.approx(1.0)
    with pytest.raises(RangeError, match="a: pose and velocity are"):
        other.mirrored["a"].put([np.nan, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], np.zeros(3), np.zeros(3))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"likeness": "ghost"}, "a: likeness is 'ghost', allowed: sphere, cf2, cf21bl"),
        ({"radius": 5.0}, "a: radius is 5.0"),
        ({"position": (0.0, np.nan, 0.0)}, "a: position is"),
        ({"id": "b"}, "'b' is used twice"),
    ],
)
def test_bodies_that_cannot_be_are_refused(changes, says):
    with pytest.raises(RangeError, match=says):
        World([DroneConfig(id="b")], mirrored=[MirroredConfig(**{"id": "a", **changes})])


def test_drones_that_avoid_collisions_know_the_real_ones():
    sim = simulated("b", mirrored=["a"])
    sim.world["b"].param.set_value("colAv.enable", 1)
    backend = MixedBackend(["a", "b"], sim, [Real("a")])
    backend.look()
    for _ in range(10):
        backend.advance(0.02)
    assert sim.world["b"].peers.tolist() == [[5.0, 0.0, 1.0]]


# -------------------------------------------------------------------------------- whole flights


def test_formation_around_a_body_that_cameras_see():
    """A hand-held drone leads with a simulated one; the followers find their places."""
    data = formation(backend="mixed", hardware={"mocap": {"system": "udp"}}, criteria={"bearing_error_deg": 2.0})
    data["drones"][0]["mocap"] = "cf1"
    flown = mission(data)
    sim = simulated_of(flown, ["a"])

    def clock():
        return sim.world.time

    cameras = Cameras(clock, cf1=lambda now: [-0.5, -0.5, 0.6])
    backend = MixedBackend(NAMES, sim, [WatchedBackend({"a": "cf1"}, cameras, clock=clock, sleep=no_wait)])
    result = fly(flown, backend=backend)
    assert result.success, result.failures
    assert [drone["phase"] for drone in result.summary["drones"]] == ["ground", "landed", "landed", "landed"]
    assert result.summary["mirrored"][0]["heard"] == 1.0
    assert np.isfinite(result.log.signals["sim.x"][50:]).all()
    assert np.isnan(result.log.signals["pm.vbat"][:, 0]).all()
    assert "no journal holds" in result.log.journal.gap
    assert cameras.closed


def simulated_of(flown, mirrored):
    from crazychoir_fw.flight.backends import build_world

    world = build_world(flown, visuals=False, mirrored=[MirroredConfig(name) for name in mirrored])
    world.wait_until_ready()
    return SimBackend(world, "truth", flown.log_rate)


def test_formation_with_real_leaders_over_the_radio(tmp_path):
    pytest.importorskip("cflib")
    from served_drones import Served

    data = formation(backend="mixed", criteria={"bearing_error_deg": 2.0, "position_error_m": 0.08})
    for port, drone in enumerate(data["drones"][:2]):
        drone["uri"] = f"udp://127.0.0.1:{19850 + port}"
    data["flight"] = [{"takeoff": {"duration": 2.5}}, {"start": {"duration": 5}}, {"land": {"duration": 2}}]
    flown = mission(data)
    served = Served(flown, tmp_path, ids=["a", "b"])
    backend = MixedBackend(NAMES, simulated_of(flown, ["a", "b"]), [served])
    backend.look()
    result = fly(flown, backend=backend)
    assert result.success, result.failures
    assert [drone["phase"] for drone in result.summary["drones"]] == ["landed"] * 4
    assert served.world_there.positions()[:, 2].max() < 0.05
    shown = np.array([backend.world.mirrored[name].position for name in ("a", "b")])
    assert shown == pytest.approx(served.world_there.positions(), abs=0.05)


def test_a_real_drone_that_falls_silent_stops_nobody(tmp_path):
    pytest.importorskip("cflib")
    from served_drones import Served

    data = hover(2, backend="mixed", may_fail=["a"])
    data["drones"][0]["uri"] = "udp://127.0.0.1:19850"
    flown = mission(data)
    served = Served(flown, tmp_path, ids=["a"])
    backend = MixedBackend(["a", "b"], simulated_of(flown, ["a"]), [served])

    def observe(world, progress):
        if progress.sim_seconds > 2.2:
            served.world_there.drones[0].emergency_stop()

    result = fly(flown, backend=backend, observe=observe)
    assert result.success, result.failures
    assert [drone["phase"] for drone in result.summary["drones"]] == ["failed", "landed"]


# -------------------------------------------------------------------------------- mission files

MIXED = within(hover(3, backend="mixed"), "hardware", {"mocap": {"system": "udp"}})


def with_drones(*changes, **more):
    data = {**MIXED, **more}
    return {**data, "drones": [{**drone, **change} for drone, change in zip(data["drones"], changes, strict=True)]}


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (with_drones({}, {}, {}), "backend mixed needs a drone that is real"),
        (with_drones({"mocap": "a"}, {"mocap": "b"}, {"uri": "udp://here:1"}), "backend mixed needs a simulated drone"),
        (with_drones({"mocap": "a"}, {}, {}, hardware={}), r"hardware.mocap is missing: drones\[0\].mocap needs"),
        (with_drones({"uri": "udp://h:1"}, {"uri": "udp://h:1"}, {}), r"drones\[1\].uri is udp://h:1, but drones\[0\]"),
        (with_drones({"mocap": "a b"}, {}, {}), r"drones\[0\].mocap"),
        (with_drones({"mocap": "a"}, {}, {}, mixed={"likeness": "ghost"}), "mixed.likeness is 'ghost'"),
        (with_drones({"mocap": "a"}, {}, {}, hardware={"mocap": {"system": "eyes"}}), "hardware.mocap.system"),
    ],
)
def test_mixed_missions_that_cannot_be_are_refused(data, says):
    with pytest.raises(MissionError, match=says):
        mission(data)


@pytest.mark.parametrize("backend", ["sim", "integrator"])
def test_a_mixed_mission_can_be_rehearsed(backend):
    flown = mission(with_drones({"mocap": "a"}, {"uri": "udp://here:1"}, {}), backend=backend)
    assert flown.backend == backend


def test_what_a_mission_says_becomes_backends(monkeypatch):
    from crazychoir_fw.flight import real_drones
    from crazychoir_fw.flight.backends import make_backend

    made = []

    class Radio(Real):
        def __init__(self, uris, kind, **options):
            super().__init__(*uris)
            made.append((dict(uris), kind, sorted(options)))
            self.when_closed = []
            self.handler = {name: self for name in uris}

        def external_pose(self, position, quaternion):
            made.append(position.tolist())

        def wait_for_poses(self):
            pass

    monkeypatch.setattr(real_drones, "HardwareBackend", Radio)
    data = with_drones({"uri": "udp://h:1", "mocap": "cf1"}, {"mocap": "cf2"}, {}, mixed={"likeness": "sphere"})
    backend = make_backend(mission(within(data, "hardware.mocap.port", 0)))
    try:
        assert made[0] == ({"a": "udp://h:1"}, "fpqr", ["masses", "odometry_hz", "thrust"])
        assert [part.names for part in backend.real] == [["a"], ["b"]]
        assert [part.names for part in [backend.simulated]] == [["c"]]
        assert backend.world.model.geom("b/accent").type[0] == 2  # a sphere
        assert backend.masses == pytest.approx(backend.masses[2], abs=0.02)
        source = backend.real[1]._source
        source._take(b'{"cf1": [1, 2, 3]}')
        while len(made) < 2:
            pass
        assert made[1] == [1.0, 2.0, 3.0]
    finally:
        for call in backend.real[0].when_closed:
            call()
        backend.close()
