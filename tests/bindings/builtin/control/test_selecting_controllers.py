"""Every controller is selected in the same way, through the provider."""

import pytest
from geometric_inputs import UPSTREAM_MODES, Provider, make_sensors, make_setpoint, make_state

from crazychoir_fw._core import ffi, lib

NAMES = {
    lib.ControllerTypePID: "PID",
    lib.ControllerTypeMellinger: "Mellinger",
    lib.ControllerTypeINDI: "INDI",
    lib.ControllerTypeBrescianini: "Brescianini",
    lib.ControllerTypeLee: "Lee",
}


@pytest.mark.parametrize("number", NAMES, ids=NAMES.get)
def test_the_provider_knows_it(number):
    provider = Provider()
    assert provider.name(number) == NAMES[number]
    assert provider.select(number) == lib.CF_OK
    assert provider.selected == number


@pytest.mark.parametrize("selected", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("number", [-1, lib.ControllerType_COUNT, 255])
def test_a_number_that_no_controller_has_changes_nothing(number, selected):
    provider = Provider()
    provider.select(selected)
    provider.fly(make_setpoint(UPSTREAM_MODES, position=(0.1, -0.2, 1.3)), make_sensors((10, -20, 30)), make_state(), 2)
    before = bytes(ffi.buffer(provider.block))
    assert provider.select(number) == lib.CF_ERR_UNKNOWN
    assert provider.name(number) is None
    assert bytes(ffi.buffer(provider.block)) == before


def test_automatic_selection_is_the_pid():
    provider = Provider()
    provider.select(lib.ControllerTypeLee)
    assert provider.select(lib.ControllerTypeAutoSelect) == lib.CF_OK
    assert provider.selected == lib.ControllerTypePID
