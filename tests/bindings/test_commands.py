"""Commands, attributes and texts of the core that the Python package does not need, or asks for in vain."""

import mujoco
import pytest

from crazychoir_fw._core import ffi, lib


@pytest.fixture
def cf():
    config, cf = ffi.new("cf_config_t *"), ffi.new("cf_t *")
    assert lib.cf_config_default(config, lib.CF_PLATFORM_CF2) == lib.CF_OK
    assert lib.cf_init(cf, config) == lib.CF_OK
    return cf


def text(pointer):
    return ffi.string(pointer).decode()


def test_full_state_is_handed_over_as_it_is(cf):
    """Python sends the packet, which rounds to millimeters; a C client need not."""
    full_state = ffi.new("cf_full_state_t *", {"position": {"x": 0.12345}, "attitude": {"w": 1.0}})
    assert lib.cf_send_full_state(cf, full_state) == lib.CF_OK
    assert cf.onboard.commander.setpoint.position.x == pytest.approx(0.12345)
    full_state.velocity.z = float("nan")
    assert lib.cf_send_full_state(cf, full_state) == lib.CF_ERR_VALUE


def test_stop_of_the_high_level_commander_is_never_refused(cf):
    assert lib.cf_stop(cf) == lib.CF_OK
    assert lib.cf_provider(0).plan_is_stopped(cf.provider_state)


@pytest.mark.parametrize(("member", "value"), [("provider", 99), ("platform", 99), ("controller", 99)])
def test_a_drone_of_unknown_parts_is_not_built(member, value):
    config, cf = ffi.new("cf_config_t *"), ffi.new("cf_t *")
    lib.cf_config_default(config, lib.CF_PLATFORM_CF2)
    setattr(config, member, ffi.cast("cf_platform_t", value) if member == "platform" else value)
    assert lib.cf_init(cf, config) == lib.CF_ERR_UNKNOWN


@pytest.mark.parametrize("number", [-1, 10_000])
def test_an_attribute_that_does_not_exist_is_told(number):
    config, message = ffi.new("cf_config_t *"), ffi.new("char[]", lib.CF_ATTRIBUTE_MESSAGE_BYTES)
    assert lib.cf_attribute_set(config, number, b"1", message) == lib.CF_ERR_UNKNOWN
    assert text(message) == f"no attribute number {number}"
    allowed = ffi.new("char[]", b"something")
    lib.cf_attribute_range(number, allowed, 10)
    assert text(allowed) == ""
    assert lib.cf_attribute_name(number) == ffi.NULL


def test_blanks_behind_a_number_are_no_matter():
    config, message = ffi.new("cf_config_t *"), ffi.new("char[]", lib.CF_ATTRIBUTE_MESSAGE_BYTES)
    lib.cf_config_default(config, lib.CF_PLATFORM_CF2)
    names = [text(lib.cf_attribute_name(i)) for i in range(lib.cf_attribute_count())]
    assert lib.cf_attribute_set(config, names.index("battery"), b"0.5  ", message) == lib.CF_OK
    assert lib.cf_attribute_set(config, names.index("battery"), b"0.5 V", message) == lib.CF_ERR_VALUE


@pytest.mark.parametrize("number", [-99, 99])
def test_texts_have_a_word_for_numbers_that_do_not_exist(number):
    assert text(lib.cf_status_text(ffi.cast("cf_status_t", number))) == "unknown status"
    assert text(lib.cf_fault_text(ffi.cast("cf_fault_t", number))) == "unknown fault"


def test_the_core_knows_the_mujoco_it_was_built_with():
    assert lib.cf_plugin_mujoco_version() == mujoco.mj_version()


def test_good_statuses_and_faults_have_texts():
    assert text(lib.cf_status_text(lib.CF_OK)) == "success"
    assert text(lib.cf_fault_text(lib.CF_FAULT_NONE)) == "none"
