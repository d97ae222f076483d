import pytest

from crazychoir_fw.common.errors import CheckoutError, UnknownNameError
from crazychoir_fw.firmware.configuration import PLATFORMS, header_text, read_header, settings, symbols_in


@pytest.fixture
def root(tmp_path):
    (tmp_path / "configs").mkdir()
    return tmp_path


@pytest.mark.parametrize("platform", PLATFORMS)
def test_exactly_one_platform(root, platform):
    (root / "configs" / f"{platform}_defconfig").write_text("CONFIG_PLATFORM_TAG=y\nCONFIG_PLATFORM_CF2=y\n")
    chosen = settings(root, platform)
    assert [name for name in chosen if name.startswith("CONFIG_PLATFORM_")] == [f"CONFIG_PLATFORM_{platform.upper()}"]


def test_arming_of_the_platforms(root):
    assert "CONFIG_MOTORS_REQUIRE_ARMING" not in settings(root, "cf2")
    assert settings(root, "cf21bl")["CONFIG_MOTORS_DEFAULT_IDLE_THRUST"] == "7000"
    # no thrust curve: compensation would divide by zero
    assert "CONFIG_ENABLE_THRUST_BAT_COMPENSATED" not in settings(root, "bolt")


def test_the_defconfig_of_the_checkout_counts(root):
    (root / "configs" / "cf2_defconfig").write_text(
        "CONFIG_A=y\nCONFIG_B=n\n# CONFIG_ESTIMATOR_KALMAN_ENABLE is not set\nCONFIG_N=-12\nCONFIG_H=0x1F\n"
        'CONFIG_TEXT="a \\"b\\""\nCONFIG_EVIL=system("x")\nCONFIG_ENABLE_THRUST_BAT_COMPENSATED=n\n'
    )
    chosen = settings(root, "cf2")
    assert chosen["CONFIG_A"] == "1"
    assert (chosen["CONFIG_N"], chosen["CONFIG_H"], chosen["CONFIG_TEXT"]) == ("-12", "0x1F", '"a \\"b\\""')
    absent = {"CONFIG_B", "CONFIG_EVIL", "CONFIG_ESTIMATOR_KALMAN_ENABLE", "CONFIG_ENABLE_THRUST_BAT_COMPENSATED"}
    assert not absent & chosen.keys()


def test_other_propellers_put_the_stock_ones_aside(root):
    assert "CONFIG_CRAZYFLIE_21_PLUS" in settings(root, "cf2")
    (root / "configs" / "cf2_defconfig").write_text("CONFIG_CRAZYFLIE_THRUST_UPGRADE_KIT=y\n")
    chosen = settings(root, "cf2")
    assert chosen["CONFIG_CRAZYFLIE_THRUST_UPGRADE_KIT"] == "1"
    assert "CONFIG_CRAZYFLIE_21_PLUS" not in chosen


def test_unknown_platform(root):
    with pytest.raises(UnknownNameError, match="no platform named 'cf3', allowed: cf2, cf21bl, bolt"):
        settings(root, "cf3")


def test_platform_that_the_checkout_lacks(root):
    folder = root / "src" / "platform" / "interface"
    folder.mkdir(parents=True)
    (folder / "platform_defaults.h").write_text("")
    (folder / "platform_defaults_cf2.h").write_text("")
    assert settings(root, "cf2")
    with pytest.raises(CheckoutError, match="has no platform cf21bl; it has cf2$"):
        settings(root, "cf21bl")


def test_header_goes_there_and_back(tmp_path, root):
    chosen = settings(root, "cf21bl", extra=["CONFIG_CONTROLLER_OOT"])
    path = tmp_path / "autoconf.h"
    path.write_text(header_text(chosen))
    assert read_header(path, "cf21bl") == chosen
    assert chosen["CONFIG_CONTROLLER_OOT"] == "1"
    with pytest.raises(CheckoutError, match="is for platform cf21bl, asked for is cf2"):
        read_header(path, "cf2")
    with pytest.raises(CheckoutError, match="cannot be read"):
        read_header(tmp_path / "none.h", "cf2")


def test_symbols_in_files(tmp_path):
    (tmp_path / "a.c").write_text("#ifdef CONFIG_ONE\n#if CONFIG_TWO_2 == 1\nMY_CONFIG_THREE CONFIG_ONE")
    assert symbols_in([tmp_path / "a.c"]) == {"CONFIG_ONE", "CONFIG_TWO_2"}
