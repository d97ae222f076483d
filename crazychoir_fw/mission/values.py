"""The kinds of values in a mission file: those of `common.constraints`, and kinds of files, providers and vehicles.

Whatever is refused ends as "… must be <must>", so that the reader of the message learns the allowed range without
opening the documentation.
"""

import os
import re
from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BeforeValidator, ValidationInfo
from pydantic_core import PydanticCustomError
from pydantic_core import core_schema as schemas

from crazychoir_fw.common.constraints import Constraint
from crazychoir_fw.common.errors import CrazychoirError, UnknownNameError
from crazychoir_fw.firmware.levels import BITCRAZE, level_of, word_for_modules
from crazychoir_fw.onboard.variables import parameter_table
from crazychoir_fw.onboard.vehicles import overrides, parameters

_LARGEST = float(np.finfo(np.float32).max)


def refusal(must: str, path: str = "", **below: object) -> PydanticCustomError:
    """Return the error that the loader words as "<path> is <value>, but must be <must>".

    Args:
        must: What is allowed, as it continues "must be".
        path: Keys below the place where the error is raised, such as ".takeoff".
        below: `value=` what stands there, if the place of the error holds more than it.
    """
    return PydanticCustomError("must_be", "must be {must}", {"must": must, "path": path, **below})


def objection(sentence: str, path: str = "") -> PydanticCustomError:
    """Return the error that the loader words as "<path>: <sentence>", for checks that word the whole sentence."""
    return PydanticCustomError("objection", "{sentence}", {"sentence": sentence, "path": path})


def unknown_key(key: object, known: Collection[str], path: str = "") -> PydanticCustomError:
    """Return the error about a *key* that its section does not know, `path` below where the error is raised."""
    hint = did_you_mean(key, known)
    return PydanticCustomError(
        "unknown_key",
        "unknown key",
        {"key": str(key)[:40].encode(errors="replace").decode(), "hint": hint, "known": sorted(known), "path": path},
    )


def did_you_mean(word: object, known: Collection[str]) -> str:
    """Return " (did you mean 'height'?)", or nothing when no known word is near."""
    near = get_close_matches(str(word)[:40], known, n=1)
    return f" (did you mean '{near[0]}'?)" if near else ""


def is_number(value: object, low: float, high: float) -> bool:
    """Tell whether *value* is a real number in [low, high]: no NaN, and no boolean."""
    return isinstance(value, Real) and not isinstance(value, bool) and low <= value <= high


def plain_properties() -> Constraint:
    """A mapping from words to texts or numbers."""
    keys = schemas.str_schema(pattern=r"\A\w[\w.-]*\Z", coerce_numbers_to_str=True, regex_engine="python-re")
    values = schemas.union_schema([schemas.str_schema(strict=True), schemas.float_schema()])
    must = "a mapping from words to texts or numbers, such as {height: 0.8}"
    return Constraint(schemas.dict_schema(keys, values), must)


def provider_word() -> BeforeValidator:
    """The name of a provider, or a mapping of `bitcraze` to the modules of a checkout that shall fly; as a word."""
    compiled = re.compile(r"[A-Za-z][\w.:+-]{0,62}")
    must = "the name of a provider, such as builtin, or {bitcraze: {modules: [commander, …]}}"

    def check(value: object) -> str:
        if isinstance(value, Mapping):
            return _word_for_modules(value, must)
        if not isinstance(value, str) or not compiled.fullmatch(value):
            raise refusal(must)
        try:
            level_of(value)
        except UnknownNameError as error:
            raise objection(str(error)) from None
        return value

    return BeforeValidator(check)


def _word_for_modules(value: Mapping[Any, Any], must: str) -> str:
    if list(value) != [BITCRAZE]:
        raise refusal(must)
    settings = value[BITCRAZE]
    if settings is None:
        return BITCRAZE
    if not isinstance(settings, Mapping) or list(settings) != ["modules"]:
        raise refusal(must)
    modules = settings["modules"]
    if not isinstance(modules, str | Sequence):
        raise refusal("a list of modules, or all", ".bitcraze.modules")
    try:
        return word_for_modules(modules)
    except UnknownNameError as error:
        raise objection(str(error), ".bitcraze.modules") from None


def source_files() -> BeforeValidator:
    """One C file or a list of them, seen from the folder of the mission file; an empty list is none."""
    must = "a C file such as my_controller.c, or a list of them"

    def check(value: object, info: ValidationInfo) -> tuple[str, ...]:
        names = [value] if isinstance(value, str | Path) else value
        if not isinstance(names, Sequence) or not all(isinstance(name, str | Path) for name in names):
            raise refusal(must)
        return tuple(str(existing_file(name, info, must, ".c")) for name in names)

    return BeforeValidator(check)


def folders_of(info: ValidationInfo) -> tuple[Path, ...]:
    """Return the folders that files are seen from: that of the mission file, then those of the missions it extends."""
    return (info.context or {}).get("folders", (Path(),))


def is_file(path: Path) -> bool:
    """Return whether there is such a file; there is none where no file can have its name."""
    return os.path.isfile(path)  # noqa: PTH113, where pathlib raises


def beside(name: str | Path, info: ValidationInfo) -> Path:
    """Return the path of a file that a mission names: in the first of its folders where it is, or in its own."""
    paths = [folder / name for folder in folders_of(info)]
    return next(filter(os.path.exists, paths), paths[0])


def existing_file(name: str | Path, info: ValidationInfo, must: str, suffix: str = "") -> Path:
    """Return a file seen from the folder of the mission file; without it, the value must be what `must` says."""
    path = beside(name, info)
    if not path.name.endswith(suffix) or not is_file(path):
        kind = f"{suffix} file".lstrip()
        raise refusal(f"{must}; {str(name)[:80]!r} is no existing {kind} in {folders_of(info)[0]}")
    return path


def motor_ctrl_name() -> BeforeValidator:
    """The class of a motor control; a file is seen from the folder of the mission file."""
    must = "the class of a motor control: package.module:Class, file.py:Class or a word such as MotorCtrlXYZ"

    def check(value: object, info: ValidationInfo) -> str:
        if not isinstance(value, str) or not re.fullmatch(r"(.*\.py:|[\w.]+:)?[^\W\d]\w*", value):
            raise refusal(must)
        file, colon, class_name = value.rpartition(":")
        if not (colon and file.endswith(".py")):
            return value
        return f"{existing_file(file, info, must).resolve()}:{class_name}"

    return BeforeValidator(check)


def parameter_values() -> BeforeValidator:
    """A mapping from names of onboard parameters to numbers that fit into them.

    Software that is loaded before the flight may bring parameters that are not known yet; they are checked then.
    """
    must = "a mapping from onboard parameters to numbers, such as {colAv.enable: 1}"

    def check(value: object, info: ValidationInfo) -> dict[str, float]:
        if not isinstance(value, Mapping):
            raise refusal(must)
        table = parameter_table()
        has_own_software = (info.context or {}).get("has_own_software", False)
        for name, amount in value.items():
            if name not in table:
                if has_own_software and is_number(amount, -_LARGEST, _LARGEST) and re.fullmatch(r"\w+\.\w+", str(name)):
                    continue
                raise refusal(must + did_you_mean(name, table))
            kind = table[name].dtype
            low, high = _range_of(kind)
            is_whole = kind.kind != "f"
            if not is_number(amount, low, high) or (is_whole and not float(amount).is_integer()):
                what = "a whole number" if is_whole else "a number"
                raise refusal(f"a mapping with {what} in [{low:g}, {high:g}] for {name}")
        return dict(value)

    return BeforeValidator(check)


def vehicle_parameters() -> BeforeValidator:
    """Parameters of the vehicle, the name of a YAML file with some, or a list of these; as a flat mapping."""

    def check(value: object, info: ValidationInfo) -> dict[str, Any]:
        try:
            return overrides(value, folders_of(info))  # type: ignore[arg-type]
        except CrazychoirError as error:
            raise objection(str(error).removeprefix("vehicle: ")) from error

    return BeforeValidator(check)


def wind_parameters() -> BeforeValidator:
    """The parameters `wind.*` of the vehicles, without their prefix; as a flat mapping with it."""
    of_vehicles = vehicle_parameters().func

    def check(value: object, info: ValidationInfo) -> dict[str, Any]:
        known = [name.removeprefix("wind.") for name in parameters() if name.startswith("wind.")]
        if not isinstance(value, Mapping):
            raise refusal(f"a mapping with some of {', '.join(known)}")
        for key in value:
            if key not in known:
                raise unknown_key(key, known)
        return of_vehicles({"wind": value} if value else {}, info)  # type: ignore[call-arg]

    return BeforeValidator(check)


def _range_of(kind: np.dtype) -> tuple[float, float]:
    limits = np.finfo(kind) if kind.kind == "f" else np.iinfo(kind)
    return float(limits.min), float(limits.max)
