"""Parameters of a drone, written and confirmed."""

from __future__ import annotations

import difflib
import threading
from collections.abc import Mapping
from typing import Any

from cflib.crazyflie import Crazyflie
from cflib.crazyflie.param import ParamTocElement

from crazychoir_fw.common.errors import RadioError, RangeError, UnknownNameError

ParameterValue = float | int | bool


def set_parameters(
    cf: Crazyflie, who: str, values: Mapping[str, ParameterValue], timeout_s: float, *, optional: bool = False
) -> None:
    """Write parameters in their order, and wait until the drone has confirmed each.

    Not from a callback of cflib, which would wait for itself.

    Args:
        cf: A drone whose parameters are known (`fully_connected`).
        who: Name and URI, for errors.
        values: Values by ``group.name``.
        timeout_s: How long one may take (s).
        optional: Whether those that this firmware does not have are left out.

    Raises:
        UnknownNameError: If the drone has no such parameter.
        RangeError: If it cannot be written, or the value does not fit its type.
        RadioError: If the drone does not confirm.
    """
    for name, value in values.items():
        element = element_of(cf.param.toc, name)
        if element is None:
            if optional:
                continue
            raise UnknownNameError(f"{who}: there is no parameter '{name}'{suggestion(name, cf.param.toc)}")
        if element.access == ParamTocElement.RO_ACCESS:
            raise RangeError(f"{who}: parameter '{name}' can only be read")
        _set(cf, who, name, _fitting(who, name, element, value), timeout_s)


def get_parameter(cf: Crazyflie, who: str, name: str) -> float | int:
    """Return the value of a parameter, as cflib last received it.

    Raises:
        UnknownNameError: If the drone has no such parameter.
    """
    element = element_of(cf.param.toc, name)
    if element is None:
        raise UnknownNameError(f"{who}: there is no parameter '{name}'{suggestion(name, cf.param.toc)}")
    text = cf.param.get_value(name)
    return float(text) if element.ctype in ("float", "FP16", "double") else int(text)


def element_of(toc: Any, name: str) -> Any:
    """Return the element ``group.name`` of one of cflib's tables of contents, or None."""
    # its own way by the complete name logs a warning for what is not there
    group, dot, item = name.partition(".")
    return toc.get_element(group, item) if dot else None


def suggestion(name: str, toc: Any) -> str:
    """Return the names in a table of contents that are nearest to one that is not, as the end of a sentence."""
    names = [f"{group}.{item}" for group, items in toc.toc.items() for item in items]
    near = difflib.get_close_matches(name, names, n=3)
    return f"; do you mean {' or '.join(near)}?" if near else f" among {len(names)}"


_WHOLE = {"uint8_t": (0, 8), "uint16_t": (0, 16), "uint32_t": (0, 32), "uint64_t": (0, 64)}
_WHOLE |= {"int8_t": (1, 8), "int16_t": (1, 16), "int32_t": (1, 32), "int64_t": (1, 64)}


def _fitting(who: str, name: str, element: ParamTocElement, value: ParameterValue) -> float | int:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if element.ctype not in _WHOLE:
        if number != number or abs(number) == float("inf"):
            raise RangeError(f"{who}: parameter '{name}' is {value!r}, allowed: a finite number")
        return number
    signed, bits = _WHOLE[element.ctype]
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else (0, 2**bits - 1)
    if not (low <= number <= high and number == int(number)):
        raise RangeError(f"{who}: parameter '{name}' is {value!r}, allowed: a whole number in [{low}, {high}]")
    return int(value)


def _set(cf: Crazyflie, who: str, name: str, value: float | int, timeout_s: float) -> None:
    group, item = name.split(".")
    confirmed = threading.Event()

    def heard(_name: str, _text: str) -> None:
        confirmed.set()

    cf.param.add_update_callback(group, item, heard)
    try:
        cf.param.set_value(name, value)
        if not confirmed.wait(timeout_s):
            raise RadioError(f"{who}: parameter '{name}' was not confirmed within {timeout_s:g} s")
    finally:
        cf.param.remove_update_callback(group, item, heard)
