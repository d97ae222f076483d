"""What holds for the supervisor whatever happens to it (docs/reference/planner-commander.md#14)."""

from hypothesis import given
from hypothesis import strategies as st
from supervisor_states import FLYING, LANDED, LOCKED, READY, WARNING

from crazychoir_fw._core import ffi, lib

MOTORS_ALLOWED = {READY, FLYING, WARNING, LANDED}

accelerations = st.floats(-16, 16) | st.sampled_from([0.0, 1.0, -1.0, float("nan")])
events = st.tuples(
    st.sampled_from(["update", "update", "update", "arm", "disarm", "recover", "crash", "stop", "notify", "parameter"]),
    st.tuples(accelerations, accelerations, accelerations),
    st.integers(0, 65535),  # motor ratio
    st.integers(0, 3000),  # age of the setpoint [ms]
    st.integers(1, 5000),  # time until the next event [ms]
)


def act(supervisor, name, now):
    """Do what a client may ask for; returns what a request to arm got."""
    if name in ("arm", "disarm"):
        return lib.cf_supervisor_request_arming(supervisor, name == "arm")
    if name in ("recover", "crash"):
        lib.cf_supervisor_request_crash_recovery(supervisor, name == "recover")
    elif name == "stop":
        lib.cf_supervisor_request_emergency_stop(supervisor)
    elif name == "notify":
        lib.cf_supervisor_notify_emergency_watchdog(supervisor, now)
    elif name == "parameter":
        supervisor.stop = 1 - supervisor.stop
    return None


def update(supervisor, acc, ratio, age, now):
    inputs = ffi.new("cf_supervisor_inputs_t *")
    inputs.acc.x, inputs.acc.y, inputs.acc.z = acc
    inputs.now = now
    inputs.setpoint_tick = max(0, now - age)
    inputs.motor_ratio = [ratio] * 4
    lib.cf_supervisor_update(supervisor, inputs, 40)


@given(st.booleans(), st.lists(events, max_size=60))
def test_locked_is_for_good_and_motors_run_in_four_states_only(auto_arming, history):
    supervisor = ffi.new("cf_supervisor_t *")
    lib.cf_supervisor_init(supervisor, auto_arming)
    now = 1
    was_locked = False
    before = supervisor.state
    for name, acc, ratio, age, pause in history:
        now += pause
        granted = act(supervisor, name, now)
        update(supervisor, acc, ratio, age, now)

        is_locked = supervisor.state == LOCKED
        assert is_locked or not was_locked
        if was_locked:
            assert not (name == "arm" and granted)
        was_locked = is_locked
        if is_locked:
            assert not supervisor.is_armed
            assert not supervisor.can_fly
            assert supervisor.info & lib.CF_SUPERVISOR_INFO_IS_LOCKED

        allowed = lib.cf_supervisor_are_motors_allowed(supervisor)
        assert allowed == (supervisor.state in MOTORS_ALLOWED)
        # a drone that levels out looks at the arming flag only when it flies again
        # (docs/reference/planner-commander.md#14.5)
        assert not allowed or supervisor.is_armed or WARNING in (before, supervisor.state)
        before = supervisor.state
        assert bool(supervisor.info & lib.CF_SUPERVISOR_INFO_CAN_FLY) == allowed


@given(st.booleans(), st.lists(events, max_size=40), st.tuples(accelerations, accelerations, accelerations))
def test_an_emergency_stop_locks_at_the_latest_when_landing_has_timed_out(auto_arming, history, acc):
    """Of all states only "Landed" does not look at it; that state ends by itself after 3 s."""
    supervisor = ffi.new("cf_supervisor_t *")
    lib.cf_supervisor_init(supervisor, auto_arming)
    now = 1
    for name, shaking, ratio, age, pause in history:
        now += pause
        act(supervisor, name, now)
        update(supervisor, shaking, ratio, age, now)
    lib.cf_supervisor_request_emergency_stop(supervisor)
    for _ in range(6 if supervisor.state != LANDED else 80):
        now += 40
        update(supervisor, acc, 0, 0, now)
    assert supervisor.state == LOCKED
