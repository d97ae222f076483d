"""Time lines of the supervisor: arming, time-outs, tumbling, emergency stop.

docs/reference/planner-commander.md#14.
"""

import math
from dataclasses import dataclass, field

import pytest
from supervisor_states import (
    BOOT,
    CRASHED,
    FLYING,
    FREE_FALL,
    LANDED,
    LOCKED,
    NOT_PASSED,
    PASSED,
    READY,
    RESET,
    WARNING,
)

from crazychoir_fw._core import ffi, lib

UPRIGHT = (0.0, 0.0, 1.0)
ON_ITS_SIDE = (1.0, 0.0, 0.0)
UPSIDE_DOWN = (0.0, 0.0, -1.0)
FALLING = (0.01, -0.02, 0.03)


@dataclass
class Bench:
    """A supervisor and the world it looks at; a step is a tick."""

    auto_arming: bool = True
    acc: tuple[float, float, float] = UPRIGHT
    motors: tuple[int, int, int, int] = (0, 0, 0, 0)
    idle: int = 0
    setpoint_tick: int | None = None  # None: always fresh
    planner_state: int = 0
    planner_is_finished: bool = True
    step: int = 0
    history: dict[int, int] = field(default_factory=dict)  # step at which a state was entered
    console: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.supervisor = ffi.new("cf_supervisor_t *")
        lib.cf_supervisor_init(self.supervisor, self.auto_arming)

    @property
    def state(self) -> int:
        return self.supervisor.state

    def run_to(self, step: int) -> None:
        while self.step < step:
            self.step += 1
            inputs = ffi.new("cf_supervisor_inputs_t *")
            inputs.acc.x, inputs.acc.y, inputs.acc.z = self.acc
            inputs.setpoint_tick = self.step if self.setpoint_tick is None else self.setpoint_tick
            inputs.now = self.step
            inputs.motor_ratio = list(self.motors)
            inputs.idle_thrust = self.idle
            inputs.planner_state = self.planner_state
            inputs.planner_is_finished = self.planner_is_finished
            before = self.state
            line = lib.cf_supervisor_update(self.supervisor, inputs, self.step)
            if line:
                self.console.append(ffi.string(line).decode())
            if self.state != before:
                self.history[self.step] = self.state

    def run(self, ms: int) -> None:
        self.run_to(self.step + ms)


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def flying() -> Bench:
    """A vehicle that became ready at step 120 and flies since step 160."""
    bench = Bench()
    bench.run_to(120)
    bench.motors = (30000,) * 4
    bench.run_to(200)
    assert bench.state == FLYING
    bench.history.clear()
    return bench


# --- arming


def test_auto_arming_makes_it_ready_after_three_updates(bench: Bench) -> None:
    bench.run_to(200)
    assert bench.history == {40: NOT_PASSED, 80: PASSED, 120: READY}


def test_auto_arming_arms_when_the_checks_have_passed(bench: Bench) -> None:
    bench.run_to(79)
    assert not lib.cf_supervisor_is_armed(bench.supervisor)
    bench.run_to(80)
    assert lib.cf_supervisor_is_armed(bench.supervisor)
    assert not lib.cf_supervisor_are_motors_allowed(bench.supervisor)
    bench.run_to(120)
    assert lib.cf_supervisor_are_motors_allowed(bench.supervisor)
    assert lib.cf_supervisor_can_fly(bench.supervisor)


def test_required_arming_waits_for_the_request() -> None:
    bench = Bench(auto_arming=False)
    assert not lib.cf_supervisor_request_arming(bench.supervisor, True)
    bench.run_to(1010)
    assert bench.state == PASSED
    assert lib.cf_supervisor_can_arm(bench.supervisor)
    assert lib.cf_supervisor_request_arming(bench.supervisor, True)
    bench.run_to(1039)
    assert bench.state == PASSED
    bench.run_to(1040)
    assert bench.state == READY


def test_arming_twice_is_no_mistake(bench: Bench) -> None:
    assert lib.cf_supervisor_request_arming(bench.supervisor, False)
    bench.run_to(120)
    assert lib.cf_supervisor_request_arming(bench.supervisor, True)


def test_disarming_in_flight_resets() -> None:
    bench = Bench(auto_arming=False)
    bench.run_to(80)
    lib.cf_supervisor_request_arming(bench.supervisor, True)
    bench.run_to(120)
    bench.motors = (30000,) * 4
    bench.run_to(160)
    assert lib.cf_supervisor_request_arming(bench.supervisor, False)
    bench.motors = (0,) * 4
    bench.run_to(400)
    assert bench.history == {
        40: NOT_PASSED,
        80: PASSED,
        120: READY,
        160: FLYING,
        200: RESET,
        240: NOT_PASSED,
        280: PASSED,
    }
    assert bench.console == ["Ready to fly", "Disarming"]


def test_preflight_timeout_disarms_after_30_s(bench: Bench) -> None:
    bench.run_to(30400)
    assert {k: v for k, v in bench.history.items() if k > 120} == {30160: NOT_PASSED, 30200: PASSED, 30240: READY}
    assert bench.console == []


def test_preflight_timeout_is_a_parameter(bench: Bench) -> None:
    bench.supervisor.prefltTimeout = 100
    bench.run_to(320)
    assert {k: v for k, v in bench.history.items() if k > 120} == {240: NOT_PASSED, 280: PASSED, 320: READY}


def test_required_arming_stays_disarmed_after_the_preflight_timeout() -> None:
    bench = Bench(auto_arming=False)
    bench.supervisor.prefltTimeout = 100
    bench.run_to(80)
    lib.cf_supervisor_request_arming(bench.supervisor, True)
    bench.run_to(1000)
    assert bench.state == PASSED
    assert not lib.cf_supervisor_is_armed(bench.supervisor)


# --- flying and landing


def test_thrust_above_idle_means_flying(bench: Bench) -> None:
    bench.run_to(120)
    bench.idle = 7000
    bench.motors = (7000,) * 4
    bench.run_to(200)
    assert bench.state == READY
    bench.motors = (7000, 7000, 7001, 7000)
    bench.run_to(240)
    assert bench.state == FLYING
    assert lib.cf_supervisor_is_flying(bench.supervisor)


def test_it_has_landed_two_seconds_after_the_last_thrust(flying: Bench) -> None:
    # the last update that saw thrust was that of step 200
    flying.motors = (0,) * 4
    flying.run_to(2199)
    assert flying.state == FLYING
    flying.run_to(2200)
    assert flying.history == {2200: LANDED}
    assert not lib.cf_supervisor_is_flying(flying.supervisor)
    assert lib.cf_supervisor_can_fly(flying.supervisor)


def test_landing_timeout_resets_and_rearms(flying: Bench) -> None:
    flying.motors = (0,) * 4
    flying.run_to(6000)
    assert flying.history == {2200: LANDED, 5240: RESET, 5280: NOT_PASSED, 5320: PASSED, 5360: READY}


def test_it_may_take_off_again_while_landed(flying: Bench) -> None:
    flying.motors = (0,) * 4
    flying.run_to(4000)
    flying.motors = (30000,) * 4
    flying.run_to(10000)
    assert flying.history == {2200: LANDED, 4040: FLYING}


def test_second_landing_has_its_own_timeout(flying: Bench) -> None:
    flying.motors = (0,) * 4
    flying.run_to(4000)
    flying.motors = (30000,) * 4
    flying.run_to(12000)
    flying.motors = (0,) * 4
    flying.run_to(18000)
    after = {k: v for k, v in flying.history.items() if k > 12000}
    assert after == {14000: LANDED, 17040: RESET, 17080: NOT_PASSED, 17120: PASSED, 17160: READY}


def test_becoming_ready_within_two_seconds_of_thrust_counts_as_flying(flying: Bench) -> None:
    lib.cf_supervisor_request_arming(flying.supervisor, False)
    flying.run_to(240)
    flying.motors = (0,) * 4
    flying.run_to(3000)
    assert flying.history == {240: RESET, 280: NOT_PASSED, 320: PASSED, 360: READY, 400: FLYING, 2240: LANDED}


# --- age of the setpoint


def test_old_setpoint_levels_out_then_locks(flying: Bench) -> None:
    flying.run_to(1000)
    flying.setpoint_tick = 1000
    flying.run_to(4000)
    assert flying.history == {1520: WARNING, 3040: FREE_FALL, 3080: LOCKED}
    assert flying.console == ["Locked, reboot required"]
    assert lib.cf_supervisor_is_locked(flying.supervisor)


def test_setpoint_of_exactly_500_ms_is_fresh(flying: Bench) -> None:
    flying.run_to(1020)
    flying.setpoint_tick = 1020
    flying.run_to(1520)
    assert flying.history == {}
    flying.run_to(1560)
    assert flying.history == {1560: WARNING}


def test_fresh_setpoint_ends_the_warning(flying: Bench) -> None:
    flying.run_to(1000)
    flying.setpoint_tick = 1000
    flying.run_to(2500)
    flying.setpoint_tick = None
    flying.run_to(3000)
    assert flying.history == {1520: WARNING, 2520: FLYING}


def test_old_setpoint_is_no_matter_on_the_ground(bench: Bench) -> None:
    bench.setpoint_tick = 0
    bench.run_to(10000)
    assert bench.state == READY


# --- tumbling


@pytest.mark.parametrize(
    ("acc", "entered"), [(UPSIDE_DOWN, 1160), (ON_ITS_SIDE, 2080), ((0.8, 0.0, 0.49), 2080), ((0.0, 0.9, -0.19), 2080)]
)
def test_tumble_in_flight_is_a_crash(flying: Bench, acc: tuple[float, float, float], entered: int) -> None:
    flying.run_to(1001)
    flying.acc = acc  # seen from step 1040 on
    flying.run_to(3000)
    assert flying.history == {entered: CRASHED}
    assert flying.console == ["Crashed, recovery required"]
    assert lib.cf_supervisor_is_crashed(flying.supervisor)
    assert not lib.cf_supervisor_is_armed(flying.supervisor)
    assert not lib.cf_supervisor_are_motors_allowed(flying.supervisor)


@pytest.mark.parametrize("acc", [FALLING, (0.9, 0.0, 0.5), (math.nan, math.nan, math.nan)])
def test_free_fall_and_small_tilts_are_no_tumble(flying: Bench, acc: tuple[float, float, float]) -> None:
    flying.acc = acc
    flying.run_to(5000)
    assert flying.history == {}


def test_short_tilt_is_forgotten(flying: Bench) -> None:
    for _ in range(5):
        flying.acc = ON_ITS_SIDE
        flying.run(960)
        flying.acc = FALLING
        flying.run(40)
    assert flying.history == {}


def test_tumble_check_can_be_switched_off_while_its_clock_runs(flying: Bench) -> None:
    flying.supervisor.tmblChckEn = 0
    flying.acc = UPSIDE_DOWN
    flying.run_to(3000)
    assert flying.history == {}
    flying.supervisor.tmblChckEn = 1
    flying.run_to(3040)
    assert flying.history == {3040: CRASHED}


def test_crash_recovery_needs_an_upright_vehicle(flying: Bench) -> None:
    flying.acc = UPSIDE_DOWN
    flying.motors = (0,) * 4
    flying.run_to(4000)
    assert flying.state == CRASHED
    assert not lib.cf_supervisor_request_crash_recovery(flying.supervisor, True)

    flying.acc = UPRIGHT
    flying.run_to(6000)
    assert flying.state == CRASHED
    assert lib.cf_supervisor_request_crash_recovery(flying.supervisor, True)
    assert not lib.cf_supervisor_is_crashed(flying.supervisor)
    flying.history.clear()
    flying.run_to(6500)
    assert flying.history == {6040: NOT_PASSED, 6080: PASSED, 6120: READY}


def test_crash_recovery_of_a_sound_vehicle_succeeds(bench: Bench) -> None:
    assert lib.cf_supervisor_request_crash_recovery(bench.supervisor, True)
    assert lib.cf_supervisor_request_crash_recovery(bench.supervisor, False)
    assert lib.cf_supervisor_is_crashed(bench.supervisor)


def test_tumbled_vehicle_never_becomes_ready(bench: Bench) -> None:
    bench.acc = UPSIDE_DOWN
    bench.run_to(2000)
    # the check needs 100 ms, so that it is ready for one update
    assert bench.history == {40: NOT_PASSED, 80: PASSED, 120: READY, 160: NOT_PASSED}
    assert lib.cf_supervisor_is_tumbled(bench.supervisor)
    assert bench.supervisor.is_tumbled == 1


# --- emergency stop


def test_stop_parameter_locks(flying: Bench) -> None:
    flying.supervisor.stop = 1
    flying.run_to(300)
    flying.supervisor.stop = 0
    flying.run_to(1000)
    assert flying.history == {240: FREE_FALL, 280: LOCKED}


def test_requested_stop_is_latched(flying: Bench) -> None:
    lib.cf_supervisor_request_emergency_stop(flying.supervisor)
    flying.run_to(1000)
    assert flying.history == {240: FREE_FALL, 280: LOCKED}


def test_emergency_watchdog_has_to_be_fed(flying: Bench) -> None:
    for _ in range(4):
        lib.cf_supervisor_notify_emergency_watchdog(flying.supervisor, flying.step)
        flying.run(900)
    last = flying.step - 900
    flying.run_to(last + 2000)
    # the first update at or after 1000 ms
    assert flying.history == {-(-(last + 1000) // 40) * 40: FREE_FALL, -(-(last + 1000) // 40) * 40 + 40: LOCKED}


def test_crashed_vehicle_can_be_stopped(flying: Bench) -> None:
    flying.acc = UPSIDE_DOWN
    flying.run_to(1000)
    lib.cf_supervisor_request_emergency_stop(flying.supervisor)
    flying.run_to(1040)
    assert flying.state == LOCKED


def test_locked_vehicle_stays_locked(flying: Bench) -> None:
    lib.cf_supervisor_request_emergency_stop(flying.supervisor)
    flying.run_to(280)
    flying.supervisor.emergency_stop_requested = False
    assert not lib.cf_supervisor_request_arming(flying.supervisor, True)
    flying.run_to(5000)
    assert flying.state == LOCKED


# --- override


@pytest.mark.parametrize("state", range(lib.supervisorState_NrOfStates))
def test_override_follows_the_state(bench: Bench, state: int) -> None:
    bench.supervisor.state = state
    setpoint = ffi.new("setpoint_t *")
    ffi.memmove(setpoint, b"\x01" * ffi.sizeof(setpoint[0]), ffi.sizeof(setpoint[0]))
    setpoint.position.z = 0.5
    before = bytes(ffi.buffer(setpoint))
    lib.cf_supervisor_override_setpoint(bench.supervisor, setpoint)

    if state in (READY, FLYING, LANDED):
        assert bytes(ffi.buffer(setpoint)) == before
    elif state == WARNING:
        mode = setpoint.mode
        assert [mode.x, mode.y, mode.roll, mode.pitch, mode.yaw] == [
            lib.modeDisable,
            lib.modeDisable,
            lib.modeAbs,
            lib.modeAbs,
            lib.modeVelocity,
        ]
        assert [setpoint.attitude.roll, setpoint.attitude.pitch, setpoint.attitudeRate.yaw] == [0.0, 0.0, 0.0]
        assert setpoint.position.z == 0.5
        assert mode.z == 0x01010101
    else:
        assert not any(bytes(ffi.buffer(setpoint)))


# --- outputs


def info_names(bench: Bench) -> set[str]:
    names = (
        "CAN_ARM IS_ARMED AUTO_ARM CAN_FLY IS_FLYING IS_TUMBLED IS_LOCKED IS_CRASHED HL_ACTIVE HL_FINISHED HL_DISABLED"
    )
    return {name for n, name in enumerate(names.split()) if bench.supervisor.info & (1 << n)}


def test_info_tells_the_state(bench: Bench) -> None:
    bench.run_to(80)
    assert info_names(bench) == {"CAN_ARM", "IS_ARMED", "AUTO_ARM", "HL_FINISHED"}
    bench.planner_state, bench.planner_is_finished = lib.TRAJECTORY_STATE_FLYING, False
    bench.motors = (1, 0, 0, 0)
    bench.run_to(160)
    assert info_names(bench) == {"IS_ARMED", "AUTO_ARM", "CAN_FLY", "IS_FLYING", "HL_ACTIVE"}
    bench.planner_state = lib.TRAJECTORY_STATE_DISABLED
    bench.acc = UPSIDE_DOWN
    bench.run_to(400)
    assert info_names(bench) == {"AUTO_ARM", "IS_TUMBLED", "IS_CRASHED", "HL_DISABLED"}
    lib.cf_supervisor_request_emergency_stop(bench.supervisor)
    bench.planner_state = lib.TRAJECTORY_STATE_LANDING
    bench.run_to(440)
    assert info_names(bench) == {"AUTO_ARM", "IS_TUMBLED", "IS_CRASHED", "IS_LOCKED", "HL_ACTIVE"}


def test_supervisor_works_25_times_a_second(bench: Bench) -> None:
    inputs = ffi.new("cf_supervisor_inputs_t *", {"acc": {"z": 1.0}})
    for step in (1, 39, 41, 79):
        lib.cf_supervisor_update(bench.supervisor, inputs, step)
    assert bench.state == BOOT
    lib.cf_supervisor_update(bench.supervisor, inputs, 2**32 - 16)  # a multiple of 40
    assert bench.state == NOT_PASSED


def test_dump_flag_clears_itself(bench: Bench) -> None:
    bench.supervisor.infdmp = 1
    bench.run_to(40)
    assert bench.supervisor.infdmp == 0


# --- parameters and logs (docs/reference/planner-commander.md#16)


def rows_of(variables) -> list[tuple[str, int, int]]:
    return [
        (
            f"{ffi.string(variables.rows[i].group).decode()}.{ffi.string(variables.rows[i].name).decode()}",
            variables.rows[i].type,
            variables.rows[i].flags,
        )
        for i in range(variables.count)
    ]


def test_parameters_have_names_types_and_flags() -> None:
    assert rows_of(lib.cf_supervisor_parameters()) == [
        ("stabilizer.stop", lib.CF_TYPE_UINT8, lib.CF_CORE),
        ("supervisor.infdmp", lib.CF_TYPE_UINT8, 0),
        ("supervisor.prefltTimeout", lib.CF_TYPE_UINT16, lib.CF_PERSISTENT),
        ("supervisor.landedTimeout", lib.CF_TYPE_UINT16, lib.CF_PERSISTENT),
        ("supervisor.tmblChckEn", lib.CF_TYPE_UINT8, lib.CF_PERSISTENT),
    ]


def test_parameters_have_defaults(bench: Bench) -> None:
    s = bench.supervisor
    assert [s.stop, s.infdmp, s.prefltTimeout, s.landedTimeout, s.tmblChckEn] == [0, 0, 30000, 3000, 1]


def test_logs_have_names_types_and_flags() -> None:
    assert rows_of(lib.cf_supervisor_logs()) == [
        ("sys.canfly", lib.CF_TYPE_UINT8, lib.CF_CORE),
        ("sys.isFlying", lib.CF_TYPE_UINT8, lib.CF_CORE),
        ("sys.isTumbled", lib.CF_TYPE_UINT8, lib.CF_CORE),
        ("sys.armed", lib.CF_TYPE_UINT8, 0),
        ("supervisor.info", lib.CF_TYPE_UINT16, 0),
    ]
