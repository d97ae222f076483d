"""Rays of ranging decks against MuJoCo's own, which look at every geom."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.mujoco_models import SCENES
from crazychoir_fw.simulation import DroneConfig, World

REACH = 6.0
FAR = (900.0, 900.0, 1.0)  # where the one drone does not disturb
GEOMS = {
    "box": 'type="box" size="0.3 0.2 0.4"',
    "sphere": 'type="sphere" size="0.35"',
    "cylinder": 'type="cylinder" size="0.2 0.5"',
    "capsule": 'type="capsule" size="0.15 0.4"',
    "ellipsoid": 'type="ellipsoid" size="0.2 0.3 0.5"',
    "mesh": 'type="mesh" mesh="wedge"',
    "hfield": 'type="hfield" hfield="hill"',
}
ASSETS = """<asset>
  <mesh name="wedge" vertex="-0.5 -0.5 0 0.5 -0.5 0 -0.5 0.5 0 0.5 0.5 0 0.5 -0.5 0.7 0.5 0.5 0.7"/>
  <hfield name="hill" nrow="3" ncol="3" size="0.8 0.8 0.4 0.1" elevation="0 0.2 0 0.5 1 0.1 0 0 0.3"/>
</asset>"""


class Looker:
    """A world and both ways to look at it."""

    def __init__(self, scene):
        self.world = World([DroneConfig("far", FAR)], scene=scene, visuals=False)
        self.model, self.data = self.world.model, self.world.data
        self._own = self.model.body("far").id

    def ours(self, point, direction, cone=1.0, self_index=-1):
        vector = ffi.new("float[3]", direction)
        addresses = self.model._address, self.data._address
        return lib.cf_plugin_look(*addresses, self_index, ffi.new("float[3]", point), vector, cone, REACH)

    def theirs(self, point, direction):
        """Return MuJoCo's min distance (m) over all colliding geoms, with infinite planes."""
        geom = np.zeros(1, np.int32)
        groups = np.zeros(6, np.uint8)
        groups[5] = 1
        keep = (self.model.geom_contype != 0) | (self.model.geom_conaffinity != 0)
        group, size = self.model.geom_group.copy(), self.model.geom_size.copy()
        self.model.geom_group[:] = np.where(keep, 5, 0)
        self.model.geom_size[self.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE, :2] = 0
        found = mujoco.mj_ray(
            self.model,
            self.data,
            np.float64(np.float32(point)),
            np.float64(np.float32(direction)),
            groups,
            1,
            self._own,
            geom,
        )
        self.model.geom_group[:], self.model.geom_size[:] = group, size
        return min(found, REACH) if found >= 0 else REACH


def unit(vector):
    return [float(value) for value in np.asarray(vector) / np.linalg.norm(vector)]


def points(side, low, high):
    return st.tuples(*[st.floats(-side, side)] * 2, st.floats(low, high)).map(list)


directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda vector: np.linalg.norm(vector) > 0.1).map(unit)


@pytest.fixture(scope="module", params=SCENES)
def looker(request):
    return Looker(request.param)


@settings(max_examples=60)
@given(point=points(1.9, 0.05, 2.4), direction=directions)
def test_rays_in_our_scenes_are_those_of_mujoco(looker, point, direction):
    assert looker.ours(point, direction) == pytest.approx(looker.theirs(point, direction), abs=1e-5)


@pytest.fixture(scope="module", params=[*GEOMS, "all"])
def clutter(request, tmp_path_factory):
    """Forty geoms of one kind, or of all, at random poses, some on bodies, over a tilted plane."""
    dice = np.random.default_rng(3)
    kinds = [request.param] if request.param in GEOMS else list(GEOMS)
    parts = ['<geom type="plane" size="1 1 0.1" pos="0 0 -0.5" euler="10 5 0"/>']
    for i in range(40):
        position = " ".join(f"{value:.3f}" for value in dice.uniform([-4, -4, 0], [4, 4, 4]))
        euler = " ".join(f"{value:.1f}" for value in dice.uniform(-180, 180, 3))
        geom = f"<geom {GEOMS[kinds[i % len(kinds)]]}"
        if i % 3:
            parts.append(f'{geom} pos="{position}" euler="{euler}"/>')
        else:
            parts.append(
                f'<body pos="{position}" euler="{euler}"><body pos="0.1 0 0" euler="0 20 0">{geom}/></body></body>'
            )
    parts.append('<geom type="sphere" size="3" contype="0" conaffinity="0"/>')
    path = tmp_path_factory.mktemp("clutter") / "clutter.xml"
    path.write_text(f"<mujoco>{ASSETS}<worldbody>{''.join(parts)}</worldbody></mujoco>")
    return Looker(path)


@settings(max_examples=60)
@given(point=points(4.0, 0.0, 4.0), direction=directions)
def test_rays_through_clutter_are_those_of_mujoco(clutter, point, direction):
    assert clutter.ours(point, direction) == pytest.approx(clutter.theirs(point, direction), abs=1e-5)


@pytest.mark.parametrize(("reach", "expected"), [(0.9, 0.9), (6.0, 1.0)])
def test_reach_limits_what_is_found(reach, expected):
    looker = Looker("arena")
    point, down = ffi.new("float[3]", [0, 0, 1]), ffi.new("float[3]", [0, 0, -1])
    found = lib.cf_plugin_look(looker.model._address, looker.data._address, -1, point, down, 1.0, reach)
    assert found == pytest.approx(expected)


def test_a_plane_has_no_end_and_one_face():
    looker = Looker("flight_lab")  # its floor is drawn 8 m long
    assert looker.ours([50.0, 0.0, 1.0], [0.0, 0.0, -1.0]) == 1.0
    assert looker.ours([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]) == pytest.approx(4.5)  # through the floor to the ceiling
