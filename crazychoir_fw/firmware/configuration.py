"""The configuration header of a platform: what `make <platform>_defconfig` would have generated, as far as it is read.

Upstream's build makes build/include/generated/autoconf.h with kconfig, in the checkout. Ours is made without a write
into the checkout: what its own Kconfig files give for configs/<platform>_defconfig, and for symbols that those do not
know, or for a checkout without them, the stock configuration. Decks and the task of an app stay out: the
simulation brings the former, and apps are built one by one.
"""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import kconfiglib

from crazychoir_fw.common.errors import CheckoutError, UnknownNameError

FILE_NAME = "autoconf.h"
PLATFORM_PREFIX = "CONFIG_PLATFORM_"

# what Kconfig gives on every platform, where the defconfig is silent (docs/reference/upstream-shape.md#4)
_COMMON = {
    "CONFIG_CONTROLLER_AUTO_SELECT": "1",
    "CONFIG_ESTIMATOR_AUTO_SELECT": "1",
    "CONFIG_ESTIMATOR_KALMAN_ENABLE": "1",
    "CONFIG_ESTIMATOR_KALMAN_INITIAL_YAW_STD": "10",
    "CONFIG_ESTIMATOR_OUTLIER_FILTERS": "1",
    "CONFIG_IMU_MAHONY_QUATERNION": "1",
    # read as values, so that 0 must stand there
    "CONFIG_MOTORS_DEFAULT_BAT_TEST_PWM_RATIO": "0",
    "CONFIG_MOTORS_DEFAULT_PROP_TEST_PWM_RATIO": "0",
    # a fork's commander needs it to start the high-level commander; nothing else looks at it
    "CONFIG_ONBOARD_GUIDANCE_HIGHLEVEL_COMMANDER": "1",
    "CONFIG_POWER_DISTRIBUTION_QUADROTOR": "1",
}

# the same for each platform (docs/reference/upstream-build.md#3.3, docs/reference/control-pid.md#13 and #14)
_STOCK: dict[str, dict[str, str]] = {
    "cf2": {
        **_COMMON,
        "CONFIG_CRAZYFLIE_21_PLUS": "1",
        "CONFIG_ENABLE_THRUST_BAT_COMPENSATED": "1",
        "CONFIG_MOTORS_ESC_PROTOCOL_ONESHOT125": "1",
        "CONFIG_THRUST_BAT_COMPENSATION_TYPE": "1",
    },
    "cf21bl": {
        **_COMMON,
        "CONFIG_ENABLE_THRUST_BAT_COMPENSATED": "1",
        "CONFIG_MOTORS_DEFAULT_IDLE_THRUST": "7000",
        "CONFIG_MOTORS_ESC_PROTOCOL_DSHOT": "1",
        "CONFIG_MOTORS_REQUIRE_ARMING": "1",
        "CONFIG_THRUST_BAT_COMPENSATION_MAX_THRUST": "200",
    },
    # without a thrust curve, compensation would divide by zero
    "bolt": {
        **_COMMON,
        "CONFIG_MOTORS_ESC_PROTOCOL_ONESHOT125": "1",
        "CONFIG_MOTORS_REQUIRE_ARMING": "1",
    },
}
PLATFORMS = tuple(_STOCK)

# what a host build leaves out whatever Kconfig says: drivers, tasks, and motors that report how fast they turn
_LEFT_OUT = re.compile(
    r"CONFIG_(DECK_\w+|APP_ENABLE|MOTORS_ESC_PROTOCOL_DSHOT_BIDIRECTIONAL|ESTIMATOR_UKF\w*|DEBUG_PRINT_ON_\w+)"
)

# exclusive choices: one of them in the defconfig puts the stock choice aside
_CHOICES = (("CONFIG_CRAZYFLIE_21_PLUS", "CONFIG_CRAZYFLIE_THRUST_UPGRADE_KIT", "CONFIG_CRAZYFLIE_LEGACY_PROPELLERS"),)

_SETTING = re.compile(r"^(CONFIG_[A-Z0-9_]+)=(.*?)\s*$", re.MULTILINE)
_UNSET = re.compile(r"^# (CONFIG_[A-Z0-9_]+) is not set\s*$", re.MULTILINE)
_DEFINITION = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(CONFIG_[A-Z0-9_]+)[ \t]*(.*?)[ \t]*$", re.MULTILINE)
_MENTION = re.compile(r"\bCONFIG_[A-Z0-9_]+")
_VALUE = re.compile(r'-?(0x[0-9a-fA-F]+|[0-9]+)|"(\\.|[^"\\])*"')


def settings(root: Path, platform: str, extra: Iterable[str] = ()) -> dict[str, str]:
    """Return the symbols of a platform and their values as C text.

    Args:
        root: The checkout.
        platform: One of `PLATFORMS`.
        extra: Symbols to define as 1, e.g. ``CONFIG_CONTROLLER_OOT``.

    Raises:
        UnknownNameError: If there is no such platform.
        CheckoutError: If the checkout has no such platform.
    """
    if platform not in _STOCK:
        raise UnknownNameError(f"no platform named {platform!r}, allowed: {', '.join(PLATFORMS)}")
    _demand_platform(root, platform)
    defconfig = root / "configs" / f"{platform}_defconfig"
    given, known = read_kconfig(root, defconfig) or ({}, set())
    given = {name: value for name, value in given.items() if not _LEFT_OUT.fullmatch(name)}
    stock = {name: value for name, value in _STOCK[platform].items() if name not in known} | given
    own, silent = _read_defconfig(defconfig)
    # a defconfig names its own platform; that of another one would make two of them true
    chosen = {
        name: value
        for name, value in (stock | own).items()
        if name not in silent and not name.startswith(PLATFORM_PREFIX)
    }
    chosen[PLATFORM_PREFIX + platform.upper()] = "1"
    chosen.update(dict.fromkeys(extra, "1"))
    return dict(sorted(chosen.items()))


def _read_defconfig(path: Path) -> tuple[dict[str, str], set[str]]:
    """Return the symbols that a defconfig sets, as C text, and those that it switches off."""
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    written = _SETTING.findall(text)
    own = {name: value for name, word in written if (value := _c_value(word)) is not None}
    silent = set(_UNSET.findall(text)) | {name for name, word in written if word == "n"}
    for choice in _CHOICES:
        if own.keys() & set(choice):
            silent |= set(choice) - own.keys()
    return own, silent


def _c_value(written: str) -> str | None:
    """Return the value of a defconfig line as C text; None for `n` and for what is no value."""
    if written == "y":
        return "1"
    return written if _VALUE.fullmatch(written) else None


def _demand_platform(root: Path, platform: str) -> None:
    """Raise if the checkout has defaults for platforms, but not for this one."""
    folder = root / "src" / "platform" / "interface"
    present = sorted(path.stem.removeprefix("platform_defaults_") for path in folder.glob("platform_defaults_*.h"))
    if present and platform not in present:
        raise CheckoutError(f"the firmware in {root} has no platform {platform}; it has {', '.join(present)}")


def read_header(path: Path, platform: str, extra: Iterable[str] = ()) -> dict[str, str]:
    """Return the symbols of a configuration header that another build generated.

    Raises:
        CheckoutError: If it cannot be read, or is for another platform.
    """
    try:
        found = dict(_DEFINITION.findall(path.read_text(encoding="utf-8", errors="replace")))
    except OSError as error:
        raise CheckoutError(f"configuration header {path} cannot be read: {error.strerror}") from None
    if PLATFORM_PREFIX + platform.upper() not in found:
        known = {word.upper() for word in PLATFORMS} | {"TAG", "FLAPPER"}
        theirs = sorted(word.lower() for word in known if PLATFORM_PREFIX + word in found)
        raise CheckoutError(
            f"configuration header {path} is for platform {', '.join(theirs) or 'unknown'}, asked for is {platform}"
        )
    found.update(dict.fromkeys(extra, "1"))
    return dict(sorted(found.items()))


def header_text(chosen: Mapping[str, str]) -> str:
    """Return the text of autoconf.h."""
    lines = ["// Configuration of a host build; made by crazychoir, changes are lost.", "#pragma once", ""]
    return "\n".join([*lines, *(f"#define {name} {value}".rstrip() for name, value in chosen.items())]) + "\n"


def symbols_in(paths: Iterable[Path]) -> set[str]:
    """Return the configuration symbols that the text of these files mentions."""
    found: set[str] = set()
    for path in paths:
        found.update(_MENTION.findall(path.read_text(encoding="utf-8", errors="replace")))
    return found


TOP = "Kconfig"
PREFIX = "CONFIG_"

# kconfiglib takes its settings from the environment and from its own module
_lock = threading.Lock()


def read_kconfig(root: Path, defconfig: Path) -> tuple[dict[str, str], set[str]] | None:
    """Return what Kconfig gives, as the generated header would have it, and the names of all symbols that it knows.

    Args:
        root: The checkout; its Kconfig names files relative to it.
        defconfig: Choices of a platform; may be missing.

    Returns:
        Values as C text by symbol, e.g. ``{"CONFIG_PLATFORM_CF2": "1"}``, without those that are off; and all symbols.
        None without a Kconfig, or if it cannot be read.
    """
    if not (root / TOP).is_file():
        return None
    with _lock, _nothing_is_run(root):
        try:
            tree = kconfiglib.Kconfig(str(root / TOP), warn=False)
            if defconfig.is_file():
                tree.load_config(str(defconfig))
            symbols = {f"{PREFIX}{symbol.name}": symbol for symbol in tree.unique_defined_syms}
            values = {name: _value_of(symbol) for name, symbol in symbols.items()}
        except (kconfiglib.KconfigError, OSError, ValueError, RecursionError):
            return None
    return {name: value for name, value in values.items() if value is not None}, set(symbols)


def _value_of(symbol: kconfiglib.Symbol) -> str | None:
    """Return a symbol's value as C text, or None if it is off or has none."""
    value = symbol.str_value
    if symbol.orig_type in (kconfiglib.BOOL, kconfiglib.TRISTATE):
        return "1" if value == "y" else None
    if symbol.orig_type == kconfiglib.STRING:
        return f'"{kconfiglib.escape(value)}"' if symbol.config_string else None
    return value or None


@contextmanager
def _nothing_is_run(root: Path) -> Iterator[None]:
    """Let kconfiglib read files below a folder, and neither run a shell nor import functions."""
    environment = {"srctree": str(root), "KCONFIG_FUNCTIONS": "no.functions", "CONFIG_": PREFIX}
    before = {name: os.environ.get(name) for name in environment}
    shell = kconfiglib._shell_fn
    os.environ.update(environment)
    kconfiglib._shell_fn = lambda *_: ""
    try:
        yield
    finally:
        kconfiglib._shell_fn = shell
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
