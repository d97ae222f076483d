import imageio.v3 as iio
import mujoco
import numpy as np
import pytest

from crazychoir_fw.recording.film import film_flight, resample
from crazychoir_fw.recording.magnify import magnified
from crazychoir_fw.recording.storyboard import Note, Storyboard, Window


def hover(model: mujoco.MjModel, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Return states and times of a world whose drones stay where they are for 1 s."""
    return np.tile(model.qpos0, (frames, 1)), np.linspace(0.0, 1.0, frames)


@pytest.mark.parametrize("camera", ["follow", "overview", "track"])
def test_a_flight_is_filmed(tmp_path, two_drones, drawing, camera):
    states, times = hover(two_drones, 5)
    states[:, 2] += times  # the red one climbs
    done = []
    with drawing:
        film_flight(
            two_drones, states, times, tmp_path / "flight.mp4", camera=camera, width=192, height=108, fps=8.0,
            progress=lambda *counts: done.append(counts),
        )  # fmt: skip
        assert done == [(k, 9) for k in range(1, 10)]
        pictures = iio.imread(tmp_path / "flight.mp4").astype(int)
        assert pictures.shape == (9, 108, 192, 3)
        assert np.abs(pictures[-1] - pictures[0]).max() > 60


def test_trails_have_the_colors_of_their_drones(tmp_path, two_drones, drawing):
    states, times = hover(two_drones, 11)
    states[:, [2, 9]] += times[:, None]
    options = {"camera": "track", "width": 320, "height": 180, "fps": 10.0}
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "with.mp4", **options)
        film_flight(two_drones, states, times, tmp_path / "without.mp4", trail_s=0.0, **options)
        last = [iio.imread(tmp_path / f"{name}.mp4")[-1].astype(int) for name in ("with", "without")]
        for first, second in ((0, 2), (2, 0)):
            with_trail, without = ((p[..., first] - p[..., second] > 40).sum() for p in last)
            assert with_trail > without + 50


def test_speed_shortens_the_film(tmp_path, two_drones, drawing):
    states, times = hover(two_drones, 3)
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "a.mp4", width=64, height=48, fps=10.0, speed=2.0)
        assert len(iio.imread(tmp_path / "a.mp4")) == 6


def test_filming_changes_no_model(tmp_path, two_drones, drawing):
    before = two_drones.vis.map.shadowclip, two_drones.stat.extent, two_drones.light_pos.copy()
    states, times = hover(two_drones, 2)
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "a.mp4", width=64, height=48, fps=4.0)
    assert (two_drones.vis.map.shadowclip, two_drones.stat.extent) == before[:2]
    np.testing.assert_array_equal(two_drones.light_pos, before[2])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"qpos": np.zeros((3, 5))}, r"expected \(F, 14\)"),
        ({"qpos": np.zeros((2, 14))}, "expected"),
        ({"qpos": np.zeros((0, 14)), "times": []}, "expected"),
        ({"times": [0.0, 1.0, 1.0]}, "must increase"),
        ({"times": [0.0, np.nan, 1.0]}, "must increase"),
        ({"speed": 0.0}, "speed"),
        ({"speed": np.nan}, "speed"),
        ({"camera": "nobody"}, "there are follow, fpv:NAME, chase:NAME, overview, track"),
    ],
)
def test_a_flight_that_cannot_be_filmed_is_refused(tmp_path, two_drones, change, message):
    states, times = hover(two_drones, 3)
    arguments = {"qpos": states, "times": times, "path": tmp_path / "a.mp4"} | change
    with pytest.raises(ValueError, match=message):
        film_flight(two_drones, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_states_between_the_recorded_ones_are_interpolated(two_drones):
    states, _ = hover(two_drones, 2)
    states[1, 0] += 1.0
    states[1, 3:7] = -np.array([np.cos(0.5), 0.0, 0.0, np.sin(0.5)])  # the far side of a yaw of 1 rad
    between = resample(two_drones, states, np.array([0.0, 1.0]), np.array([-1.0, 0.0, 0.5, 1.0, 2.0]))
    np.testing.assert_allclose(between[:, 0] - 0.25, [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-12)
    yaw = 2.0 * np.arctan2(between[:, 6], between[:, 3])
    np.testing.assert_allclose(yaw, [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(between[:, 3:7], axis=1), 1.0, rtol=1e-12)


def test_one_state_is_a_film_of_one_picture(two_drones):
    states, _ = hover(two_drones, 1)
    np.testing.assert_array_equal(resample(two_drones, states, np.zeros(1), np.zeros(1)), states)


@pytest.mark.parametrize("camera", ["fpv:red", "chase:blue"])
def test_a_flight_is_filmed_from_a_drone(tmp_path, two_drones, drawing, camera):
    states, times = hover(two_drones, 5)
    states[:, 3:7] = states[:, 10:14] = [0.0, 0.0, 0.0, 1.0]  # both look along -x, red sees blue
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "a.mp4", camera=camera, width=192, height=108, fps=4.0)
        last = iio.imread(tmp_path / "a.mp4")[-1].astype(int)
        assert (last[..., 2] - last[..., 0] > 60).sum() > 5
        # at the edges, red sees its own front propellers
        middle = last[:, 48:-48]
        assert (middle[..., 0] - middle[..., 2] > 60).sum() == 0


def test_ghosts_are_filmed_where_drones_are_told_to_be(tmp_path, two_drones, drawing):
    states, times = hover(two_drones, 5)
    targets = np.full((5, 2, 3), np.nan)
    targets[2:, 0] = [0.25, 0.0, 1.3]
    options = {"camera": "chase:blue", "width": 320, "height": 180, "fps": 4.0, "trail_s": 0.0}
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "a.mp4", targets=targets, **options)
        first, *_, last = iio.imread(tmp_path / "a.mp4").astype(int)
        red = [(p[..., 0] - p[..., 2] > 50).sum() for p in (first, last)]
        assert red[1] > red[0] + 30


def test_the_bar_fills_and_faults_are_red_while_they_last(tmp_path, two_drones, drawing):
    states, times = hover(two_drones, 5)
    story = Storyboard("Two drones", [Window("takeoff", 0.0, 0.5)], [Note("motor 2 stops", 0.4, 0.8, "red")])
    options = {"camera": "track", "width": 320, "height": 180, "fps": 10.0, "trail_s": 0.0}
    with drawing:
        film_flight(two_drones, states, times, tmp_path / "a.mp4", story=story, **options)
        pictures = iio.imread(tmp_path / "a.mp4").astype(int)
        bar = pictures[:, -4:]
        done = (bar[..., 2] - bar[..., 0] > 60).mean(axis=(1, 2))
        assert (np.diff(done) > 0.05).all()
        corner = pictures[:, 20:36, 160:]
        shown = (corner[..., 0] - corner[..., 2] > 90).sum(axis=(1, 2)) > 200
        np.testing.assert_array_equal(shown, [False] * 4 + [True] * 4 + [False] * 3)


def test_small_drones_of_a_wide_swarm_are_drawn_larger_on_their_feet(two_drones):
    bodies = two_drones.jnt_bodyid
    near = np.tile([[0.0, 0.0, 0.5], [0.2, 0.0, 0.5]], (3, 1, 1))
    far = near * [20.0, 1.0, 1.0]
    assert magnified(two_drones, bodies, near / 2.0, np.full(3, 5.0)) == (two_drones, 1.0)  # they would touch
    model, scale = magnified(two_drones, bodies, far, np.full(3, 5.0))
    assert 2.0 < scale <= 3.0
    np.testing.assert_allclose(model.mesh_vert, scale * two_drones.mesh_vert, rtol=1e-6)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    before = mujoco.MjData(two_drones)
    mujoco.mj_kinematics(two_drones, before)
    geom = model.geom("red/body").id

    def lowest(model, data):
        begin, count = model.mesh_vertadr[0], model.mesh_vertnum[0]
        vertices = model.mesh_vert[begin : begin + count] @ data.geom_xmat[geom].reshape(3, 3).T
        return (vertices + data.geom_xpos[geom])[:, 2].min()

    assert lowest(model, data) == pytest.approx(lowest(two_drones, before), abs=0.004)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"camera": "fpv:green"}, "no drone 'green' for the camera; there are red, blue"),
        ({"drones": ["green"]}, "no drone 'green'"),
        ({"targets": np.zeros((3, 1, 3))}, r"targets has shape \(3, 1, 3\), expected \(3, 2, 3\)"),
    ],
)
def test_drones_that_are_not_there_are_refused(tmp_path, two_drones, change, message):
    states, times = hover(two_drones, 3)
    with pytest.raises(ValueError, match=message):
        film_flight(two_drones, states, times, tmp_path / "a.mp4", **change)
