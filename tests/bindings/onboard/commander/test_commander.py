"""Priorities of the commander (docs/reference/planner-commander.md#8)."""

import pytest

from crazychoir_fw._core import ffi, lib

HIGH_LEVEL = lib.COMMANDER_PRIORITY_HIGHLEVEL
CRTP = lib.COMMANDER_PRIORITY_CRTP
EXTRX = lib.COMMANDER_PRIORITY_EXTRX


class Bench:
    """A commander and what it needs."""

    def __init__(self, provider) -> None:
        self.provider = provider
        self.commander = ffi.new("cf_commander_t *")
        lib.cf_commander_init(self.commander, 100)

    def set(self, thrust: float, priority: int, now: int = 0) -> bool:
        setpoint = ffi.new("setpoint_t *", {"thrust": thrust})
        table, state = self.provider.table, self.provider.state
        return lib.cf_commander_set_setpoint(self.commander, table, state, setpoint, priority, now)

    def get(self):
        setpoint = ffi.new("setpoint_t *")
        lib.cf_commander_get_setpoint(self.commander, setpoint)
        return setpoint

    @property
    def priority(self) -> int:
        return lib.cf_commander_active_priority(self.commander)

    def plan_takeoff(self) -> None:
        start = ffi.new("cf_plan_start_t *")
        lib.cf_planner_init(self.provider.state)
        lib.cf_planner_takeoff(self.provider.state, start, 1.0, 0.0, 2.0, 0.0)


@pytest.fixture
def bench(provider) -> Bench:
    return Bench(provider)


def test_fresh_commander_holds_the_null_setpoint(bench: Bench) -> None:
    assert bench.priority == lib.COMMANDER_PRIORITY_DISABLE
    assert lib.cf_commander_inactivity_time(bench.commander, 150) == 50
    assert not any(bytes(ffi.buffer(bench.get())))


def test_setpoint_is_stamped(bench: Bench) -> None:
    assert bench.set(5.0, CRTP, now=1234)
    assert [bench.get().thrust, bench.get().timestamp] == [5.0, 1234]
    assert lib.cf_commander_inactivity_time(bench.commander, 1300) == 66


@pytest.mark.parametrize("active", [0, HIGH_LEVEL, CRTP, EXTRX])
@pytest.mark.parametrize("priority", [0, HIGH_LEVEL, CRTP, EXTRX])
def test_lower_priority_is_ignored(bench: Bench, active: int, priority: int) -> None:
    bench.set(1.0, active, now=10)
    accepted = bench.set(2.0, priority, now=20)
    assert accepted == (priority >= active)
    assert bench.get().thrust == (2.0 if accepted else 1.0)
    assert bench.get().timestamp == (20 if accepted else 10)
    assert bench.priority == max(active, priority)


@pytest.mark.parametrize(("priority", "is_stopped"), [(HIGH_LEVEL, False), (CRTP, True), (EXTRX, True)])
def test_low_level_setpoint_stops_the_planner(bench: Bench, priority: int, is_stopped: bool) -> None:
    bench.plan_takeoff()
    bench.set(1.0, priority)
    assert lib.cf_planner_is_stopped(bench.provider.state) == is_stopped


def test_ignored_setpoint_does_not_stop_the_planner(bench: Bench) -> None:
    bench.set(1.0, EXTRX)
    bench.plan_takeoff()
    assert not bench.set(1.0, CRTP)
    assert not lib.cf_planner_is_stopped(bench.provider.state)


def test_relax_gives_way_to_plans_that_start_at_the_estimate(bench: Bench) -> None:
    high_level = ffi.new("cf_high_level_commander_t *")
    lib.cf_high_level_commander_init(high_level)
    estimate = ffi.new("state_t *")
    estimate.position.y = 2.0
    estimate.velocity.z = 3.0
    estimate.attitude.yaw = 180.0

    bench.set(1.0, CRTP)
    assert not bench.set(2.0, HIGH_LEVEL)
    lib.cf_commander_relax_priority(bench.commander, high_level, estimate)
    assert bench.priority == lib.COMMANDER_PRIORITY_LOWEST
    assert bench.set(2.0, HIGH_LEVEL)
    assert [high_level.pos.y, high_level.vel.z, high_level.yaw] == pytest.approx([2.0, 3.0, 3.14159265])


def test_parameter_has_name_type_and_flags(bench: Bench) -> None:
    table = lib.cf_commander_parameters()
    assert table.count == 1
    row = table.rows[0]
    assert (ffi.string(row.group), ffi.string(row.name)) == (b"commander", b"enHighLevel")
    assert (row.type, row.flags) == (lib.CF_TYPE_UINT8, lib.CF_CORE)
    assert bench.commander.enHighLevel == 0
