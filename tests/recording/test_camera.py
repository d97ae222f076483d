import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.recording.shots import follow


def seen(shot, frame: int, points: np.ndarray, *, fovy_deg: float = 45.0, aspect: float = 16 / 9) -> np.ndarray:
    """Return where *points* (N, 3) appear in the picture: right and up, each within [-1, 1] if visible."""
    camera = mujoco.MjvCamera()
    shot.place(camera, frame)
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    forward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
    away = points - (camera.lookat - camera.distance * forward)
    scale = np.tan(np.radians(fovy_deg) / 2.0) * (away @ forward)
    return np.column_stack([away @ right / (scale * aspect), away @ np.cross(right, forward) / scale])


@settings(deadline=None)
@given(
    drones=st.integers(1, 12),
    spread=st.floats(0.0, 2.5),
    travel=st.floats(0.0, 0.3),
    aspect=st.sampled_from([16 / 9, 1.0, 9 / 16]),
    seed=st.integers(0, 100),
)
def test_the_swarm_stays_in_the_picture(drones, spread, travel, aspect, seed):
    random = np.random.default_rng(seed)
    times = np.arange(0.0, 8.0, 0.1)
    start = random.uniform(-1.0, 1.0, (drones, 3)) * spread
    path = start + times[:, None, None] * travel * random.uniform(-1.0, 1.0, (1, drones, 3))
    shot = follow(path, times, aspect=aspect)
    for frame in range(0, len(times), 20):
        assert np.abs(seen(shot, frame, path[frame], aspect=aspect)).max() <= 1.0


def test_a_lonely_hovering_drone_is_shown_from_near():
    times = np.arange(0.0, 5.0, 0.04)
    shot = follow(np.tile([1.0, 2.0, 0.5], (len(times), 1, 1)), times)
    np.testing.assert_allclose(shot.center, np.tile([1.0, 2.0, 0.5], (len(times), 1)), atol=1e-9)
    np.testing.assert_allclose(shot.distance, 1.1, atol=1e-9)


def test_the_camera_moves_calmly_while_a_drone_jitters():
    times = np.arange(0.0, 10.0, 0.04)
    path = np.zeros((len(times), 1, 3))
    path[:, 0, 0] = 0.1 * (-1.0) ** np.arange(len(times))
    center = follow(path, times).center
    assert np.abs(np.diff(center[:, 0])).max() < 1e-3


def test_a_flat_swarm_fills_the_picture_from_edge_to_edge():
    times = np.arange(0.0, 2.0, 0.1)
    grid = np.stack(np.meshgrid(np.linspace(-2, 2, 5), np.linspace(-2, 2, 5), [1.0]), axis=-1).reshape(-1, 3)
    shot = follow(np.tile(grid, (len(times), 1, 1)), times)
    place = seen(shot, 0, grid)
    assert np.ptp(place, axis=0).max() > 1.2
    assert place[:, 0].max() == pytest.approx(-place[:, 0].min(), abs=0.1)


def test_a_drone_that_flies_off_is_given_up():
    times = np.arange(0.0, 4.0, 0.1)
    path = np.zeros((len(times), 5, 3))
    path[:, :, 0] = np.arange(5) * 0.3
    path[:, 4, 1] = 1e4
    assert follow(path, times).distance.max() < 3.0


def test_drones_without_a_position_are_left_out():
    times = np.arange(0.0, 2.0, 0.1)
    path = np.zeros((len(times), 3, 3))
    path[:, 1] = np.nan
    path[5:, 2, 0] = np.inf
    shot = follow(path, times)
    assert np.isfinite(shot.center).all() and np.isfinite(shot.distance).all()


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 4, 3), (6, 0, 3)])
def test_short_and_empty_flights_have_a_camera(shape):
    shot = follow(np.zeros(shape), np.arange(shape[0]) * 0.1)
    assert shot.center.shape == (shape[0], 3)
    assert np.isfinite(shot.distance).all()
