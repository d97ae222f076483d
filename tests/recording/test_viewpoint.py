import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.recording.viewpoint import chase, first_person, looking_at

numbers = st.floats(-5.0, 5.0)
quats = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 0.1)


def rotation_of(quat) -> np.ndarray:
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, np.array(quat) / np.linalg.norm(quat))
    return rotation.reshape(3, 3)


def is_orthonormal(view) -> bool:
    lengths = np.linalg.norm([view.forward, view.up], axis=1)
    return np.allclose(lengths, 1.0) and abs(view.forward @ view.up) < 1e-9


@given(quats, st.floats(-90.0, 90.0))
def test_the_onboard_camera_is_screwed_to_the_body(quat, tilt):
    rotation, place = rotation_of(quat), np.array([1.0, 2.0, 3.0])
    view = first_person(place, rotation, 60.0, tilt)
    assert is_orthonormal(view)
    assert np.degrees(np.arcsin(np.clip(view.forward @ rotation[:, 2], -1, 1))) == pytest.approx(tilt, abs=1e-4)
    np.testing.assert_allclose(rotation.T @ (view.position - place), [0.032, 0.0, 0.014], atol=1e-9)


@given(quats)
def test_the_chasing_camera_is_level_at_every_attitude(quat):
    view = chase(np.array([1.0, 2.0, 3.0]), rotation_of(quat), 45.0)
    assert is_orthonormal(view)
    assert view.up[2] > 0.5
    assert view.position[2] == pytest.approx(3.2)
    assert np.linalg.norm(view.position[:2] - [1.0, 2.0]) == pytest.approx(0.55)


@pytest.mark.parametrize("pitch_deg", [-60.0, -89.0, 0.0, 60.0, 89.0])
@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, -135.0])
def test_the_chasing_camera_follows_yaw_through_steep_pitch(pitch_deg, yaw_deg):
    yaw, pitch = np.radians([yaw_deg, pitch_deg])
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    nod = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
    view = chase(np.zeros(3), turn @ nod, 45.0)
    np.testing.assert_allclose(view.position[:2], -0.55 * turn[:2, 0], atol=1e-9)


def test_straight_down_north_is_on_top():
    view = looking_at((0, 0, 2), (0, 0, 0), 45.0)
    np.testing.assert_allclose([view.forward, view.up], [[0, 0, -1], [0, 1, 0]], atol=1e-12)


@given(st.tuples(numbers, numbers, numbers), st.tuples(numbers, numbers, numbers))
def test_the_free_camera_has_place_and_direction(position, target):
    if np.linalg.norm(np.subtract(target, position)) < 1e-3:
        return
    view, camera = looking_at(position, target, 45.0), mujoco.MjvCamera()
    view.aim(camera)
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    forward = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    np.testing.assert_allclose(forward, view.forward, atol=1e-6)
    np.testing.assert_allclose(camera.lookat - camera.distance * np.array(forward), position, atol=1e-5)
