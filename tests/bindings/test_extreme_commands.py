"""What clients send and write, full of numbers that break things: packets, memories, parameters, plans, peers."""

import math
import struct
from itertools import product

import numpy as np
import pytest
from extremes import EXTREMES, FEW, many
from onboard.planning_provider import planning_provider

from crazychoir_fw._core import ffi, lib

TIMES = [0, 1, 1000000, 2**32 - 1, 2**64 - 1]
PORTS = (3, 3, 6, 7, 7, 7, 7, 7, 8, 9)
GENERIC_LENGTHS = (1, 17, 17, 10, 17, 17, 29, 17, 17, 17, 17, 16, 1)
OTHER_LENGTHS = (1, 2, 5, 7, 12, 14, 21, 22, 23, 28, 29, 30)
EYE = [1, 0, 0, 0, 1, 0, 0, 0, 1]
AT_REST = {"position": [0, 0, 0.0145], "quat_wxyz": [1], "rotation": EYE, "specific_force": [0, 0, 9.81]}


def boot(platform=lib.CF_PLATFORM_CF2, change=lambda config: None):
    config, cf = ffi.new("cf_config_t *"), ffi.new("cf_t *")
    assert lib.cf_config_default(config, platform) == lib.CF_OK
    change(config)
    assert lib.cf_init(cf, config) == lib.CF_OK
    return cf


def rest(cf, ticks=1):
    motion = ffi.new("cf_motion_t *", AT_REST)
    for _ in range(ticks):
        lib.cf_tick(cf, motion)
    return cf


@pytest.fixture(scope="module")
def ready():
    return bytes(ffi.buffer(rest(boot(), 2000)))


@pytest.fixture
def cf(ready):
    """A drone that is ready to fly."""
    cf = ffi.new("cf_t *")
    ffi.buffer(cf)[:] = ready
    return cf


def set_positioning(positioning):
    def change(config):
        config.vehicle.positioning = positioning
        config.loco_is_planar, config.loco_height = 1, 0.5
        config.vehicle.rangers.has_multiranger = config.vehicle.rangers.has_zranger = True

    return change


# ---- a whole drone


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 3e38])
def test_a_motion_that_is_no_number_stops_the_drone(bad, cf):
    assert lib.cf_takeoff(cf, 1, 2, 0, True) == lib.CF_OK
    assert rest(cf, 500).onboard.motors.list[0] > 0
    motion = ffi.new("cf_motion_t *", AT_REST)
    motion.position[1] = bad
    lib.cf_tick(cf, motion)
    for _ in range(2):
        assert cf.onboard.fault == lib.CF_FAULT_MOTION
        assert cf.onboard.motors.list[0] == 0
        assert lib.cf_supervisor_is_locked(ffi.addressof(cf.onboard.supervisor))
        rest(cf, 1000)
    lib.cf_reboot(cf)
    assert rest(cf, 2000).onboard.fault == lib.CF_FAULT_NONE


@pytest.mark.parametrize("bad", FEW)
def test_wrench_is_always_finite(bad):
    cf, motion = boot(lib.CF_PLATFORM_CF21BL), ffi.new("cf_motion_t *", AT_REST)
    force, torque = ffi.new("float[3]"), ffi.new("float[3]")
    for other in FEW:
        motion.velocity[0], motion.rates[2] = bad, other
        lib.cf_wrench(cf, motion, force, torque)
        assert np.isfinite([*force, *torque]).all()


@pytest.mark.parametrize("positioning", range(lib.CF_POSITIONING_COUNT))
def test_parameters_of_decks_may_hold_anything(positioning):
    for i, odd in enumerate(FEW):
        cf = boot(change=set_positioning(positioning))
        decks = cf.onboard.decks
        decks.flow.fixed_std = decks.loco.tdoa2_std = decks.loco.tdoa3_std = odd
        decks.lighthouse.method, decks.loco.mode = i * 19, i % 5
        rest(cf, 600)
        lib.cf_reboot(cf)
        assert rest(cf).onboard.tick == 1


def test_every_number_may_be_written_as_estimator(cf):
    known = (lib.StateEstimatorTypeKalman, lib.StateEstimatorTypeComplementary)
    for i in range(1000):
        cf.onboard.estimator_type = i % 256
        rest(cf)
        assert cf.onboard.estimator.type in known
        assert cf.onboard.estimator_type == cf.onboard.estimator.type
    assert cf.onboard.fault == lib.CF_FAULT_NONE


def test_a_drone_whose_attitude_is_no_number_is_stopped():
    cf = rest(boot(change=set_positioning(lib.CF_POSITIONING_NONE)), 2000)
    assert cf.onboard.estimator.type == lib.StateEstimatorTypeComplementary
    cf.onboard.sensors.acc_scale.scale = math.nan
    assert rest(cf, 5).onboard.fault == lib.CF_FAULT_ESTIMATE


@pytest.mark.parametrize("number", range(lib.cf_attribute_count()))
def test_attributes_refuse_every_bad_text(number):
    name = ffi.string(lib.cf_attribute_name(number)).decode()
    if name.startswith("motor_ctrl"):  # remarks for Python are any text
        return
    for bad in ("nan", "-1", "inf", "1e99", "x", "cf3", " ", "0x", "1.5.5", "--", "2,5"):
        if name == "vehicle" and bad == " ":  # the list of parameters may be empty
            continue
        config, message = ffi.new("cf_config_t *"), ffi.new("char[]", lib.CF_ATTRIBUTE_MESSAGE_BYTES)
        lib.cf_config_default(config, lib.CF_PLATFORM_CF2)
        status = lib.cf_attribute_set(config, number, bad.encode(), message)
        assert status == (lib.CF_ERR_UNKNOWN if name == "vehicle" else lib.CF_ERR_VALUE)
        said = ffi.string(message).decode()
        assert name in said and bad in said and "allowed: " in said


# ---- packets


def random_packet(rng):
    """Return port, channel and bytes: three in four of a known type and mostly of its length, some floats wild."""
    port = PORTS[rng.integers(len(PORTS))]
    channel = int(rng.integers(8)) // (2 if port == 6 else 7)
    data, start = rng.integers(0, 256, 30, np.uint8), int(port != 3)
    floats = np.where(rng.random(7) < 1 / 8, rng.choice(EXTREMES, 7), rng.uniform(-2, 2, 7)).astype(np.float32)
    data[start : start + 28] = floats.view(np.uint8)
    if rng.random() < 0.25:
        return port, channel, bytes(data[: rng.integers(31)])
    kind = int(rng.integers(len(GENERIC_LENGTHS)))
    if port != 3:
        data[0] = kind
    others = OTHER_LENGTHS[rng.integers(len(OTHER_LENGTHS))]
    return port, channel, bytes(data[: {3: 14, 7: GENERIC_LENGTHS[kind]}.get(port, others)])


def test_random_packets_never_reach_the_motors_as_no_numbers(cf, ready):
    rng, reply, motion = np.random.default_rng(1), ffi.new("cf_packet_reply_t *"), ffi.new("cf_motion_t *", AT_REST)
    setpoints = [
        ffi.addressof(cf.onboard, *path) for path in (["client_setpoint"], ["commander", "setpoint"], ["setpoint"])
    ]
    outcomes, turning, count = dict.fromkeys(range(-5, 1), 0), 0, 10000
    for i in range(count):
        port, channel, data = random_packet(rng)
        if i % 50 == 0:  # any flight mode, and scales that may be no numbers
            modes = ffi.cast("uint8_t *", ffi.addressof(cf.onboard.rpyt, "althold"))
            modes[int(rng.integers(7))] = int(rng.integers(4))
            cf.onboard.cppm.angRoll = rng.choice(EXTREMES)
        before = bytes(ffi.buffer(cf)) if i % 4 == 0 else None
        exact = ffi.new("uint8_t[]", data) if data else ffi.NULL
        status = lib.cf_receive_packet(cf, port, channel, exact, len(data), reply)
        outcomes[status] += 1
        assert 0 <= reply.length <= lib.CF_PACKET_BYTES
        if status in (lib.CF_ERR_VALUE, lib.CF_ERR_UNKNOWN):
            assert reply.length == 0
            assert before is None or bytes(ffi.buffer(cf)) == before
        lib.cf_tick(cf, motion)
        assert all(lib.cf_setpoint_is_finite(setpoint) for setpoint in setpoints)
        stopped = cf.onboard.fault != lib.CF_FAULT_NONE
        assert not any(cf.onboard.motors.list) if stopped else math.isfinite(cf.onboard.control.thrust)
        turning += cf.onboard.motors.list[0] > 0
        if stopped or lib.cf_supervisor_is_locked(ffi.addressof(cf.onboard.supervisor)):
            ffi.buffer(cf)[:] = ready
    # the test has seen every outcome
    assert outcomes[lib.CF_OK] > count / 4 and turning > count / 4
    assert outcomes[lib.CF_ERR_VALUE] > count / 8
    assert outcomes[lib.CF_ERR_UNKNOWN] > count / 20
    assert outcomes[lib.CF_ERR_STATE] > 0


def test_altitude_hold_resets_the_position_loops_once(cf):
    tables = ffi.new("cf_variables_t[]", 64)
    (pid,) = (
        ffi.cast("PidObject *", ffi.cast("char *", cf) + table.base + row.offset - ffi.offsetof("PidObject", "outI"))
        for table in tables[0 : lib.cf_logs(0, tables, 64)]
        for row in table.rows[0 : table.count]
        if (ffi.string(row.group), ffi.string(row.name)) == (b"posCtl", b"VZi")
    )
    for hold, expected in ((0, 3), (1, 0), (1, 3), (0, 3), (1, 0)):
        pid.integ, cf.onboard.rpyt.althold = 3, hold
        assert lib.cf_send_rpyt(cf, 0, 0, 0, 40000) == lib.CF_OK
        assert pid.integ == expected
    # a refused command resets nothing
    cf.onboard.rpyt.althold = 0
    assert lib.cf_send_rpyt(cf, 0, 0, 0, 40000) == lib.CF_OK
    pid.integ, cf.onboard.rpyt.althold = 3, 1
    assert lib.cf_send_rpyt(cf, math.nan, 0, 0, 40000) == lib.CF_ERR_VALUE
    assert pid.integ == 3


def test_legacy_command_and_sticks_in_every_mode():
    for mode in range(128):
        rpyt, setpoint = ffi.new("cf_rpyt_t *"), ffi.new("setpoint_t *")
        rpyt.althold, rpyt.poshold, rpyt.posSet, rpyt.yawMode = mode & 1, mode >> 1 & 1, mode >> 2 & 1, mode >> 3 & 3
        rpyt.stabModeRoll, rpyt.stabModePitch = mode >> 5 & 1, mode >> 6 & 1
        rpyt.stabModeYaw = mode >> 6 & 1
        for a, b in product(FEW, FEW):
            lib.cf_setpoint_rpyt(setpoint, rpyt, 2, a, b, a * b, 65535)
            assert lib.cf_setpoint_is_finite(setpoint)
    for i, scale in enumerate(EXTREMES):
        sticks = ffi.new("cf_cppm_sticks_t *", [65535, 0, 65535, 65535, i % 2])
        lib.cf_setpoint_cppm(setpoint, ffi.new("cf_cppm_t *", [scale] * 5), sticks)
        assert lib.cf_setpoint_is_finite(setpoint)


def test_setpoints_are_refused_unless_finite():
    setpoint, rpyt = ffi.new("setpoint_t *"), ffi.new("cf_rpyt_t *")
    lib.cf_rpyt_init(rpyt)
    for a, b in product(EXTREMES, FEW):
        expected = lib.CF_OK if math.isfinite(a) and math.isfinite(b) else lib.CF_ERR_VALUE
        for name in ("velocity_world", "zdistance", "altitude_hold", "hover", "position"):
            assert getattr(lib, f"cf_setpoint_{name}")(setpoint, a, b, a, b) == expected
        assert lib.cf_setpoint_manual(setpoint, a, b, a, 65535, True) == expected
        assert lib.cf_setpoint_rpyt(setpoint, rpyt, 2, a, b, a, 65535) == expected


# ---- memories and logs

MEMORIES = (lib.CF_MEMORY_EEPROM, lib.CF_MEMORY_LED_RING, lib.CF_MEMORY_LIGHTHOUSE, lib.CF_MEMORY_TESTER)
MEMORIES = (*MEMORIES, lib.CF_MEMORY_LED_TIMINGS)


def test_memories_take_what_they_accept_and_refuse_the_rest():
    cf, rng, back = boot(change=set_positioning(lib.CF_POSITIONING_LIGHTHOUSE)), np.random.default_rng(1), bytearray(32)
    into = ffi.from_buffer("uint8_t[]", back)
    for i in range(10000):
        kind, length = MEMORIES[rng.integers(len(MEMORIES))], int(rng.integers(30))
        address = int(rng.integers(2**32 if rng.random() < 1 / 8 else lib.cf_memory_bytes(kind) + 4))
        data = ffi.new("uint8_t[]", rng.bytes(length) or b"\0")
        exists = lib.cf_read_memory(cf, kind, address, length, into) == lib.CF_OK
        status = lib.cf_write_memory(cf, kind, address, length, data)
        assert exists or status != lib.CF_OK
        if status == lib.CF_OK and kind not in (lib.CF_MEMORY_TESTER, lib.CF_MEMORY_LIGHTHOUSE):
            assert lib.cf_read_memory(cf, kind, address, length, into) == lib.CF_OK
            assert back[:length] == bytes(data)[:length]
        if i % 16 == 0:
            rest(cf)
    assert cf.onboard.system.memory_test_errors > 0


@pytest.mark.parametrize("kind", range(256))
def test_every_number_of_a_memory(kind, cf):
    expected = lib.CF_OK if kind in MEMORIES else lib.CF_ERR_UNKNOWN
    data = ffi.new("uint8_t[4]")
    assert (lib.cf_memory_bytes(kind) > 0) == (kind in MEMORIES)
    assert lib.cf_read_memory(cf, kind, 0, 4, data) == expected
    assert lib.cf_write_memory(cf, kind, 2**32 - 1, 1, data) != lib.CF_OK
    assert lib.cf_write_memory(cf, kind, 0, 2**32 - 1, data) != lib.CF_OK


def test_lighthouse_memory_refuses_what_is_no_number_and_what_lies_between(cf):
    data = ffi.new("uint8_t[4]", struct.pack("<f", math.nan))
    assert lib.cf_write_memory(cf, lib.CF_MEMORY_LIGHTHOUSE, 4, 4, data) == lib.CF_ERR_VALUE
    for address, length in ((0x0200, 1), (0x0030, 2), (0x103D, 1)):
        assert lib.cf_read_memory(cf, lib.CF_MEMORY_LIGHTHOUSE, address, length, data) == lib.CF_ERR_CAPACITY
    assert lib.cf_read_memory(cf, lib.CF_MEMORY_LIGHTHOUSE, 0x103C, 1, data) == lib.CF_OK


def packed(block, count=1):
    """Return the packet of a block and the bytes behind it, all 0xA5 before."""
    packets = ffi.new("uint8_t[]", b"\xa5" * (lib.CF_LOG_PACKET_BYTES + 8))
    lib.cf_log_pack(block, count, packets)
    return bytes(packets)


def test_a_full_log_packet_ends_where_it_must(cf):
    block = ffi.new("cf_log_block_t *", {"drone": cf, "number": 255, "count": lib.CF_LOG_VALUE_BYTES})
    for i in range(lib.CF_LOG_VALUE_BYTES):  # up to the last byte of the drone
        offset = ffi.sizeof("cf_t") - 1 - i
        block.values[i] = {"offset": offset, "stored": lib.CF_LOG_UINT8, "fetched": lib.CF_LOG_UINT8}
    cf.provider_state[lib.CF_PROVIDER_STATE_BYTES // 8 - 1] = 2**64 - 1
    packet = packed(block)
    assert packet[1] == packet[lib.CF_LOG_HEADER_BYTES] == 255
    assert set(packet[lib.CF_LOG_PACKET_BYTES : -1]) == {0xA5}
    assert set(packed(block, 0)[:-1]) == {0xA5}


def test_every_pair_of_log_types_survives_any_number(cf):
    place = ffi.offsetof("cf_t", "provider_state") + 1  # not aligned
    for number in EXTREMES:
        ffi.buffer(cf)[place : place + 4] = struct.pack("<f", number)
        for stored, fetched in product(
            range(lib.CF_LOG_UINT8, lib.CF_LOG_FLOAT + 1), range(lib.CF_LOG_UINT8, lib.CF_LOG_FP16 + 1)
        ):
            values = [{"offset": place, "stored": stored, "fetched": fetched}]
            packet = packed(ffi.new("cf_log_block_t *", {"drone": cf, "count": 1, "values": values}))
            assert set(packet[lib.CF_LOG_HEADER_BYTES + lib.cf_log_value_bytes(fetched) : -1]) == {0xA5}


def test_every_log_variable_of_a_drone_can_be_packed(cf):
    tables = ffi.new("cf_variables_t[]", 64)
    count = lib.cf_logs(0, tables, 64)
    assert 0 < count <= 64
    for table in tables[0:count]:
        for row in table.rows[0 : table.count]:
            value = {"offset": table.base + row.offset, "stored": row.type + 1, "fetched": lib.CF_LOG_FP16}
            shape = {"drone": cf, "count": 1, "needs_refresh": True, "values": [value]}
            assert packed(ffi.new("cf_log_block_t *", shape))[0] == 0x5E


# ---- the supervisor


@pytest.mark.parametrize("auto_arming", [True, False])
def test_supervisor_with_any_input(auto_arming):
    supervisor = ffi.new("cf_supervisor_t *")
    ffi.buffer(supervisor)[:] = b"\xa5" * ffi.sizeof("cf_supervisor_t")
    lib.cf_supervisor_init(supervisor, auto_arming)
    inputs = many("cf_supervisor_inputs_t", 2000, 3, calm=0.5)
    for i in range(2000):
        inputs[i].planner_state = i % 8 - 2
        lib.cf_supervisor_request_arming(supervisor, i % 2)
        lib.cf_supervisor_request_crash_recovery(supervisor, True)
        line = lib.cf_supervisor_update(supervisor, inputs + i, 40)
        assert line == ffi.NULL or len(ffi.string(line)) > 0
        assert 0 <= supervisor.state < lib.supervisorState_NrOfStates
        setpoint = ffi.new("setpoint_t *", {"thrust": 1})
        lib.cf_supervisor_override_setpoint(supervisor, setpoint)
        assert lib.cf_supervisor_are_motors_allowed(supervisor) or setpoint.thrust == 0


def test_ticks_of_the_supervisor_may_wrap():
    """Half of the time line of a flight lies across the wrap of the tick after 49.7 days."""
    supervisor = ffi.new("cf_supervisor_t *")
    lib.cf_supervisor_init(supervisor, True)
    inputs = ffi.new("cf_supervisor_inputs_t *", {"acc": {"z": 1}, "motor_ratio": [30000] * 4})
    for update in range(1, 1001):
        inputs.now = 2**32 - 2001 + 40 * update & 0xFFFFFFFF
        inputs.setpoint_tick = inputs.now - 20 & 0xFFFFFFFF
        lib.cf_supervisor_update(supervisor, inputs, 40)
    assert supervisor.state == lib.supervisorStateFlying


# ---- plans


class Planner:
    """A high-level commander over a planner, which is asked for setpoints at all times after each command."""

    def __init__(self):
        self.provider, self.commander = planning_provider(), ffi.new("cf_high_level_commander_t *")
        ffi.buffer(self.commander)[:] = b"\xa5" * ffi.sizeof("cf_high_level_commander_t")
        lib.cf_high_level_commander_init(self.commander)

    def __call__(self, name, *arguments):
        over = self.provider.table, self.provider.state
        status = getattr(lib, f"cf_high_level_commander_{name}")(self.commander, *over, *arguments)
        self.fly()
        return status

    def fly(self):
        over = self.commander, self.provider.table, self.provider.state
        estimate, setpoint = ffi.new("state_t *", {"position": {"z": 1}}), ffi.new("setpoint_t *")
        for now in TIMES:
            lib.cf_high_level_commander_get_setpoint(*over, estimate, 10, now, setpoint)
            lib.cf_high_level_commander_is_trajectory_finished(*over, now)


@pytest.mark.parametrize("a", FEW)
def test_high_level_commands_are_refused_when_not_finite(a):
    for b in FEW:
        send, good = Planner(), math.isfinite(a) and math.isfinite(b) and b > 0
        expected = lib.CF_OK if good else lib.CF_ERR_VALUE
        assert send("takeoff", a, b, 0, True, 0) == expected
        assert (send("land", a, b, 0, True, 0) != lib.CF_ERR_VALUE) == good
        assert send("go_to", {"x": a, "y": a, "z": a}, a, b, True, True, 2**64 - 1) == expected
        send.commander.pos.z = a
        send("takeoff_with_velocity", a, True, b, b, False, 0)
        send("land_with_velocity", b, True, a, a, False, 0)


@pytest.mark.parametrize("number", FEW)
def test_a_memory_full_of_one_number_is_a_trajectory_as_well(number):
    for timescale, is_reversed in product(FEW, (False, True)):
        send = Planner()
        memory = struct.pack("<f", number) * (lib.CF_TRAJECTORY_MEMORY_BYTES // 4)
        assert lib.cf_high_level_commander_write_trajectory(send.commander, 0, len(memory), memory) == lib.CF_OK
        poly4d = lib.CF_TRAJECTORY_TYPE_POLY4D
        assert lib.cf_high_level_commander_define_trajectory(send.commander, 30, poly4d, 4, 31) == lib.CF_OK
        good = math.isfinite(timescale) and timescale > 0
        status = send("start_trajectory", 30, timescale, True, True, is_reversed, 0)
        assert status == (lib.CF_OK if good else lib.CF_ERR_VALUE)
        # the planner itself takes any timescale
        facts = {"offset": 4, "n_pieces": 31, "timescale": timescale, "reversed": is_reversed}
        trajectory, start = ffi.new("cf_uploaded_trajectory_t *", facts), ffi.new("cf_plan_start_t *", {"yaw": number})
        arguments = send.provider.state, send.commander.memory, trajectory, start, number
        assert lib.cf_planner_start_trajectory(*arguments) == 0
        send.fly()


@pytest.mark.parametrize("offset", [0, 1, 2, 4, 3960, 3964, 3965, 3968, 4092, 4096, 2**32 - 1, 2**32 - 4, 2**32 - 132])
def test_a_definition_must_fit_the_memory(offset):
    send = Planner()
    for pieces, number in product(range(256), (30, 31)):
        fits = (
            number < 31 and pieces > 0 and offset % 4 == 0 and offset + 132 * pieces <= lib.CF_TRAJECTORY_MEMORY_BYTES
        )
        arguments = send.commander, number, lib.CF_TRAJECTORY_TYPE_POLY4D, offset, pieces
        assert (lib.cf_high_level_commander_define_trajectory(*arguments) == lib.CF_OK) == fits
        if fits:
            assert send("start_trajectory", number, 1, True, True, False, 0) == lib.CF_OK


def test_polynomials():
    for a, b in product(EXTREMES, FEW):
        piece = ffi.new("struct poly4d *", lib.poly4d_zero(a))
        piece.p = [[b] * lib.PP_SIZE] * 4
        lib.poly4d_eval(piece, a)
        if abs(a) < 1e6:
            lib.poly4d_max_accel_approx(piece)
        lib.polystretchtime(piece.p[0], a)
        lib.polybezier(piece.p[1], a, [a, b] * 4, 8)
        lib.poly5(piece.p[2], a, b, b, b, b, b, b)
        lib.normalize_radians(a)
        lib.shortest_signed_angle_radians(a, b)
    # the loop of samples is bounded for absurd durations
    assert lib.poly4d_max_accel_approx(ffi.new("struct poly4d *", lib.poly4d_zero(3.4e38))) == 0


# ---- peers


def told(a, b):
    """Return a table full of one position and its neighborhood."""
    peers = ffi.new("cf_peer_t[]", lib.PEER_LOCALIZATION_MAX_NEIGHBORS)
    for i in range(len(peers)):
        place = {"x": a if i % 3 == 0 else 0.1 * i, "y": b if i % 3 == 1 else -0.1 * i, "z": a if i % 3 == 2 else 1}
        peers[i] = {"id": i % 4, "pos": {"timestamp": 0 if i % 2 == 0 else 2**32 - 1, **place}}
    return peers


@pytest.mark.parametrize("a", FEW)
def test_a_sane_drone_is_asked_for_something_sane(a):
    avoidance, estimate = ffi.new("cf_collision_avoidance_t *"), ffi.new("state_t *", {"position": {"x": 0.2, "z": 1}})
    for b in FEW:
        peers = told(a, b)
        lib.cf_collision_avoidance_init(avoidance)
        avoidance.enable = 1
        for mode, now in product((lib.modeDisable, lib.modeAbs, lib.modeVelocity), (0, 1, 5001, 2**32 - 1)):
            wanted = {"mode": {"x": mode}, "position": {"x": 2}, "velocity": {"y": 1}}
            setpoint = ffi.new("setpoint_t *", wanted)
            lib.cf_collision_avoidance_update(avoidance, setpoint, peers, len(peers), ffi.NULL, estimate, now)
            parts = setpoint.position, setpoint.velocity
            assert np.isfinite([value for part in parts for value in (part.x, part.y, part.z)]).all()


@pytest.mark.parametrize("sweeps", [-(2**31), -1, 0, 1, 100, 2**31 - 1])
def test_avoidance_ends_whatever_its_parameters_are(sweeps):
    parameters = many("cf_collision_avoidance_t", 300, 1, calm=0.3)
    setpoints, estimates = many("setpoint_t", 300, 2), many("state_t", 300, 3)
    for i in range(300):
        peers = told(EXTREMES[i % len(EXTREMES)], FEW[i % len(FEW)])
        parameters[i].enable, parameters[i].params.voronoiProjectionMaxIters = 255, sweeps
        for mode, table, count in (
            (lib.modeAbs, peers, len(peers)),
            (lib.modeVelocity, peers, 2**31 - 1),
            (lib.modeVelocity, ffi.NULL, 0),
            (lib.modeVelocity, ffi.NULL, -1),
        ):
            setpoints[i].mode.x = mode
            lib.cf_collision_avoidance_update(parameters + i, setpoints + i, table, count, ffi.NULL, estimates + i, 7)
        assert setpoints[i].mode.x == lib.modeVelocity


@pytest.mark.parametrize("a", FEW)
def test_grid_of_peers(a):
    grid, nearest = ffi.new("cf_peer_grid_t *"), ffi.new("cf_seen_drone_t[]", lib.CF_PEER_GRID_MAX)
    assert lib.cf_peer_grid_new(grid, 40)
    for b in FEW:
        lib.cf_peer_grid_clear(grid)
        for i in range(50):
            lib.cf_peer_grid_add(grid, i, [a if i % 3 == 0 else 0.5 * i, b if i % 5 == 0 else -0.5, 1])
        lib.cf_peer_grid_sort(grid)
        assert grid.count <= grid.capacity
        for limit in range(-1, lib.CF_PEER_GRID_MAX + 2):
            count = lib.cf_peer_grid_nearest(grid, [a, b, 0], 3, nearest, limit)
            assert 0 <= count <= max(0, min(limit, lib.CF_PEER_GRID_MAX))
            assert all(nearest[k].index != 3 and nearest[k].index < 50 for k in range(count))
    lib.cf_peer_grid_free(grid)


def avoidance_of(cf):
    """Return the collision avoidance within a drone of the builtin provider."""
    tables = ffi.new("cf_variables_t[]", lib.CF_PROVIDER_MAX_TABLES)
    for table in tables[0 : lib.cf_provider(0).parameters(tables, len(tables))]:
        if ffi.string(table.rows[0].group) == b"colAv":
            return ffi.cast("cf_collision_avoidance_t *", ffi.cast("char *", cf.provider_state) + table.base)
    raise AssertionError("no group colAv")


def test_a_drone_asks_for_peers_while_it_avoids_them(cf):
    assert not cf.wants_peers
    avoidance_of(cf).enable = 1
    assert rest(cf).wants_peers
    lib.cf_reboot(cf)
    assert not cf.wants_peers


def test_the_loop_bends_its_own_copy(cf):
    """The setpoint is bent before the supervisor overrides it, and what the commander has stored stays."""
    stored = ffi.new("setpoint_t *")
    avoidance_of(cf).enable = 1
    assert lib.cf_send_position(cf, 2, 0, 0.3, 0) == lib.CF_OK
    assert rest(cf).onboard.setpoint.position.x < 0.6
    lib.cf_commander_get_setpoint(ffi.addressof(cf.onboard.commander), stored)
    assert stored.position.x == 2
    avoidance_of(cf).enable = 0
    assert rest(cf).onboard.setpoint.position.x == 2


def test_peers_of_a_client(cf):
    for bad, place in product((math.nan, math.inf, -math.inf), range(3)):
        position = [bad if i == place else 0 for i in range(3)]
        assert lib.cf_send_peer_position(cf, 1, *position) == lib.CF_ERR_VALUE
    assert lib.cf_send_peer_position(cf, 0, 1, 2, 3) == lib.CF_ERR_VALUE
    for number in range(1, lib.PEER_LOCALIZATION_MAX_NEIGHBORS + 1):
        assert lib.cf_send_peer_position(cf, number, 1, 2, 3) == lib.CF_OK
    assert lib.cf_send_peer_position(cf, 200, 1, 2, 3) == lib.CF_ERR_CAPACITY
    assert lib.cf_send_peer_position(cf, 10, 4, 5, 6) == lib.CF_OK
    peers = ffi.addressof(cf.onboard.peers)
    assert lib.cf_peer_localization_by_id(peers, 10).pos.timestamp == cf.onboard.tick
    lib.cf_reboot(cf)
    assert not lib.cf_peer_localization_is_id_active(peers, 10)


@pytest.mark.parametrize(("a", "b"), [*zip(FEW, reversed(FEW), strict=True)])
def test_a_drone_survives_what_it_is_told_of_peers(a, b, cf):
    avoidance_of(cf).enable = 1
    assert lib.cf_send_position(cf, 1, 0, 0.5, 0) == lib.CF_OK
    for _ in range(50):
        lib.cf_tell_peers(cf, told(a, b), lib.PEER_LOCALIZATION_MAX_NEIGHBORS)
        rest(cf)
    assert cf.onboard.fault == lib.CF_FAULT_NONE
    lib.cf_tell_peers(cf, ffi.NULL, -1)
