"""The real client as encoder: what it sends means here what the same call of a drone handle means."""

import inspect
import warnings

import cflib.crazyflie.commander
import cflib.crazyflie.localization
import numpy as np
import pytest
from fake_link import FakeCrazyflie
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from worlds import make_world

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation.clients import Commander, Localization


@pytest.fixture(scope="module")
def world():
    world = make_world()
    world.wait_until_ready()
    return world


@pytest.fixture
def drone(world):
    """The drone as it was when it became ready."""
    drone = world.drones[0]
    before = drone.snapshot()
    yield drone
    drone.restore(before)


def methods(cls):
    """Return the public methods of a class and the names of their parameters."""
    return {
        name: list(inspect.signature(function).parameters)
        for name, function in vars(cls).items()
        if inspect.isfunction(function) and not name.startswith("_")
    }


def test_commander_has_every_method_of_the_client() -> None:
    assert methods(Commander) == methods(cflib.crazyflie.commander.Commander)


def test_localization_has_the_methods_of_the_client_that_mean_something_here() -> None:
    theirs = methods(cflib.crazyflie.localization.Localization)
    for of_missing_decks in ("send_short_lpp_packet", "send_lh_persist_data_packet"):
        del theirs[of_missing_decks]
    assert methods(Localization) == theirs


# ---------------------------------------------------------------------------- commander


def setpoint_after(drone, call, commander) -> bytes:
    call(commander)
    return bytes(ffi.buffer(ffi.addressof(drone.struct.onboard, "client_setpoint")))


def assert_twins(drone, call, protocol: int = 12) -> None:
    """Make the call through the real client and through the handle, and compare what the drone then holds."""
    before = drone.snapshot()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of old protocols
        link = FakeCrazyflie(drone, protocol)
        theirs = setpoint_after(drone, call, link.commander)
    memory = drone.memory.tobytes()
    drone.restore(before)
    ours = setpoint_after(drone, call, drone.commander)
    assert ours == theirs
    assert drone.memory.tobytes() == memory
    drone.restore(before)
    assert link.sent


def in_x_mode(commander) -> None:
    commander.set_client_xmode(True)
    commander.send_setpoint(10.0, -3.0, 5.0, 30000)
    commander.set_client_xmode(False)


CALLS = {
    "send_setpoint": lambda c: c.send_setpoint(1.0, 2.0, 3.0, 40000),
    "send_setpoint after the thrust lock": lambda c: (c.send_setpoint(0, 0, 0, 0), c.send_setpoint(1, 2, 3, 40000)),
    "set_client_xmode": in_x_mode,
    "send_stop_setpoint": lambda c: c.send_stop_setpoint(),
    "send_velocity_world_setpoint": lambda c: c.send_velocity_world_setpoint(1, 2, 3, 4),
    "send_zdistance_setpoint": lambda c: c.send_zdistance_setpoint(1, 2, 3, 4),
    "send_hover_setpoint": lambda c: c.send_hover_setpoint(1, 2, 3, 4),
    "send_position_setpoint": lambda c: c.send_position_setpoint(1, 2, 3, 90),
    "send_setpoint_manual rates": lambda c: c.send_setpoint_manual(1, 2, 3, 50, True),
    "send_setpoint_manual angles": lambda c: c.send_setpoint_manual(1, 2, 3, 37.5, False),
    "send_full_state_setpoint": lambda c: c.send_full_state_setpoint(
        [1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 0, 0, 1], 1, 2, 3
    ),
    "send_full_state_setpoint turned": lambda c: c.send_full_state_setpoint(
        [-1.2345, 32.767, -32.768], [0.0019, 0, 0], [0, 0, -9.81], [0.1, 0.2, 0.3, 0.9], -0.0019, 0, 0
    ),
    "send_notify_setpoint_stop": lambda c: (c.send_hover_setpoint(1, 2, 3, 4), c.send_notify_setpoint_stop(100)),
}


@pytest.mark.parametrize("name", CALLS)
def test_call_means_the_same_over_the_wire(drone, name: str) -> None:
    assert_twins(drone, CALLS[name])


@pytest.mark.parametrize(
    "name", ["send_velocity_world_setpoint", "send_zdistance_setpoint", "send_hover_setpoint", "send_position_setpoint"]
)
def test_legacy_packets_of_an_old_protocol_mean_the_same(drone, name: str) -> None:
    assert_twins(drone, CALLS[name], protocol=8)


# within what the wire carries, and not so small that the client's float32 becomes another number
NUMBER = st.floats(-32, 32, width=32)


@pytest.mark.parametrize(
    "name", ["send_velocity_world_setpoint", "send_zdistance_setpoint", "send_hover_setpoint", "send_position_setpoint"]
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@given(values=st.tuples(NUMBER, NUMBER, NUMBER, NUMBER), protocol=st.sampled_from([8, 12]))
def test_any_numbers_mean_the_same_over_the_wire(drone, name: str, values, protocol: int) -> None:
    assert_twins(drone, lambda c: getattr(c, name)(*values), protocol)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@given(values=st.tuples(NUMBER, NUMBER, NUMBER), percent=st.floats(0, 100), is_rate=st.booleans())
def test_any_manual_setpoint_means_the_same_over_the_wire(drone, values, percent: float, is_rate: bool) -> None:
    assert_twins(drone, lambda c: c.send_setpoint_manual(*values, percent, is_rate))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(vectors=st.lists(st.tuples(NUMBER, NUMBER, NUMBER), min_size=4, max_size=4))
def test_any_full_state_means_the_same_over_the_wire(drone, vectors) -> None:
    pos, vel, acc, rates = vectors
    assert_twins(drone, lambda c: c.send_full_state_setpoint(pos, vel, acc, [0.5, -0.5, 0.5, 0.5], *rates))


# ---------------------------------------------------------------------------- what the handle refuses


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda c: c.send_full_state_setpoint([40, 0, 0], *[[0] * 3] * 2, [0, 0, 0, 1], 0, 0, 0), "40.* is outside"),
        (lambda c: c.send_full_state_setpoint([0] * 3, *[[0] * 3] * 2, [0, 0, 0, 1], 0, 0, 33), "33 is outside"),
        (lambda c: c.send_full_state_setpoint([0] * 3, *[[0] * 3] * 2, [0, 0, 0, 0], 0, 0, 0), "a quaternion xyzw"),
        (lambda c: c.send_full_state_setpoint([0] * 3, *[[0] * 3] * 2, [0, 0, 1], 0, 0, 0), "a quaternion xyzw"),
        (lambda c: c.send_full_state_setpoint([0] * 2, *[[0] * 3] * 2, [0, 0, 0, 1], 0, 0, 0), "three vectors of 3"),
        (lambda c: c.send_setpoint_manual(0, 0, 0, 101, True), r"thrust_percentage 101 is outside \[0, 100\]"),
    ],
)
def test_what_the_wire_cannot_carry_is_refused_in_words(drone, call, sentence: str) -> None:
    before = drone.memory.tobytes()
    with pytest.raises(RangeError, match=f"cf1.*{sentence}"):
        call(drone.commander)
    assert drone.memory.tobytes() == before


# ---------------------------------------------------------------------------- localization


def newest_measurement(drone):
    estimator = drone.struct.onboard.estimator
    return estimator.queue[estimator.queue_count - 1]


@pytest.mark.parametrize(
    "way", [lambda link: link.loc.send_extpos([1, 2, 3]), lambda link: link.extpos.send_extpos(1, 2, 3)]
)
def test_external_position_of_the_client_is_measured(drone, way) -> None:
    way(FakeCrazyflie(drone))
    assert newest_measurement(drone).type == lib.MeasurementTypePosition
    assert [drone.log[f"ext_pos.{axis}"] for axis in "XYZ"] == [1, 2, 3]
    assert drone.log["locSrvZ.tick"] == drone.struct.onboard.tick


@pytest.mark.parametrize(
    "way",
    [
        lambda link: link.loc.send_extpose([1, 2, 3], [0, 0, 0, 1]),
        lambda link: link.extpos.send_extpose(1, 2, 3, 0, 0, 0, 1),
    ],
)
def test_external_pose_of_the_client_is_measured(drone, way) -> None:
    way(FakeCrazyflie(drone))
    assert newest_measurement(drone).type == lib.MeasurementTypePose
    assert [drone.log[f"locSrv.{name}"] for name in ("x", "y", "z", "qw")] == [1, 2, 3, 1]


def test_handle_and_client_tell_positions_alike(drone) -> None:
    before = drone.snapshot()
    FakeCrazyflie(drone).loc.send_extpose([1, 2, 3], [0.1, 0.2, 0.3, 0.9])
    theirs = drone.memory.tobytes()
    drone.restore(before)
    drone.loc.send_extpose(np.array([1, 2, 3]), (0.1, 0.2, 0.3, 0.9))
    assert drone.memory.tobytes() == theirs


def test_client_hears_that_no_lighthouse_data_was_stored(drone) -> None:
    link = FakeCrazyflie(drone)
    answers = []
    link.loc.receivedLocationPacket.add_callback(lambda packet: answers.append((packet.type, packet.data)))
    link.loc.send_lh_persist_data_packet([0, 1], [2])
    assert link.sent[-1] == (6, 1, bytes.fromhex("0b03000400"))
    assert answers == [(link.loc.LH_PERSIST_DATA, False)]


# ---------------------------------------------------------------------------- supervisor


@pytest.mark.parametrize("protocol", [11, 12])
@pytest.mark.parametrize("client", ["loc", "supervisor"])
def test_emergency_stop_of_the_client_is_latched(drone, client: str, protocol: int) -> None:
    link = FakeCrazyflie(drone, protocol)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the client about the old protocol
        getattr(link, client).send_emergency_stop()
    assert link.sent == [(9, 1, b"\x03") if protocol == 12 else (6, 1, b"\x03")]
    assert drone.struct.onboard.supervisor.emergency_stop_requested


@pytest.mark.parametrize("protocol", [11, 12])
@pytest.mark.parametrize("client", ["loc", "supervisor"])
def test_watchdog_of_the_client_is_fed(drone, client: str, protocol: int) -> None:
    link = FakeCrazyflie(drone, protocol)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the client about the old protocol
        getattr(link, client).send_emergency_stop_watchdog()
    assert drone.struct.onboard.supervisor.emergency_watchdog_tick == drone.struct.onboard.tick
    assert not drone.struct.onboard.supervisor.emergency_stop_requested


PROPERTIES = [
    "can_be_armed",
    "is_armed",
    "is_auto_armed",
    "can_fly",
    "is_flying",
    "is_tumbled",
    "is_locked",
    "is_crashed",
    "hl_control_active",
    "hl_traj_finished",
    "hl_control_disabled",
]


@pytest.mark.parametrize("bit", range(11))
def test_client_reads_every_bit_of_the_supervisor(drone, bit: int) -> None:
    drone.struct.onboard.supervisor.info = 1 << bit
    supervisor = FakeCrazyflie(drone).supervisor
    assert [bool(getattr(supervisor, name)) for name in PROPERTIES] == [i == bit for i in range(11)]


def test_client_sees_a_drone_that_is_ready(drone) -> None:
    assert FakeCrazyflie(drone).supervisor.read_state_list() == [
        "Is armed",
        "Is auto armed",
        "Can fly",
        "Finished HL trajectory",
    ]


def test_client_disarms_and_recovers(drone) -> None:
    link = FakeCrazyflie(drone)
    link.supervisor.send_arming_request(False)
    assert not drone.struct.onboard.supervisor.is_armed
    drone.struct.onboard.supervisor.is_crashed = True
    link.supervisor.send_crash_recovery_request()
    assert not drone.is_crashed


# ---------------------------------------------------------------------------- bytes of the reference


@pytest.mark.parametrize(
    ("call", "packet"),
    [
        (lambda link: link.commander.send_setpoint(1, 2, 3, 40000), (3, 0, "0000803f000000c000004040409c")),
        (lambda link: link.commander.send_notify_setpoint_stop(100), (7, 1, "0064000000")),
        (lambda link: link.commander.send_stop_setpoint(), (7, 0, "00")),
        (
            lambda link: link.commander.send_setpoint_manual(1, 2, 3, 50, True),
            (7, 0, "0b0000803f000000c000004040b88801"),
        ),
        (
            lambda link: link.commander.send_full_state_setpoint(
                [1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 0, 0, 1], 1, 2, 3
            ),
            (7, 0, "06e803d007b80ba00f88137017581b401f2823000000c0e803d007b80b"),
        ),
        (lambda link: link.loc.send_extpos([1, 2, 3]), (6, 0, "0000803f0000004000004040")),
        (
            lambda link: link.loc.send_extpose([1, 2, 3], [0, 0, 0, 1]),
            (6, 1, "080000803f00000040000040400000000000000000000000000000803f"),
        ),
    ],
)
def test_client_sends_the_captured_bytes(drone, call, packet) -> None:
    """docs/reference/crtp-cflib.md#21; the packets of the other calls are in tests/bindings/onboard."""
    link = FakeCrazyflie(drone)
    call(link)
    assert [(port, channel, data.hex()) for port, channel, data in link.sent] == [packet]
