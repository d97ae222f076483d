"""From what a file says of a motor control to its class, and to its properties."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import shlex
import sys
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType

from crazychoir_fw.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_fpqr import MotorCtrlFPQR
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_frpy import MotorCtrlFRPY
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_vel import MotorCtrlVel
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl_xyz import MotorCtrlXYZ

STOCK = {cls.__name__: cls for cls in (MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel, MotorCtrlXYZ)}
"""Classes that are known by their plain names."""

FORMS = "package.module:Class, path/to/file.py:Class or one of " + ", ".join(STOCK)


def anchored(name: str, folder: Path) -> str:
    """Return a name whose relative path of a file starts at a folder, so that it means the same from anywhere."""
    file, colon, class_name = name.rpartition(":")
    return f"{(folder / file).resolve()}:{class_name}" if colon and file.endswith(".py") else name


def find_class(name: str, who: str) -> type[MotorCtrl]:
    """Return the class that a name means. A module or a file that it names is executed.

    Args:
        name: ``MotorCtrlFPQR`` and its like, ``package.module:Class``, or ``path/to/file.py:Class``.
        who: The drone, for messages.

    Raises:
        UnknownNameError: If there is no such module, file or class.
        RangeError: If the class is no `MotorCtrl`.
        CrazychoirError: If the module raises while it is imported; the message has the exception and the line.
    """
    module_name, colon, class_name = name.rpartition(":")
    if not colon:
        if name not in STOCK:
            near = get_close_matches(name, STOCK, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise UnknownNameError(f"{who}: motor_ctrl is '{name}'{hint}, allowed: {FORMS}")
        return STOCK[name]
    what = f"{who}: motor_ctrl '{name}'"
    module = _load_file(Path(module_name), what) if module_name.endswith(".py") else _import(module_name, what)
    found = getattr(module, class_name, None)
    if found is None:
        own = [value.__name__ for value in vars(module).values() if _is_own(value, module)]
        raise UnknownNameError(f"{what}: there is no such class, only {', '.join(own) or 'no motor control at all'}")
    return checked_class(found, what)


def _is_own(value: object, module: ModuleType) -> bool:
    return isinstance(value, type) and issubclass(value, MotorCtrl) and value.__module__ == module.__name__


def checked_class(found: object, what: str) -> type[MotorCtrl]:
    """Return a class that is a `MotorCtrl`.

    Raises:
        RangeError: If it is none.
    """
    if not (isinstance(found, type) and issubclass(found, MotorCtrl)):
        raise RangeError(f"{what}: {found!r} is no motor control, allowed: a subclass of MotorCtrl")
    return found


def class_name(cls: type[MotorCtrl]) -> str:
    """Return the name by which `find_class` finds a class again, as far as its module can be imported."""
    return cls.__name__ if STOCK.get(cls.__name__) is cls else f"{cls.__module__}:{cls.__qualname__}"


def _import(module_name: str, what: str) -> ModuleType:
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is not None and (module_name == error.name or module_name.startswith(f"{error.name}.")):
            raise UnknownNameError(
                f"{what}: there is no module {error.name}; install its package, or name the file as path/to/file.py"
            ) from None
        raise CrazychoirError(f"{what}: cannot be imported: {describe(error)}") from error
    except Exception as error:  # whatever a module may do while it is imported
        raise CrazychoirError(f"{what}: cannot be imported: {describe(error)}") from error


def _load_file(path: Path, what: str) -> ModuleType:
    """Execute a file as a module of its own, again for every world, so that what was saved flies."""
    path = path.resolve()
    if not path.is_file():
        raise UnknownNameError(f"{what}: there is no file {path}")
    name = f"{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise UnknownNameError(f"{what}: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickles look their module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever a module may do while it is imported
        sys.modules.pop(name, None)
        raise CrazychoirError(f"{what}: cannot be imported: {describe(error)}") from error
    return module


def describe(error: BaseException) -> str:
    """Return an exception in one line, with the file and line of the user's code that it comes from."""
    own = Path(__file__).parents[2]
    place = ""
    trace = error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        if own not in file.parents and "importlib" not in file.name:
            place = f" ({file.name}:{trace.tb_lineno})"
        trace = trace.tb_next
    if isinstance(error, SyntaxError) and error.filename:
        place = f" ({Path(error.filename).name}:{error.lineno})"
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text[:110]}{place}" if text else f"{type(error).__name__}{place}"


def require_class(who: str, motor_ctrl: object, properties: Mapping[str, object]) -> None:
    """Refuse properties that nobody would be told.

    Raises:
        RangeError: If there are properties, but no class.
    """
    if motor_ctrl is None and properties:
        words = ", ".join(str(word) for word in properties)[:60]
        raise RangeError(f"{who}: motor_ctrl_properties ({words}) are for a motor control, but motor_ctrl names none")


def parse_properties(text: str, who: str) -> dict[str, str]:
    """Return the properties of words ``key=value``; a value with spaces stands in quotes.

    Raises:
        RangeError: If a word is of another form.
    """
    try:
        words = shlex.split(text)
    except ValueError:
        words = [text]
    pairs = [word.partition("=") for word in words]
    for (key, equals, _), word in zip(pairs, words, strict=True):
        if not (equals and key):
            raise RangeError(f"{who}: motor_ctrl_properties has the word '{word[:60]}', allowed: key=value")
    return {key: value for key, _, value in pairs}


def properties_text(properties: Mapping[str, object]) -> str:
    """Return properties as the text that `parse_properties` reads."""
    return " ".join(shlex.quote(f"{key}={value}") for key, value in properties.items())
