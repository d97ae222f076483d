"""Python of the user's, named in a file: found, executed, and its errors told in one line."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError, MissingLibraryError, UnknownNameError

USER_ERRORS = (Exception, SystemExit)
"""What a user's code may raise; `sys.exit` in it ends no program."""


def anchored(name: str, folder: Path) -> str:
    """Return a name whose relative path of a file starts at a folder, so that it means the same from anywhere."""
    file, colon, class_name = name.rpartition(":")
    return f"{(folder / file).resolve()}:{class_name}" if colon and file.endswith(".py") else name


def installed(group: str, name: str, what: str) -> Any:
    """Return what an installed package offers as an entry point.

    Args:
        group: Of the entry point.
        name: Of the entry point.
        what: What it is, for messages.

    Raises:
        MissingLibraryError: If no package offers it, or what it needs is not installed.
    """
    for entry in entry_points(group=group, name=name):
        try:
            return entry.load()
        except MissingLibraryError:
            raise
        except ImportError as error:
            raise MissingLibraryError(f"{what} ({entry.value}) cannot be loaded: {error}") from None
    raise MissingLibraryError(f"no installed package offers {what} (entry point {name} of group {group})")


def load_module(name: str, what: str) -> ModuleType:
    """Return the module of a name, ``package.module`` or ``path/to/file.py``. It is executed.

    Args:
        name: The module; a file is executed again each time, so that what was saved runs.
        what: The caller, for messages.

    Raises:
        UnknownNameError: If there is no such module or file.
        CrazychoirError: If the module raises while it is imported; the message has the exception and the line.
    """
    return _load_file(Path(name), what) if name.endswith(".py") else _import(name, what)


def _import(module_name: str, what: str) -> ModuleType:
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is not None and (module_name == error.name or module_name.startswith(f"{error.name}.")):
            raise UnknownNameError(
                f"{what}: there is no module {error.name}; install its package, or name the file as path/to/file.py"
            ) from None
        raise CrazychoirError(f"{what}: cannot be imported: {describe(error)}") from error
    except USER_ERRORS as error:  # whatever a module may do while it is imported
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
        with _neighbors_importable(path.parent):
            spec.loader.exec_module(module)
    except USER_ERRORS as error:  # whatever a module may do while it is imported
        sys.modules.pop(name, None)
        raise CrazychoirError(f"{what}: cannot be imported: {describe(error)}") from error
    return module


@contextmanager
def _neighbors_importable(folder: Path) -> Iterator[None]:
    """Let a file import the modules beside it, whatever modules of these names other folders have.

    What it imports from there is executed again for the next file, so that what was saved runs.
    """
    found = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/__init__.py")}
    names = found - sys.stdlib_module_names

    def taken_out() -> dict[str, ModuleType]:
        return {name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] in names}

    others = taken_out()
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        taken_out()
        sys.modules.update(others)


def describe(error: BaseException) -> str:
    """Return an exception in one line, with the file and line of the user's code that it comes from."""
    own = Path(__file__).parents[1]
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
