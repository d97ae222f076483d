"""The test override of the motors (docs/reference/control-pid.md#14 and #17)."""

import pytest

from crazychoir_fw._core import ffi, lib

CURVE = ffi.addressof(lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust)


def make_override(enable, motor=(36000, 2000, 3000, 4000)):
    motor_override = ffi.new("cf_motor_override_t *")
    lib.cf_motor_override_init(motor_override)
    motor_override.enable = enable
    motor_override.motor = motor
    return motor_override


def apply(motor_override, battery_voltage=4.2):
    pwm = ffi.new("motors_thrust_pwm_t *", {"list": (1, 2, 3, 4)})
    lib.cf_motor_override_apply(motor_override, CURVE, battery_voltage, pwm)
    return tuple(pwm.list)


@pytest.mark.parametrize(
    ("enable", "motors"),
    [(0, (1, 2, 3, 4)), (1, (36000, 2000, 3000, 4000)), (2, (36000,) * 4), (4, (1, 2, 3, 4)), (255, (1, 2, 3, 4))],
)
def test_modes_without_compensation(enable, motors):
    assert apply(make_override(enable)) == motors


def test_mode_three_compensates_the_first_value():
    assert apply(make_override(3)) == pytest.approx((35861,) * 4, abs=2, rel=0)


def test_mode_three_filters_the_battery_voltage():
    motor_override = make_override(3)
    apply(motor_override, 3.2)
    assert motor_override.supply_voltage == pytest.approx(4.19, rel=1e-6)
    for _ in range(2000):
        motors = apply(motor_override, 3.7)
    assert motors == pytest.approx((40708,) * 4, abs=2, rel=0)


def test_other_modes_leave_the_filter_alone():
    motor_override = make_override(2)
    apply(motor_override, 3.2)
    assert motor_override.supply_voltage == pytest.approx(4.2)


def test_mode_three_stops_at_full_duty():
    motor_override = make_override(3, (65535, 0, 0, 0))
    motor_override.supply_voltage = 2.5
    assert apply(motor_override, 2.5) == (65535,) * 4


def test_parameter_table():
    table = lib.cf_motor_override_parameters()
    rows = [table.rows[i] for i in range(table.count)]
    assert {ffi.string(row.group) for row in rows} == {b"motorPowerSet"}
    assert [(ffi.string(row.name), row.type) for row in rows] == [
        (b"enable", lib.CF_TYPE_UINT8),
        *[(name, lib.CF_TYPE_UINT16) for name in (b"m1", b"m2", b"m3", b"m4")],
    ]
    assert {row.flags for row in rows} == {lib.CF_CORE}
