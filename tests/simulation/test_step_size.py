"""What the step of 1 ms costs in accuracy: tumbling, and a long figure-8."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crazychoir_fw.mujoco_models import model_path
from crazychoir_fw.simulation import DroneConfig, World

STILL_AIR = {"drag": "none", "body_drag": 0, "flight_moment": "off"}


FREE_BODY = """
<mujoco>
  <option timestep="1e-5" gravity="0 0 0" integrator="RK4"/>
  <worldbody>
    <body>
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>
    </body>
  </worldbody>
</mujoco>
"""


def free_rotation(body, rates, seconds):
    """Return the attitude that a free body of the same mass and inertia has by Runge-Kutta in steps of 10 us."""
    inertia = " ".join(map(repr, body.inertia.tolist()))
    model = mujoco.MjModel.from_xml_string(FREE_BODY.format(mass=body.mass[0], inertia=inertia))
    data = mujoco.MjData(model)
    data.qvel[3:] = rates
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    return Rotation.from_quat(np.roll(data.qpos[3:7], -1))


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.8, 0.5, 0.33), (0.3, 0.4, -0.87), (0.05, 1.0, 0.02)])
def test_tumbling_drone_keeps_its_attitude(direction):
    """20 rad/s for 2 s in steps of 1 ms beside Runge-Kutta of degree 4 in steps of 10 us: 0.1 deg."""
    world = World([DroneConfig("cf1", (0.0, 0.0, 50.0), attributes=STILL_AIR)], visuals=False)
    world.model.opt.gravity[:] = 0.0
    rates = 20.0 * np.array(direction) / np.linalg.norm(direction)
    world.data.qvel[3:6] = rates
    body = world.model.body("cf1")
    energy = body.inertia @ rates**2
    world.run(2.0)
    error = Rotation.from_quat(np.roll(world["cf1"].true_quat_wxyz, -1)).inv() * free_rotation(body, rates, 2.0)
    assert np.degrees(error.magnitude()) < 0.1
    assert body.inertia @ world["cf1"].true_rates ** 2 == pytest.approx(energy, rel=1e-3)


def scene_with_step(folder, step):
    text = model_path("arena").read_text().replace('timestep="0.001"', f'timestep="{step}"')
    path = folder / f"arena_{step}.xml"
    path.write_text(text)
    return path


def figure_8(scene, seconds):
    """Fly a figure-8 without any noise and return the positions (m) at 100 Hz."""
    attributes = {"supply_voltage": 3.9, "bias": 0, "mocap_noise": 0}
    world = World([DroneConfig("cf1", noise=0, attributes=attributes)], scene=scene, visuals=False)
    world.wait_until_ready()
    drone = world["cf1"]
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(8.0 - world.time)  # what the floor did to a drone that took off is forgotten
    positions = []
    for k in range(round(seconds * 100)):
        phase = 2 * np.pi * k / 600  # one turn in 6 s, up to 0.8 m/s
        velocity = 2 * np.pi / 6 * np.array([0.5 * np.cos(phase), 0.5 * np.cos(2 * phase), 0.0])
        place = (0.5 * np.sin(phase), 0.25 * np.sin(2 * phase), 1.0)
        drone.commander.send_full_state_setpoint(place, velocity, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), 0.0, 0.0, 0.0)
        world.step(10)
        positions.append(drone.true_position)
    return np.array(positions)


def test_steps_of_1_ms_are_short_enough(tmp_path):
    """60 s of figure-8 in steps of 1 ms and 0.25 ms differ by less than 1 mm."""
    coarse, fine = (figure_8(scene_with_step(tmp_path, step), 60.0) for step in ("0.001", "0.00025"))
    assert np.ptp(coarse[:, 0]) > 0.8
    assert np.linalg.norm(coarse - fine, axis=1).max() < 1e-3


def test_free_fall_keeps_its_energy():
    """A drone that falls and tumbles in a vacuum: energy within 0.1 %, path as by hand, for 3 s."""
    world = World([DroneConfig("cf1", (0.0, 0.0, 100.0), attributes=STILL_AIR)], visuals=False)
    drone = world["cf1"]
    world.data.qvel[:6] = 3.0, 0.0, 2.0, 4.0, -3.0, 5.0
    inertia, mass = world.model.body("cf1").inertia, world.model.body("cf1").mass[0]

    def energy():
        kinetic = mass * drone.true_velocity @ drone.true_velocity + inertia @ drone.true_rates**2
        return kinetic / 2 + mass * 9.81 * drone.true_position[2]

    before = energy()
    world.run(3.0)
    assert energy() == pytest.approx(before, rel=1e-3)
    # the first-order step is half a step of velocity ahead: 1/2 g h t
    assert drone.true_position == pytest.approx([9.0, 0.0, 100.0 + 6.0 - 9.81 * 4.5], abs=0.02)
    assert inertia @ drone.true_rates**2 == pytest.approx(inertia @ np.square([4.0, -3.0, 5.0]), rel=1e-4)
