"""The engine plugin by itself: any MJCF that names it flies, and bad attributes end in one sentence."""

import copy

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import crazychoir_fw  # noqa: F401 - registers the plugin
from crazychoir_fw._core import lib
from crazychoir_fw.onboard import core

MJCF = """
<mujoco>
  <option timestep="{timestep}" integrator="{integrator}"><flag sleep="{sleep}" gravity="{gravity}"/></option>
  <extension>
    <plugin plugin="crazychoir.crazyflie">
      <instance name="brain">{attributes}</instance>
    </plugin>
  </extension>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="bird" pos="0 0 {height}">
      {joint}
      <inertial pos="0 0 0" mass="0.029" diaginertia="16.57e-6 16.66e-6 29.26e-6"/>
      <geom type="box" size="0.05 0.05 0.0145" solref="0.01 1"/>
      <plugin plugin="crazychoir.crazyflie" instance="brain"/>
    </body>
  </worldbody>
</mujoco>
"""


def compile_mjcf(
    attributes=None,
    timestep=0.001,
    integrator="Euler",
    sleep="disable",
    joint="<freejoint/>",
    gravity="enable",
    height=0.0145,
):
    keys = "".join(f'<config key="{key}" value="{value}"/>' for key, value in (attributes or {}).items())
    return mujoco.MjModel.from_xml_string(
        MJCF.format(
            attributes=keys,
            timestep=timestep,
            integrator=integrator,
            sleep=sleep,
            joint=joint,
            gravity=gravity,
            height=height,
        )
    )


def drone_of(data):
    return core.struct_view("cf_t", core.address_of(data.plugin_state))


def run(model, data, seconds):
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))


def test_whole_drone_lives_in_the_plugin_state():
    model = compile_mjcf()
    assert model.npluginstate * 8 == lib.cf_state_bytes(0)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit", "RK4"])
@pytest.mark.parametrize("timestep", [0.0005, 0.001, 0.002])
def test_any_mjcf_that_names_the_plugin_flies(integrator, timestep):
    model = compile_mjcf(integrator=integrator, timestep=timestep)
    data = mujoco.MjData(model)
    run(model, data, 2.0)
    assert lib.cf_takeoff(drone_of(data), 0.5, 1.5, 0.0, True) == lib.CF_OK
    run(model, data, 8.0)
    assert data.qpos[:3] == pytest.approx([0.0, 0.0, 0.5], abs=0.05)
    assert drone_of(data).onboard.tick == 10_000


def test_reading_forces_has_no_side_effect():
    model = compile_mjcf()
    data = mujoco.MjData(model)
    run(model, data, 2.0)
    lib.cf_takeoff(drone_of(data), 0.5, 1.5, 0.0, True)
    run(model, data, 1.0)
    mujoco.mj_forward(model, data)
    state, force = data.plugin_state.tobytes(), data.qfrc_passive.copy()
    mujoco.mj_forward(model, data)
    mujoco.mj_forward(model, data)
    assert data.plugin_state.tobytes() == state
    assert np.array_equal(data.qfrc_passive, force)
    assert force[2] > 0.2


def test_copy_of_the_data_flies_the_same_flight():
    model = compile_mjcf()
    data = mujoco.MjData(model)
    run(model, data, 2.0)
    lib.cf_takeoff(drone_of(data), 0.5, 1.5, 0.0, True)
    run(model, data, 0.7)
    twin = copy.copy(data)
    run(model, data, 1.0)
    run(model, twin, 1.0)
    assert data.plugin_state.tobytes() == twin.plugin_state.tobytes()
    assert np.array_equal(data.qpos, twin.qpos)


def test_reset_data_boots_again():
    model = compile_mjcf()
    data = mujoco.MjData(model)
    run(model, data, 2.0)
    assert drone_of(data).onboard.step > 0
    mujoco.mj_resetData(model, data)
    assert drone_of(data).onboard.tick == 0
    assert drone_of(data).onboard.step == 0


def test_accelerometer_reads_one_g_at_rest_and_nothing_in_free_fall():
    for height, seconds, expected in ((0.0145, 1.6, 1.0), (40.0, 1.6, 0.0)):
        model = compile_mjcf({"noise": 0, "bias": 0, "body_drag": 0}, height=height)
        data = mujoco.MjData(model)
        run(model, data, seconds)
        assert drone_of(data).onboard.sensors.data.acc.z == pytest.approx(expected, abs=0.01)


def test_sleeping_drone_wakes_when_its_rotors_push():
    model = compile_mjcf(sleep="enable")
    data = mujoco.MjData(model)
    run(model, data, 3.0)
    assert data.tree_asleep[0] >= 0
    assert drone_of(data).onboard.sensors.data.acc.z == pytest.approx(1.0, abs=0.05)
    assert lib.cf_takeoff(drone_of(data), 0.5, 1.5, 0.0, True) == lib.CF_OK
    run(model, data, 4.0)
    assert data.qpos[2] == pytest.approx(0.5, abs=0.06)


INERTIA = np.array([16.57e-6, 16.66e-6, 29.26e-6])


def tumbling_reference(rates, seconds):
    """Return the attitude of a free body after some time, by an integration of Euler's equations at 1e-12."""

    def derivative(_, y):
        q, w = y[:4], y[4:]
        dq = 0.5 * np.array(
            [
                -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
                q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
                q[0] * w[1] - q[1] * w[2] + q[3] * w[0],
                q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
            ]
        )
        return [*dq, *(-np.cross(w, INERTIA * w) / INERTIA)]

    solution = solve_ivp(derivative, (0, seconds), [1, 0, 0, 0, *rates], method="DOP853", rtol=1e-12, atol=1e-12)
    return solution.y[:4, -1]


@pytest.mark.parametrize(("integrator", "limit_deg"), [("Euler", 0.2), ("RK4", 0.01)])
def test_tumbling_body_keeps_its_attitude_and_energy(integrator, limit_deg):
    """21 rad/s for 2 s: plain Euler is wrong by 20 degrees; the midpoint gyroscopic torque repairs it."""
    rates = np.array([18.0, 9.0, 6.0])
    model = compile_mjcf({"drag": "none", "body_drag": 0, "flight_moment": "off"}, gravity="disable", height=5.0)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)
    data.qvel[3:6] = rates
    run(model, data, 2.0)
    expected = Rotation.from_quat(np.roll(tumbling_reference(rates, 2.0), -1))
    error = Rotation.from_quat(np.roll(data.qpos[3:7], -1)).inv() * expected
    assert np.degrees(error.magnitude()) < limit_deg
    energy = INERTIA @ data.qvel[3:6] ** 2 / (INERTIA @ rates**2)
    assert energy == pytest.approx(1.0, abs=1e-3)


# ---------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"joint": ""}, "crazyflie bird: the body has no free joint"),
        ({"joint": '<joint type="hinge"/>'}, "crazyflie bird: the body has no free joint"),
        ({"timestep": 0.0015}, "timestep is 0.0015 s, allowed: 0.001 s times or divided by a whole"),
        ({"timestep": 0.05}, "timestep is 0.05 s"),
        ({"attributes": {"platform": "cf9"}}, r"crazyflie bird: platform is 'cf9', allowed: cf2 \| cf21bl"),
        ({"attributes": {"battery": "full"}}, "crazyflie bird: battery is 'full', allowed: 0 to 1"),
        ({"attributes": {"battery": "nan"}}, "crazyflie bird: battery is 'nan', allowed: 0 to 1"),
        ({"attributes": {"seed": "1.5"}}, "crazyflie bird: seed is '1.5', allowed: whole number 0 to 4294967295"),
        (
            {"attributes": {"mocap_rate": "1000", "mocap_latency_ms": "500"}},
            "crazyflie bird: .*mocap_latency_ms",
        ),
        ({"attributes": {"wings": "2"}}, "wings"),
        (
            {"attributes": {"controller": "out_of_tree"}},
            r"provider 'builtin' has none of that name, allowed: auto \| pid \| mellinger \| .* \| lee$",
        ),
        (
            {"attributes": {"estimator": "out_of_tree"}},
            r"provider 'builtin' has none of that name, allowed: auto \| complementary \| kalman$",
        ),
    ],
)
def test_bad_model_ends_in_one_sentence(changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        compile_mjcf(**changes)


NAMES = sorted(core.attributes())


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(NAMES),
    st.text(st.characters(codec="ascii", exclude_characters='<>&"', categories=["L", "N", "P", "S"])),
)
def test_every_text_is_an_attribute_or_a_sentence(name, text):
    """Fuzz: an attribute is accepted, or the error names key, value and what is allowed."""
    try:
        model = compile_mjcf({name: text})
    except ValueError as error:
        assert name in str(error)
        assert text[:60] in str(error)
        assert "allowed: " in str(error)
    else:
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, nstep=5)
        assert np.all(np.isfinite(data.qpos))


def test_attributes_document_themselves():
    table = core.attributes()
    assert table["platform"][0] == "cf2 | cf21bl"
    assert all(meaning and allowed for allowed, meaning in table.values())


def test_steps_do_not_read_the_clock_of_the_machine():
    model = compile_mjcf()
    data = mujoco.MjData(model)
    run(model, data, 0.01)
    assert data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration == 0


def test_whoever_wants_to_know_where_mujoco_spends_its_time_can():
    model = compile_mjcf()
    data = mujoco.MjData(model)
    mujoco.set_mjcb_time(None)
    try:
        run(model, data, 0.01)
    finally:
        lib.cf_plugin_stop_clock()
    assert data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration > 0


def test_instance_without_a_body_is_refused():
    model = """
      <mujoco>
        <extension><plugin plugin="crazychoir.crazyflie"><instance name="alone"/></plugin></extension>
        <worldbody><body><freejoint/><geom size="0.1" mass="1"/></body></worldbody>
      </mujoco>
    """
    with pytest.raises(ValueError, match="plugin instance 0 is not used by any body"):
        mujoco.MjModel.from_xml_string(model)
