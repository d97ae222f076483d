import mujoco
import numpy as np

from crazychoir_fw.recording.overlays import add_ghosts, add_names, drone_colors


def test_ghosts_and_names_are_where_they_belong(two_drones):
    scene = mujoco.MjvScene(two_drones, maxgeom=10)
    bodies = [two_drones.body(name).id for name in ("red", "blue")]
    colors = drone_colors(two_drones, bodies)
    np.testing.assert_array_equal(colors, [[1, 0, 0], [0, 0, 1]])
    add_ghosts(scene, np.array([[1.0, 2.0, 3.0], [np.nan] * 3]), colors)
    add_names(scene, np.array([[0.0, 0.0, 1.0], [0.0, np.inf, 1.0]]), ["red", "blue"])
    assert scene.ngeom == 4
    known, unknown, name, lost = (scene.geoms[k] for k in range(4))
    np.testing.assert_allclose(known.pos, [1, 2, 3])
    assert 0.0 < known.rgba[3] < 1.0 and unknown.rgba[3] == 0.0
    assert (name.label, lost.label) == ("red", "")
    assert name.pos[2] > 1.0
    # what is only seen by people casts no shadow
    assert all(scene.geoms[k].category == mujoco.mjtCatBit.mjCAT_DECOR for k in range(4))


def test_a_full_scene_is_left_as_it_is(two_drones):
    scene = mujoco.MjvScene(two_drones, maxgeom=3)
    add_ghosts(scene, np.zeros((2, 3)), np.zeros((2, 3)))
    add_names(scene, np.zeros((2, 3)), ["red", "x" * 500])
    assert scene.ngeom == 3
