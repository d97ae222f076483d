"""Vehicles and scenes against the numbers of docs/reference/vehicle.md#1, #2, #12.4 and #18."""

import runpy

import mujoco
import numpy as np
import pytest

from crazychoir_fw.mujoco_models import SCENES, VEHICLES, model_path
from crazychoir_fw.mujoco_models.stamp import VehicleStamp

# platform: mass (kg), inertia (kg m^2), half width of the hull (m), height of the origin when landed (m);
# docs/reference/vehicle.md#18
NUMBERS = {
    "cf2": (0.029, (16.571710e-6, 16.655602e-6, 29.261652e-6), 0.055, 0.0145),
    "cf21bl": (0.0393, (25e-6, 28e-6, 49e-6), 0.07, 0.0175),
}


def vehicle(name: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(model_path(name)))


def world(*drones: tuple[str, tuple[float, float, float]], scene: str = "arena") -> mujoco.MjModel:
    """Return a scene with drones (airframe, position) called cf0, cf1, ..."""
    spec = mujoco.MjSpec.from_file(str(model_path(scene)))
    stamps = {name: VehicleStamp(spec, name) for name in dict.fromkeys(name for name, _ in drones)}
    for k, (name, position) in enumerate(drones):
        stamps[name].place(f"cf{k}", position)
    return spec.compile()


@pytest.mark.parametrize("name", [*VEHICLES, *SCENES])
def test_every_model_compiles(name):
    assert mujoco.MjModel.from_xml_path(str(model_path(name))).nbody > 1


@pytest.mark.parametrize("name", ["", "cf3", "../pyproject", "crazyflie_2.xml"])
def test_an_unknown_model_is_refused_with_the_known_ones(name):
    with pytest.raises(ValueError, match="cf21bl"):
        model_path(name)


@pytest.mark.parametrize("name", VEHICLES)
def test_mass_and_inertia_are_those_of_the_reference(name):
    model = vehicle(name)
    mass, inertia, _, _ = NUMBERS[name]
    body = model.body("crazyflie")
    assert body.mass[0] == mass
    # MuJoCo orders the principal axes by size and turns the inertial frame accordingly
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    turn = turn.reshape(3, 3)
    np.testing.assert_allclose(turn @ np.diag(body.inertia) @ turn.T, np.diag(inertia), rtol=1e-12, atol=1e-18)
    np.testing.assert_array_equal(body.ipos, np.zeros(3))
    assert model.body_subtreemass[0] == mass


@pytest.mark.parametrize("name", VEHICLES)
def test_hull_reaches_down_to_the_feet(name):
    model = vehicle(name)
    _, _, half_width, height = NUMBERS[name]
    hull = model.geom("hull")
    np.testing.assert_allclose(hull.size[:2], half_width)
    assert hull.pos[2] - hull.size[2] == pytest.approx(-height, abs=1e-12)
    assert model.body("crazyflie").pos[2] == height


@pytest.mark.parametrize("name", VEHICLES)
def test_one_free_joint_and_nothing_else_moves(name):
    model = vehicle(name)
    assert model.joint("root").type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert (model.nq, model.nv, model.nu, model.nsensor) == (7, 6, 0, 0)
    assert not model.dof_damping.any() and not model.dof_armature.any()


@pytest.mark.parametrize("name", VEHICLES)
def test_what_touches_has_the_recommended_contact(name):
    model = vehicle(name)
    geom = model.geom("hull")
    np.testing.assert_array_equal(geom.solref, [0.01, 1.0])
    np.testing.assert_array_equal(geom.friction, [0.6, 0.005, 0.0001])
    assert geom.condim[0] == 3
    assert geom.group[0] == 3


@pytest.mark.parametrize("name", VEHICLES)
def test_what_shows_is_cheap_and_never_touches(name):
    model = vehicle(name)
    seen = np.flatnonzero(model.geom_group == 2)
    assert sorted(model.geom(k).name for k in seen) == ["accent", "body"]
    assert not model.geom_contype[seen].any() and not model.geom_conaffinity[seen].any()
    assert model.ngeom == 3
    assert model.nmeshface < 2500


@pytest.mark.parametrize("name", VEHICLES)
def test_the_drawing_has_the_size_of_the_airframe(name):
    model = vehicle(name)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geom = model.geom("body")
    mesh = model.mesh(geom.dataid[0])
    vertices = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
    placed = vertices @ data.geom_xmat[geom.id].reshape(3, 3).T + data.geom_xpos[geom.id]
    assert placed[:, 2].min() == pytest.approx(0.0, abs=1e-5)  # stands on the floor
    reach = {"cf2": 0.056, "cf21bl": 0.070}[name]
    assert np.abs(placed[:, :2]).max() == pytest.approx(reach, abs=0.004)
    assert placed[:, 2].max() < 0.04


def test_meshes_are_those_that_the_drawing_script_writes():
    folder = model_path("cf2").parent
    drawings = runpy.run_path(str(folder / "make_assets.py"))["drawings"]()
    assert drawings
    for name, text in drawings.items():
        assert (folder / "assets" / name).read_text() == text, f"{name} is old: run make_assets.py"


@pytest.mark.parametrize("name", SCENES)
def test_physics_options_are_those_of_the_reference(name):
    option = mujoco.MjModel.from_xml_path(str(model_path(name))).opt
    assert option.timestep == 0.001
    assert option.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert option.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    assert (option.density, option.viscosity) == (0.0, 0.0)
    np.testing.assert_array_equal(option.gravity, [0.0, 0.0, -9.81])


@pytest.mark.parametrize("name", SCENES)
def test_scenes_have_the_cameras_and_no_moving_part(name):
    model = mujoco.MjModel.from_xml_path(str(model_path(name)))
    assert [model.camera(k).name for k in range(model.ncam)] == ["overview", "track"]
    assert (model.nq, model.nmocap) == (0, 0)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", VEHICLES)
def test_a_drone_lands_tilted_and_rests_upright(name, scene):
    """-0.3 m/s, tilt of 3 deg, slip of 0.1 m/s; 6.7 um at rest, rebound 0.08 m/s, peak 11.8 g.

    docs/reference/vehicle.md#12.4.
    """
    height = NUMBERS[name][3]
    model = world((name, (0.0, 0.0, height + 0.015)), scene=scene)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    tilt = np.radians(3.0)
    data.qpos[3:7] = np.cos(tilt / 2.0), 0.0, np.sin(tilt / 2.0), 0.0
    data.qvel[:3] = 0.1, 0.0, -0.3

    climbs, peak = [], 0.0
    for _ in range(3000):
        before = data.qvel[:3].copy()
        mujoco.mj_step(model, data)
        force = (data.qvel[:3] - before) / model.opt.timestep - model.opt.gravity
        peak = max(peak, np.linalg.norm(force) / 9.81)
        climbs.append(data.qvel[2])

    assert height - data.qpos[2] == pytest.approx(6.7e-6, rel=0.01)
    assert max(climbs) == pytest.approx(0.08, abs=0.015)
    assert peak == pytest.approx(11.8, abs=2.0)
    assert np.abs(data.qacc[:3]).max() < 1e-6  # m/s^2, docs/reference/vehicle.md#14.4
    assert data.qpos[3] == pytest.approx(1.0, abs=1e-12)
    assert data.ncon == 4


@pytest.mark.parametrize("name", VEHICLES)
def test_a_drone_on_its_back_rests_on_its_hull(name):
    model = world((name, (0.0, 0.0, 0.05)))
    data = mujoco.MjData(model)
    data.qpos[3:7] = 0.0, 1.0, 0.0, 0.0
    mujoco.mj_step(model, data, 1500)
    assert data.qpos[2] == pytest.approx(0.014, abs=1e-4)
    assert {model.geom(k).name for k in data.contact.geom.flat} == {"floor", "cf0/hull"}


def test_drones_collide_and_do_not_pass_through_each_other():
    model = world(("cf2", (0.0, 0.0, 1.0)), ("cf21bl", (0.2, 0.0, 1.0)))
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    data.qvel[0] = 1.0
    touched = False
    for _ in range(400):
        mujoco.mj_step(model, data)
        touched |= {model.geom(k).name for k in data.contact.geom.flat} == {"cf0/hull", "cf1/hull"}
    assert touched
    assert data.qvel[6] > data.qvel[0]  # the one behind is the slower one now
    assert data.qvel[6] > 0.1


def test_a_floor_with_default_contact_bits_carries_the_hull():
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(name="slab", type=mujoco.mjtGeom.mjGEOM_BOX, size=[1.0, 1.0, 0.1], pos=[0.0, 0.0, -0.1])
    VehicleStamp(spec, "cf2").place("cf0", (0.0, 0.0, 0.02))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 1000)
    assert data.qpos[2] == pytest.approx(0.0145, abs=2e-5)


def test_stamped_drones_equal_the_file_and_share_its_meshes():
    one = vehicle("cf2")
    many = world(*[("cf2", (0.3 * k, 0.0, 1.0)) for k in range(5)])
    assert many.nmesh == one.nmesh
    assert many.ntex == 3  # sky, grid, palette
    for k in range(5):
        body, joint = many.body(f"cf{k}"), many.joint(f"cf{k}/root")
        assert joint.bodyid[0] == body.id
        np.testing.assert_array_equal(many.qpos0[joint.qposadr[0] :][:7], [0.3 * k, 0, 1, 1, 0, 0, 0])
        np.testing.assert_array_equal(body.inertia, one.body("crazyflie").inertia)
        for part in ("hull", "body", "accent"):
            ours, theirs = many.geom(f"cf{k}/{part}"), one.geom(part)
            for field in ("type", "size", "pos", "quat", "contype", "conaffinity", "condim", "priority", "group"):
                np.testing.assert_array_equal(getattr(ours, field), getattr(theirs, field), err_msg=field)
            for field in ("friction", "solref", "solimp", "margin", "gap", "rgba"):
                np.testing.assert_array_equal(getattr(ours, field), getattr(theirs, field), err_msg=field)
    assert many.body_mass.sum() == pytest.approx(5 * 0.029)


def test_a_drone_can_have_its_own_color():
    spec = mujoco.MjSpec.from_file(str(model_path("arena")))
    stamp = VehicleStamp(spec, "cf2")
    stamp.place("red", (0, 0, 1), rgba=(1.0, 0.0, 0.0, 1.0))
    stamp.place("plain", (1, 0, 1))
    model = spec.compile()
    np.testing.assert_array_equal(model.geom("red/accent").rgba, [1, 0, 0, 1])
    np.testing.assert_array_equal(model.geom("plain/accent").rgba, np.float32([0.5, 0.5, 0.5, 1.0]))


def test_a_stamped_world_can_be_saved_and_read_again(tmp_path):
    spec = mujoco.MjSpec.from_file(str(model_path("flight_lab")))
    for name in VEHICLES:
        VehicleStamp(spec, name).place(name, (0.0, 0.0, 1.0))
    model = spec.compile()
    path = tmp_path / "world.xml"
    path.write_text(spec.to_xml())
    again = mujoco.MjModel.from_xml_path(str(path))
    assert (again.ngeom, again.nmesh, again.nq) == (model.ngeom, model.nmesh, 14)


def test_a_stamp_tells_how_high_a_landed_drone_sits():
    spec = mujoco.MjSpec()
    heights = {name: VehicleStamp(spec, name).rest_height for name in VEHICLES}
    assert heights == {name: numbers[3] for name, numbers in NUMBERS.items()}
