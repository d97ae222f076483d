"""Which provider is behind the names."""

import subprocess
import sys
from pathlib import Path

import pytest

from crazychoir_fw import cffirmware
from crazychoir_fw.cffirmware import selection
from crazychoir_fw.common.errors import CheckoutError, UnknownNameError


def test_builtin_is_the_default(monkeypatch):
    monkeypatch.delenv("CRAZYCHOIR_PROVIDER", raising=False)
    monkeypatch.delenv("CRAZYCHOIR_PLATFORM", raising=False)
    firm = selection.chosen()
    assert (firm.provider, firm.platform) == ("builtin", "cf2")
    assert firm is cffirmware.over("builtin", "cf2")


def test_environment_chooses(monkeypatch, over_miniature, checkout):
    expected = over_miniature("2026.08")
    monkeypatch.setenv("CRAZYCHOIR_PROVIDER", "bitcraze")
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(checkout("2026.08")))
    monkeypatch.setattr(selection, "_bitcraze", lambda platform, path: (expected, platform, path))
    assert selection.chosen() == (expected, "cf2", None)
    monkeypatch.setenv("CRAZYCHOIR_PROVIDER", "builtin")
    monkeypatch.setenv("CRAZYCHOIR_PLATFORM", "cf21bl")
    assert selection.chosen().platform == "cf21bl"


def test_platform_has_its_own_numbers():
    small, large = cffirmware.over("builtin", "cf2"), cffirmware.over("builtin", "cf21bl")
    assert small.powerDistributionGetMaxThrust() == pytest.approx(0.48)
    assert large.powerDistributionGetMaxThrust() == pytest.approx(0.8)
    assert (small.powerDistributionGetIdleThrust(), large.powerDistributionGetIdleThrust()) == (0, 7000)
    mellinger = large.controllerMellinger_t()
    large.controllerMellingerInit(mellinger)
    assert mellinger.mass == pytest.approx(0.0393)
    lee = large.controllerLee_t()
    large.controllerLeeInit(lee)
    assert lee.mass == pytest.approx(0.0393)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("bitkraze",), "no provider named 'bitkraze', allowed: builtin, bitcraze"),
        (("builtin", "cf3"), "no platform named 'cf3', allowed: cf2, cf21bl"),
    ],
)
def test_unknown_words_are_named(arguments, says):
    with pytest.raises(UnknownNameError, match=says):
        cffirmware.over(*arguments)


def test_missing_checkout_is_one_sentence(tmp_path):
    with pytest.raises(CheckoutError, match="there is no such folder"):
        cffirmware.over("bitcraze", checkout=tmp_path / "none")


def test_unknown_name_names_the_provider():
    with pytest.raises(AttributeError, match="over provider builtin has no attribute 'nothing'"):
        _ = cffirmware.nothing
    assert {"mkvec", "over", "provider", "selection"} <= set(dir(cffirmware))


def test_import_chooses_when_the_first_name_is_asked_for():
    code = "import crazychoir_fw.cffirmware as f; print('mkvec' in vars(f)); f.mkvec; print('vadd' in vars(f))"
    root = Path(__file__).resolve().parents[2]
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=True)
    assert ran.stdout.split() == ["False", "True"]
