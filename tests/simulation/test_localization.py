"""What a positioning system tells a drone handle."""

import pytest

from crazychoir_fw.common.errors import RangeError

NOT_NUMBERS = [float("nan"), float("inf"), -float("inf")]


def test_position_and_pose_reach_the_drone(ready_world) -> None:
    drone = ready_world.drones[0]
    drone.loc.send_extpos([0.01, 0.02, 0.03])
    assert drone.log["ext_pos.X"] == pytest.approx(0.01)
    ready_world.run(0.005)
    drone.loc.send_extpose((0.01, 0.02, 0.04), [0, 0, 0, 1])
    assert drone.log["locSrv.z"] == pytest.approx(0.04)
    assert drone.log["locSrvZ.tick"] == drone.struct.onboard.tick


@pytest.mark.parametrize("value", NOT_NUMBERS)
def test_what_is_no_number_is_refused_in_words(ready_world, value: float) -> None:
    drone = ready_world.drones[0]
    before = drone.memory.tobytes()
    with pytest.raises(RangeError, match="cf1: send_extpos"):
        drone.loc.send_extpos([0, value, 0])
    with pytest.raises(RangeError, match="cf1: send_extpose"):
        drone.loc.send_extpose([0, 0, 0], [0, 0, value, 1])
    assert drone.memory.tobytes() == before


def test_vector_of_another_shape_is_refused_in_words(ready_world) -> None:
    loc = ready_world.drones[0].loc
    with pytest.raises(RangeError, match=r"cf1: send_extpos: shape \(2,\), allowed: \(3,\)"):
        loc.send_extpos([0, 0])
    with pytest.raises(RangeError, match=r"cf1: send_extpose: shape \(3,\), allowed: \(4,\)"):
        loc.send_extpose([0, 0, 0], [0, 0, 1])


def test_emergency_stop_locks_the_drone(hovering_world) -> None:
    drone = hovering_world.drones[0]
    drone.loc.send_emergency_stop()
    hovering_world.run(0.1)
    assert drone.is_locked
    assert drone.log["motor.m1"] == 0


def test_emergency_stop_after_a_landing_does_not_wait_for_the_reset(hovering_world) -> None:
    drone = hovering_world.drones[0]
    drone.high_level_commander.land(0.0, 1.0)
    hovering_world.run(5.0)
    assert drone.supervisor_state == "Landed"
    drone.emergency_stop()
    hovering_world.run(0.04)
    assert not drone.can_fly
    hovering_world.run(0.16)
    assert drone.is_locked


def test_watchdog_stops_the_drone_a_second_after_it_was_last_fed(hovering_world) -> None:
    drone = hovering_world.drones[0]
    for _ in range(4):
        drone.loc.send_emergency_stop_watchdog()
        hovering_world.run(0.95)
        assert drone.is_flying
    hovering_world.run(0.04)
    assert drone.is_flying  # 990 ms
    hovering_world.run(0.1)
    assert drone.is_locked
