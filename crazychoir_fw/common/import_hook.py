"""Prepare a package at its first import, without importing it now."""

import importlib.abc
import importlib.util
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from importlib.machinery import ModuleSpec
from types import ModuleType


def at_import(name: str, around: Callable[[], AbstractContextManager[None]], after: Callable[[], None]) -> None:
    """Run code around and after the first import of a package; at once if it is imported already.

    Args:
        name: Name of the package, without a dot.
        around: Makes the context in which the package is executed.
        after: Called when the package is complete.
    """
    if name in sys.modules:
        after()
    else:
        sys.meta_path.insert(0, _Finder(name, around, after))


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, name: str, around: Callable[[], AbstractContextManager[None]], after: Callable[[], None]):
        self._name = name
        self._around = around
        self._after = after
        self._is_asking = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self._name or self._is_asking:
            return None
        self._is_asking = True  # finders of others, such as those that count lines, ask all finders as well
        try:
            spec = self._spec_of_others(fullname, path, target)
        finally:
            self._is_asking = False
        if spec is not None and spec.loader is not None:
            spec.loader = _Loader(spec.loader, self)
        return spec

    def _spec_of_others(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None
    ) -> ModuleSpec | None:
        for finder in sys.meta_path:
            if finder is not self and (spec := finder.find_spec(fullname, path, target)) is not None:
                return spec
        return None

    def execute(self, loader: importlib.abc.Loader, module: ModuleType) -> None:
        with self._around():
            loader.exec_module(module)
        if self in sys.meta_path:
            sys.meta_path.remove(self)
        self._after()


class _Loader(importlib.abc.Loader):
    """Loads by the package's own loader, which takes its place before the package is executed."""

    def __init__(self, loader: importlib.abc.Loader, finder: _Finder):
        self._loader = loader
        self._finder = finder

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._finder.execute(self._loader, module)
