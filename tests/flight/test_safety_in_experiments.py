"""Drones that keep apart in experiments: in the controller, behind it, and when one of them is lost."""

import numpy as np
import pytest
from flown_layers import mission, within

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.flight.agents import make_groups
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.flight.sensing import Sensing

ACCELERATIONS = {
    "filter": "DoubleIntegratorCBF",
    "distance": 0.3,
    "gamma": 5.0,
    "max_acceleration": 1.0,
    "max_braking_acceleration": 1.5,
    "margin": 0.01,
}
VELOCITIES = {"filter": "SingleIntegratorCBF", "distance": 0.3, "gamma": 5.0, "max_velocity": 0.4}


def head_on(safety, backend="integrator", seconds=9.0, **layers):
    """Two drones of 38 g, in the air, that change places along one line."""
    control = {"gains": "mujoco"}
    if safety and safety["filter"] == "SingleIntegratorCBF":
        control |= {"class": "VelocityController"}
    data = {
        "name": "head_on",
        "backend": backend,
        "seed": 1,
        "log_rate": 50,
        "drones": [{"id": "a", "position": [-0.8, 0.0]}, {"id": "b", "position": [0.8, 0.0]}],
        "layers": {
            "rate": 50,
            "odometry": "estimate" if backend == "sim" else "truth",
            "guidance": {
                "class": "GoToGuidance",
                "goals": {"a": [[1.5, -0.8, 0, 0.6], [4, 0.8, 0, 0.6]], "b": [[1.5, 0.8, 0, 0.6], [4, -0.8, 0, 0.6]]},
            },
            "planning": {"class": "Spline"},
            "control": control,
            "safety": safety,
            **layers,
        },
        "flight": [{"start": {"duration": seconds}}],
        "criteria": {"min_distance_m": 0.3, "position_error_m": 0.05},
    }
    return data if safety else within(data, "layers.safety", None)


def least_distance(result):
    """Return the least horizontal distance over the flight (m)."""
    at = np.stack([result.log.signals[f"sim.{axis}"] for axis in "xy"], axis=-1)
    return np.linalg.norm(at[:, 0] - at[:, 1], axis=-1).min()


@pytest.mark.parametrize(
    ("backend", "safety", "layers"),
    [
        ("integrator", ACCELERATIONS, {}),
        ("integrator", VELOCITIES, {}),
        ("integrator", {**VELOCITIES, "rate": 25, "sensing_rate": 10}, {}),
        ("sim", ACCELERATIONS, {}),
        ("sim", {**ACCELERATIONS, "sees": "truth"}, {"odometry": "mocap"}),
    ],
)
def test_head_on_they_keep_their_distance_and_arrive(backend, safety, layers):
    result = fly(mission(head_on(safety, backend, **layers)), visuals=False)
    assert result.summary["failures"] == []
    assert least_distance(result) >= 0.3


def test_without_safety_they_would_collide():
    result = fly(mission(head_on(None)), visuals=False)
    assert least_distance(result) < 0.05


def test_the_same_flight_has_the_same_bits():
    flown = [fly(mission(head_on(ACCELERATIONS, seconds=4.0)), visuals=False).log for _ in range(2)]
    for name, signal in flown[0].signals.items():
        np.testing.assert_array_equal(signal, flown[1].signals[name])


def test_a_controller_at_its_own_rate():
    data = head_on(VELOCITIES, seconds=1.0)
    data["layers"]["control"]["rate"] = 10
    experiment = make_experiment(mission(data))
    assert min(experiment.groups[0].controller.periods) == 0.02
    assert max(experiment.groups[0].controller.periods) == 0.1


def test_all_equal_drones_are_one_group():
    groups = make_groups(mission(head_on(ACCELERATIONS)), [0.03, 0.03])
    assert [list(group.indices) for group in groups] == [[0, 1]]


# ---------------------------------------------------------------- a drone is lost


def in_the_middle(safety):
    """Return an experiment whose drones are about to meet."""
    experiment = make_experiment(mission(head_on(safety)))
    experiment.start()
    experiment.run(3.0)
    return experiment


@pytest.mark.parametrize("safety", [ACCELERATIONS, VELOCITIES])
def test_when_one_falls_the_other_goes_straight_on(safety):
    experiment = in_the_middle(safety)

    def fail(now):
        raise ValueError("broken")

    experiment.agents[1].guidance.step = fail
    experiment.run(7.0)
    assert experiment.agents[1].phase is DronePhase.FAILED
    at = experiment.backend.true_positions()[0]
    np.testing.assert_allclose(at, [0.8, 0.0, 0.6], atol=0.05)


@pytest.mark.parametrize("safety", [ACCELERATIONS, VELOCITIES])
def test_who_is_not_seen_any_more_stays_an_obstacle_where_it_was(safety):
    experiment = in_the_middle(safety)
    backend, read = experiment.backend, experiment.backend.read_poses
    gone = backend.true_positions()[1]

    def half_blind():
        poses = read()
        parts = [np.array(part) for part in (poses.position, poses.orientation, poses.velocity, poses.angular)]
        for part in parts:
            part[1] = np.nan
        return Pose(*parts, poses.time)

    backend.read_poses = half_blind
    least = np.inf
    for _ in range(400):
        experiment.step()
        least = min(least, np.linalg.norm((backend.true_positions()[0] - gone)[:2]))
    assert least >= 0.29
    assert experiment.agents[0].phase is DronePhase.FLYING
    assert backend.true_positions()[0, 0] > 0.3


def test_sensing_sees_who_flies_at_its_rate():
    sensing = Sensing(1.0, rate=10.0)
    position = np.array([[0.0, 0, 1], [0.5, 0, 1], [0.0, 0.6, 0]])
    poses = Pose(position=position, velocity=np.full((3, 3), 0.2))
    sensing.look(0.0, poses, np.array([True, True, False]))
    near = sensing.near([0, 1])
    np.testing.assert_array_equal(near.position[0, 0], position[1])
    assert near.position.shape == (2, 1, 3)
    moved = Pose(position=position + 0.1, velocity=poses.velocity)
    sensing.look(0.05, moved, np.ones(3, bool))
    np.testing.assert_array_equal(sensing.near([0]).position[0, 0], position[1])
    for k in range(4):
        sensing.look(0.1 + 0.1 * k, moved, np.ones(3, bool))
    assert sensing.near([0]).position.shape == (1, 2, 3)
    # it does not move any more, whatever was said of its velocity
    np.testing.assert_array_equal(sensing.near([0]).velocity[0, 0], np.zeros(3))


# ---------------------------------------------------------------- mission files


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("layers.safety.filter", "CBF", "layers.safety.filter"),
        ("layers.safety.filter", "SingleIntegratorCBF", "filters the commands of a VelocityController"),
        ("layers.safety.max_velocity", 0.2, "layers.safety.max_velocity is for the filter SingleIntegratorCBF"),
        ("layers.safety.sensing_distance", 0.3, "must be above distance and margin, 0.31 m"),
        ("layers.safety.sensing_rate", 20, "layers.safety.sensing_rate is 20, but must be a divisor"),
        ("layers.safety.distance", -1.0, "layers.safety.distance"),
        ("layers.control.rate", 100, "layers.control.rate is 100, but must be a divisor"),
        ("layers.control", None, "layers.safety needs layers.control"),
    ],
)
def test_bad_missions_are_refused(path, value, says):
    data = within(head_on(ACCELERATIONS), path, value)
    if path == "layers.control":
        data = within(data, "layers.planning", None)
    with pytest.raises(MissionError, match=says):
        mission(data)


def test_nobody_knows_the_truth_of_real_drones():
    data = head_on({**ACCELERATIONS, "sees": "truth"}, backend="hardware")
    for i, drone in enumerate(data["drones"]):
        drone["uri"] = f"radio://0/80/2M/E7E7E7E70{i}"
    with pytest.raises(MissionError, match="nobody knows the truth of real drones"):
        mission(data)
