"""The wash of the propellers on the barometer belongs to what is straight below, not to the floor of the world."""

import pytest

from crazychoir_fw.simulation import DroneConfig, World

TABLE = """
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <geom type="box" size="0.5 0.5 0.5" pos="3 0 0.5"/>
  </worldbody>
</mujoco>
"""


@pytest.mark.parametrize("ground_effect", [True, False])
def test_a_table_shifts_the_barometer_as_the_floor_does(tmp_path, ground_effect):
    scene = tmp_path / "table.xml"
    scene.write_text(TABLE)
    quiet = {"barometer.noise": 0.0, "barometer.drift": 0.0, "barometer.wash_low": 0.4, "barometer.wash_high": 0.4}
    quiet["ground_effect.enabled"] = ground_effect
    places = {"floor": (0.0, 0.0), "table": (3.0, 0.0, 1.0145)}
    world = World([DroneConfig(name, place, vehicle=quiet) for name, place in places.items()], scene=scene)
    world.wait_until_ready()
    still = [drone.log["baro.asl"] for drone in world.drones]
    for drone in world.drones:
        # not enough to take off, at once three quarters of the speed in hover
        drone.param["motorPowerSet.enable"] = 2
        drone.param["motorPowerSet.m1"] = 25000
    world.run(2.0)
    shifts = [drone.log["baro.asl"] - before for drone, before in zip(world.drones, still, strict=True)]
    assert shifts[0] > 0.08
    assert shifts[1] == pytest.approx(shifts[0], abs=0.02)
