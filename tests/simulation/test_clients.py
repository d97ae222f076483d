import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart, Poly4D

NOT_NUMBERS = [float("nan"), float("inf"), -float("inf")]


def calls(value):
    """Every command with one argument that is no number."""
    return {
        "send_setpoint": lambda c, h: c.send_setpoint(value, 0, 0, 0),
        "send_velocity_world_setpoint": lambda c, h: c.send_velocity_world_setpoint(0, value, 0, 0),
        "send_zdistance_setpoint": lambda c, h: c.send_zdistance_setpoint(0, 0, 0, value),
        "send_hover_setpoint": lambda c, h: c.send_hover_setpoint(0, 0, value, 0.5),
        "send_position_setpoint": lambda c, h: c.send_position_setpoint(value, 0, 0, 0),
        "send_setpoint_manual": lambda c, h: c.send_setpoint_manual(0, value, 0, 50, False),
        "send_full_state_setpoint": lambda c, h: c.send_full_state_setpoint(
            [0, 0, value], [0, 0, 0], [0, 0, 0], [0, 0, 0, 1], 0, 0, 0
        ),
        "takeoff": lambda c, h: h.takeoff(value, 1.0),
        "land": lambda c, h: h.land(0.0, value),
        "go_to": lambda c, h: h.go_to(0, value, 1, 0, 1.0),
        "spiral": lambda c, h: h.spiral(1.0, 0.5, value, 0.2, 2.0),
        "upload_trajectory": lambda c, h: h.upload_trajectory(1, np.full((1, 33), value)),
        "start_trajectory": lambda c, h: h.start_trajectory(1, time_scale=value),
    }


@pytest.mark.parametrize("value", NOT_NUMBERS)
@pytest.mark.parametrize("name", calls(0.0))
def test_what_is_no_number_is_refused(ready_world, name, value):
    drone = ready_world.drones[0]
    before = drone.memory.tobytes()
    with pytest.raises((RangeError, ValueError), match="cf1"):
        calls(value)[name](drone.commander, drone.high_level_commander)
    assert drone.memory.tobytes() == before


def test_take_off_while_flying_is_refused_in_words(ready_world):
    commander = ready_world.drones[0].high_level_commander
    commander.takeoff(0.5, 1.0)
    with pytest.raises(StateError, match="cf1: takeoff.*stopped planner"):
        commander.takeoff(0.5, 1.0)


def test_command_before_the_drone_is_ready_is_refused_in_words():
    from worlds import make_world

    world = make_world()
    world.run(1.6)
    with pytest.raises(StateError, match="cf1: takeoff.*blocked by the supervisor"):
        world.drones[0].high_level_commander.takeoff(0.5, 1.0)


def test_duration_of_zero_is_refused(ready_world):
    with pytest.raises(RangeError, match=r"cf1: takeoff\(absolute_height_m=0.5, duration_s=0"):
        ready_world.drones[0].high_level_commander.takeoff(0.5, 0.0)


def test_thrust_outside_its_range_is_refused(ready_world):
    with pytest.raises(RangeError, match=r"cf1: thrust 70000 is outside \[0, 65535\]"):
        ready_world.drones[0].commander.send_setpoint(0, 0, 0, 70000)


def test_low_level_setpoints_fly_after_the_high_level_commander_gave_way(hovering_world):
    drone = hovering_world.drones[0]
    for _ in range(300):
        drone.commander.send_hover_setpoint(0.2, 0.0, 0.0, 0.5)
        hovering_world.run(0.01)
    assert 0.3 < drone.true_position[0] < 0.7
    drone.commander.send_notify_setpoint_stop()
    drone.high_level_commander.land(0.0, 1.5)
    hovering_world.run(3.0)
    assert drone.true_position[2] < 0.03
    assert drone.failure is None


def test_silence_after_low_level_setpoints_levels_out_then_locks(hovering_world):
    """docs/reference/planner-commander.md#18, quirk 1."""
    drone = hovering_world.drones[0]
    drone.commander.send_position_setpoint(0, 0, 0.5, 0)
    hovering_world.run(0.6)
    assert drone.supervisor_state == "Warning, level out"
    hovering_world.run(1.5)
    assert drone.is_locked


def test_legacy_setpoint_needs_a_zero_to_unlock_the_thrust(ready_world):
    drone = ready_world.drones[0]
    drone.commander.send_setpoint(0, 0, 0, 30000)
    ready_world.run(0.1)
    assert drone.log["motor.m1"] == 0
    drone.commander.send_setpoint(0, 0, 0, 0)
    drone.commander.send_setpoint(0, 0, 0, 30000)
    ready_world.run(0.1)
    assert drone.log["motor.m1"] > 0


def test_full_state_setpoint_is_followed(hovering_world):
    drone = hovering_world.drones[0]
    for _ in range(400):
        drone.commander.send_full_state_setpoint([0.3, 0, 0.5], [0, 0, 0], [0, 0, 0], [0, 0, 0, 1], 0, 0, 0)
        hovering_world.run(0.01)
    assert drone.true_position == pytest.approx([0.3, 0, 0.5], abs=0.05)


def test_uploaded_trajectory_is_flown(hovering_world):
    drone = hovering_world.drones[0]
    pieces = np.zeros((2, 33))
    pieces[0, 1], pieces[0, 16], pieces[0, 32] = 0.2, 0.5, 2.0  # x = 0.2 t, z = 0.5
    pieces[1, 0], pieces[1, 16], pieces[1, 32] = 0.4, 0.5, 1.0
    assert drone.high_level_commander.upload_trajectory(3, pieces) == pytest.approx(3.0)
    drone.high_level_commander.start_trajectory(3)
    assert not drone.high_level_commander.is_trajectory_finished
    hovering_world.run(5.0)
    assert drone.high_level_commander.is_trajectory_finished
    assert drone.true_position == pytest.approx([0.4, 0, 0.5], abs=0.05)


def test_pieces_may_be_objects_as_in_cflib(ready_world):
    drone = ready_world.drones[0]
    pieces = [Poly4D(1.5, z=Poly4D.Poly([0.5] + [0.0] * 7)), Poly4D(0.5)]
    assert drone.high_level_commander.upload_trajectory(2, pieces, offset=132) == pytest.approx(2.0)
    memory = ffi.new("uint8_t[]", 264)
    assert lib.cf_read_trajectory(drone.struct, 132, 264, memory) == lib.CF_OK
    assert bytes(ffi.buffer(memory)) == pieces[0].pack() + pieces[1].pack()


def test_compressed_trajectory_is_flown(hovering_world):
    drone = hovering_world.drones[0]
    start = CompressedStart(0.0, 0.0, 0.5, 0.0)
    segments = [CompressedSegment(2.0, [0.0, 0.4, 0.4], [], [0.7], []), CompressedSegment(1.0, [], [], [], [])]
    assert drone.high_level_commander.upload_compressed_trajectory(3, start, segments, offset=1) == pytest.approx(3.0)
    drone.high_level_commander.start_trajectory(3)
    hovering_world.run(2.9)
    assert not drone.high_level_commander.is_trajectory_finished
    hovering_world.run(2.0)
    assert drone.high_level_commander.is_trajectory_finished
    assert drone.true_position == pytest.approx([0.4, 0, 0.7], abs=0.05)


def test_shorter_upload_leaves_no_stale_pieces(ready_world):
    """cflib appends no end marker, so that there the drone flies on (docs/reference/planner-commander.md#5.1)."""
    commander = ready_world.drones[0].high_level_commander
    segment = CompressedSegment(1.0, [0.1], [], [], [])
    commander.upload_compressed_trajectory(1, CompressedStart(0, 0, 0, 0), [segment] * 5)
    commander.upload_compressed_trajectory(1, CompressedStart(0, 0, 0, 0), [segment])
    commander.start_trajectory(1, relative_position=True)
    ready_world.run(1.1)
    assert commander.is_trajectory_finished


def test_compressed_trajectory_may_have_more_segments_than_a_byte_counts(ready_world):
    commander = ready_world.drones[0].high_level_commander
    segments = [CompressedSegment(0.01, [0.001 * (i % 2)], [], [], []) for i in range(600)]
    assert commander.upload_compressed_trajectory(1, CompressedStart(0, 0, 0, 0), segments) == pytest.approx(6.0)
    with pytest.raises(RangeError, match="cf1: upload_compressed_trajectory.*820 segments"):
        commander.upload_compressed_trajectory(1, CompressedStart(0, 0, 0, 0), segments[:410] * 2)


def test_compressed_trajectory_flies_at_its_own_pace_only(ready_world):
    commander = ready_world.drones[0].high_level_commander
    commander.upload_compressed_trajectory(1, CompressedStart(0, 0, 0, 0), [CompressedSegment(1.0, [], [], [1.0], [])])
    with pytest.raises(RangeError, match="cf1: start_trajectory"):
        commander.start_trajectory(1, time_scale=2.0)
    with pytest.raises(RangeError, match="cf1: start_trajectory"):
        commander.start_trajectory(1, reversed=True)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda h: h.define_trajectory(1, 0, 1, type=2), "type 0 or 1"),
        (lambda h: h.define_trajectory(1, -4, 1), "offset 0 to 4096"),
        (lambda h: h.define_trajectory(1, 0, 1000), "cf1: define_trajectory"),
        (lambda h: h.set_group_mask(256), r"group_mask 256 is outside \[0, 255\]"),
        (lambda h: h.upload_trajectory(1, np.zeros((2, 32))), r"cf1: pieces have shape \(2, 32\), allowed: \(n, 33\)"),
        (lambda h: h.upload_trajectory(1, np.ones((32, 33))), r"cf1: upload_trajectory\(1, 32 pieces"),
        (lambda h: h.upload_trajectory(31, np.ones((1, 33))), "cf1: upload_trajectory.*trajectory 0 to 30"),
        (lambda h: h.upload_trajectory(1, np.ones((1, 33)), offset=-4), "offset"),
        (lambda h: h.start_trajectory(9), "cf1: start_trajectory"),
    ],
)
def test_bad_trajectory_is_refused_in_words(ready_world, call, sentence):
    with pytest.raises((RangeError, UnknownNameError), match=sentence):
        call(ready_world.drones[0].high_level_commander)


def test_commands_with_a_speed_take_off_and_land(ready_world):
    """The firmware has them and cflib does not, so that they are in C only."""
    drone = ready_world.drones[0]
    assert lib.cf_takeoff_with_velocity(drone.struct, 0.5, False, 0.25, 0.0, True) == lib.CF_OK
    ready_world.run(4.0)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)
    assert lib.cf_land_with_velocity(drone.struct, 0.5, True, 0.25, 0.0, True) == lib.CF_OK
    ready_world.run(4.0)
    assert drone.true_position[2] < 0.03


def test_packets_of_port_8_command_the_drone(ready_world):
    drone = ready_world.drones[0]
    reply = ffi.new("uint8_t[4]")
    # docs/reference/crtp-cflib.md#21: takeoff(1.0, 2.0)
    takeoff = bytes.fromhex("07 00 0000803F 00000000 00 00000040")
    assert [lib.cf_high_level_packet(drone.struct, takeoff, len(takeoff), reply) for _ in range(2)] == [4, 4]
    assert list(reply) == [7, 0, 0, lib.CF_HIGH_LEVEL_REPLY_REFUSED]  # the second one
    ready_world.run(3.0)
    assert drone.true_position[2] == pytest.approx(1.0, abs=0.1)
    assert lib.cf_high_level_packet(drone.struct, ffi.NULL, 0, reply) == 0


def test_trajectory_of_no_numbers_switches_the_planner_off(hovering_world):
    """The client refuses such pieces; a packet of the memory port could carry them all the same."""
    drone = hovering_world.drones[0]
    pieces = np.full(33, np.nan, "<f4").tobytes()
    assert lib.cf_write_trajectory(drone.struct, 0, len(pieces), pieces) == lib.CF_OK
    assert lib.cf_define_trajectory(drone.struct, 1, lib.CF_TRAJECTORY_TYPE_POLY4D, 0, 1) == lib.CF_OK
    drone.high_level_commander.start_trajectory(1)
    hovering_world.run(0.1)
    assert drone.log["supervisor.info"] & lib.CF_SUPERVISOR_INFO_HL_DISABLED
    assert drone.failure is None
    assert drone.true_position[2] > 0.3


def test_command_for_another_group_is_ignored(ready_world):
    drone = ready_world.drones[0]
    drone.high_level_commander.takeoff(0.5, 1.0, group_mask=4)
    ready_world.run(0.5)
    assert drone.log["motor.m1"] == 0
    drone.high_level_commander.set_group_mask(4)
    assert drone.param["hlCommander.groupmask"] == 4
    drone.high_level_commander.takeoff(0.5, 1.0, group_mask=4)
    ready_world.run(0.5)
    assert drone.log["motor.m1"] > 0


# ---------------------------------------------------------------------------- parameters and logs


def test_parameters_are_a_dictionary(ready_world):
    param = ready_world.drones[0].param
    assert param["pid_rate.roll_kp"] == 250.0
    param["pid_rate.roll_kp"] = 200
    assert param["pid_rate.roll_kp"] == 200.0
    assert param.get_value("pid_rate.roll_kp") == "200.0"
    param.set_value("pid_rate.roll_kp", "150.5")
    assert param["pid_rate.roll_kp"] == 150.5
    assert "stabilizer.controller" in param
    assert len(param) == len(list(param)) > 100


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("stabilizer.controller", 256, "cf1: stabilizer.controller is 256, allowed: a whole number 0 to 255"),
        ("stabilizer.controller", 1.5, "cf1: stabilizer.controller is 1.5, allowed: a whole number"),
        ("stabilizer.controller", "pid", "cf1: stabilizer.controller is 'pid', allowed: a whole number"),
        ("pid_rate.roll_kp", float("nan"), "cf1: pid_rate.roll_kp is nan, allowed: a finite number"),
        ("pid_rate.roll_kp", 1e300, "allowed: a finite number"),
    ],
)
def test_value_that_does_not_fit_is_refused(ready_world, name, value, sentence):
    with pytest.raises(RangeError, match=sentence):
        ready_world.drones[0].param[name] = value


def test_unknown_name_proposes_similar_ones(ready_world):
    drone = ready_world.drones[0]
    with pytest.raises(UnknownNameError, match="no parameter .*controler'; did you mean stabilizer.controller"):
        drone.param["stabilizer.controler"] = 1
    with pytest.raises(UnknownNameError, match="no log variable .*stateEstimate.X'; did you mean .*stateEstimate.x"):
        drone.log["stateEstimate.X"]


def test_unknown_controller_reads_back_as_the_active_one(hovering_world):
    drone = hovering_world.drones[0]
    drone.param["stabilizer.controller"] = 99
    hovering_world.run(1.0)
    assert drone.param["stabilizer.controller"] == 1
    assert drone.is_flying


def test_parameter_stop_locks_the_drone(hovering_world):
    drone = hovering_world.drones[0]
    drone.param["stabilizer.stop"] = 1
    hovering_world.run(0.2)
    assert drone.is_locked


def test_external_position_reaches_the_filter(ready_world):
    drone = ready_world.drones[0]
    drone.send_extpos(0.01, 0.02, 0.03)
    assert drone.log["locSrv.x"] == pytest.approx(0.01)
    drone.send_extpose(0.01, 0.02, 0.04, 0, 0, 0, 1)
    assert drone.log["locSrv.z"] == pytest.approx(0.04)
    with pytest.raises(RangeError, match="cf1: send_extpos"):
        drone.send_extpos(float("nan"), 0, 0)


def test_compressed_log_variables_are_computed_when_read(hovering_world):
    drone = hovering_world.drones[0]
    assert drone.struct.onboard.compressed_state.z == 0
    for group in ("stateEstimate", "ctrltarget"):
        assert drone.log[f"{group}Z.z"] == int(np.float32(1000) * np.float32(drone.log[f"{group}.z"])) > 450
    before = drone.log["stateEstimateZ.az"]
    hovering_world.run(0.05)
    assert drone.log["stateEstimateZ.az"] != before


def test_reading_any_other_log_variable_leaves_no_trace(hovering_world):
    drone = hovering_world.drones[0]
    before = drone.memory.tobytes()
    assert all(np.isfinite(drone.log[name]) for name in drone.log if "Z." not in name and name != "sim.contacts")
    assert drone.memory.tobytes() == before
