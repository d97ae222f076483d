"""What the tests of single sensors begin with: dice, and a config with some of its numbers changed."""

from __future__ import annotations

from typing import Any

from crazychoir_fw._core import ffi, lib


def dice(seed: int = 1) -> Any:
    """Return a `cf_random_t *`."""
    random = ffi.new("cf_random_t *")
    lib.cf_random_init(random, seed, 0)
    return random


def mishap(**numbers: float) -> dict[str, float]:
    """Return the members of a `cf_mishap_config_t` with which nothing goes wrong but for these."""
    return {"dropout": 0.0, "outlier": 0.0, "outlier_size": 0.0, **numbers}


def changed(config: Any, changes: dict[str, Any]) -> Any:
    """Set members of a config; of a mishap those that are named, the others to 0. Returns a pointer to it."""
    for name, value in changes.items():
        setattr(config, name, mishap(**value) if name == "mishap" else value)
    return ffi.addressof(config)
