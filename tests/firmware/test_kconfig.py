"""Kconfig files of a checkout: what they give for each platform, and that nothing in them is run."""

import os
import sys
from pathlib import Path

import pytest
from miniature import lay_out

from crazychoir_fw.firmware.configuration import read_kconfig, settings

# symbol: what cf2, cf21bl and bolt have; None is off or unknown
EXPECTED = {
    "CONFIG_ENABLE_THRUST_BAT_COMPENSATED": ("1", "1", None),
    "CONFIG_CRAZYFLIE_21_PLUS": ("1", None, None),
    "CONFIG_CRAZYFLIE_LEGACY_PROPELLERS": (None, None, None),
    "CONFIG_THRUST_BAT_COMPENSATION_MAX_THRUST": (None, "200", None),
    "CONFIG_CONTROLLER_AUTO_SELECT": ("1", "1", "1"),
    "CONFIG_CONTROLLER_PID": (None, None, None),
    "CONFIG_CONTROLLER_PID_FILTER_ALL": (None, None, None),
    "CONFIG_ESTIMATOR_KALMAN_ENABLE": ("1", "1", "1"),
    "CONFIG_ESTIMATOR_OUTLIER_FILTERS": ("1", "1", "1"),
    "CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK": (None, None, None),
    "CONFIG_ESTIMATOR_UKF_ENABLE": (None, None, None),
    "CONFIG_MOTORS_ESC_PROTOCOL_ONESHOT125": ("1", None, "1"),
    "CONFIG_MOTORS_ESC_PROTOCOL_DSHOT": (None, "1", None),
    "CONFIG_MOTORS_REQUIRE_ARMING": (None, "1", None),
    "CONFIG_MOTORS_DEFAULT_IDLE_THRUST": (None, "7000", None),
    "CONFIG_MOTORS_DEFAULT_PROP_TEST_PWM_RATIO": ("0", "0", "0"),
    "CONFIG_MOTORS_DEFAULT_BAT_TEST_PWM_RATIO": ("0", "0", "0"),
    "CONFIG_POWER_DISTRIBUTION_QUADROTOR": ("1", "1", "1"),
    "CONFIG_IMU_MAHONY_QUATERNION": ("1", "1", "1"),
}
# of a host build: no decks, no task of an app, no motors that tell how fast they turn
ABSENT = (
    "CONFIG_DECK_USD",
    "CONFIG_DECK_LIGHTHOUSE",
    "CONFIG_APP_ENABLE",
    "CONFIG_MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL",
)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    return lay_out(tmp_path_factory.mktemp("kconfig") / "checkout")


@pytest.mark.parametrize("column, platform", [(0, "cf2"), (1, "cf21bl"), (2, "bolt")])
def test_symbols_of_the_platforms(root, column, platform):
    chosen = settings(root, platform)
    for symbol, values in EXPECTED.items():
        assert chosen.get(symbol) == values[column], symbol
    assert not set(ABSENT) & chosen.keys()


def test_a_symbol_of_a_fork_gets_its_default(root, tmp_path):
    kconfig = lay_out(tmp_path / "fork") / "Kconfig"
    kconfig.write_text(
        kconfig.read_text()
        + 'config MY_GAIN\n  int "gain"\n  default 42\n\nconfig MY_NAME\n  string "name"\n  default "a\\"b"\n\n'
        + 'config MY_HALF\n  bool "half"\n  default y\n  depends on PLATFORM_BOLT\n'
    )
    chosen = settings(kconfig.parent, "cf2")
    assert (chosen["CONFIG_MY_GAIN"], chosen["CONFIG_MY_NAME"]) == ("42", '"a\\"b"')
    assert "CONFIG_MY_HALF" not in chosen
    assert settings(kconfig.parent, "bolt")["CONFIG_MY_HALF"] == "1"


def test_no_shell_is_run_and_nothing_is_imported(tmp_path, monkeypatch):
    trace = tmp_path / "trace"
    (tmp_path / "Kconfig").write_text(
        f'stolen := $(shell,touch {trace})\nconfig A\n  string "a"\n  default "$(shell,touch {trace}; echo evil)"\n'
    )
    (tmp_path / "kconfigfunctions.py").write_text(f"open({str(trace)!r}, 'w')\nfunctions = {{}}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = dict(os.environ)
    values, known = read_kconfig(tmp_path, tmp_path / "none")
    assert (values, known) == ({"CONFIG_A": '""'}, {"CONFIG_A"}) or values == {}
    assert not trace.exists()
    assert "kconfigfunctions" not in sys.modules
    assert dict(os.environ) == before


@pytest.mark.parametrize("text", ["config\n", "source nowhere\n", "if\n", "\0\0", 'menu "x"\n'])
def test_without_files_that_can_be_read_the_stock_configuration_counts(tmp_path, text):
    assert read_kconfig(tmp_path, tmp_path / "none") is None
    stock = settings(tmp_path, "cf21bl")
    (tmp_path / "Kconfig").write_text(text)
    assert read_kconfig(tmp_path, tmp_path / "none") in (None, ({}, set()))
    assert settings(tmp_path, "cf21bl") == stock
    assert stock["CONFIG_MOTORS_DEFAULT_IDLE_THRUST"] == "7000"


def test_files_are_found_from_any_folder(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expected = settings(root, "cf2")
    monkeypatch.chdir(Path(root).anchor)
    assert settings(root, "cf2") == expected
