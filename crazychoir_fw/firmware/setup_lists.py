"""The lists of a checkout's bindings/setup.py: read as text, never executed.

Upstream writes sources, include folders and flags as lists of literals, and hands them to `Extension(...)`. A small
evaluator understands these literals and the few other forms that releases since 2019 have used; whatever else stands
there is left out, with a note.
"""

from __future__ import annotations

import ast
import posixpath
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crazychoir_fw.firmware import fallback_lists

_MAX_STEPS = 100_000
_MAX_LENGTH = 10_000

WRAPPER = "cffirmware_wrap"
"""Part of the name of the file that SWIG makes; it is never ours to compile."""


@dataclass(frozen=True)
class SetupLists:
    """What bindings/setup.py hands to the compiler."""

    sources: tuple[str, ...]
    """C files, relative to the checkout as a rule."""
    include_dirs: tuple[str, ...]
    flags: tuple[str, ...]
    """Compiler flags, definitions included."""
    notes: tuple[str, ...] = ()
    """What was left out or taken from elsewhere, in words."""


class _UnreadableError(Exception):
    """The file as a whole is not what upstream writes."""


class _Unknown:
    """The value of an expression that is not evaluated."""


_UNKNOWN = _Unknown()


def read_setup_lists(path: Path) -> SetupLists:
    """Return the lists of a setup.py; where there are none to be read, those of the newest known release."""
    try:
        return parse_setup_lists(path.read_text(encoding="utf-8"))
    except (_UnreadableError, OSError, UnicodeDecodeError) as reason:
        return _known_lists(f"{path}: {reason}; the lists of the newest known release are used")


def parse_setup_lists(text: str) -> SetupLists:
    """Return the lists that the text of a setup.py hands to `Extension(...)`."""
    try:
        return _Reader().read(ast.parse(text))
    except (SyntaxError, ValueError) as error:
        raise _UnreadableError(f"not Python ({error})") from None
    except (RecursionError, MemoryError):
        raise _UnreadableError("nested too deep") from None


def _known_lists(note: str) -> SetupLists:
    return SetupLists(fallback_lists.SOURCES, fallback_lists.INCLUDE_DIRS, fallback_lists.FLAGS, (note,))


class _Reader:
    """Evaluates top-level assignments, then the call of Extension."""

    def __init__(self) -> None:
        self.names: dict[str, Any] = {}
        self.notes: list[str] = []
        self.steps = 0

    def read(self, module: ast.Module) -> SetupLists:
        for statement in module.body:
            self._assign(statement)
        call = next((node for node in ast.walk(module) if _is_extension(node)), None)
        if call is None:
            raise _UnreadableError("it calls no Extension(...)")
        values = self._arguments(call)
        sources = self._strings(values, "sources")
        kept = [name for name in sources if WRAPPER not in posixpath.basename(name) and name.endswith(".c")]
        self._note_dropped(sources, kept)
        if not kept:
            raise _UnreadableError("the sources of Extension(...) are not a list of names")
        flags = [*self._strings(values, "extra_compile_args"), *self._definitions(values)]
        for ignored in ("extra_link_args", "extra_objects", "libraries"):
            if left := [name for name in self._strings(values, ignored) if name not in ("m", "-lm")]:
                self.notes.append(f"{ignored} {' '.join(left)} left out")
        return SetupLists(tuple(kept), tuple(self._strings(values, "include_dirs")), tuple(flags), tuple(self.notes))

    def _assign(self, statement: ast.stmt) -> None:
        if isinstance(statement, ast.Assign):
            targets, value = statement.targets, self._evaluate(statement.value)
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets, value = [statement.target], self._evaluate(statement.value)
        elif isinstance(statement, ast.AugAssign) and isinstance(statement.target, ast.Name):
            whole = ast.BinOp(ast.Name(statement.target.id), statement.op, statement.value)
            targets, value = [statement.target], self._evaluate(ast.copy_location(whole, statement))
        else:
            return
        for target in targets:
            if isinstance(target, ast.Name):
                self.names[target.id] = value

    def _arguments(self, call: ast.Call) -> dict[str, Any]:
        positional = zip(("name", "sources"), call.args, strict=False)
        values = {name: self._evaluate(value) for name, value in positional}
        return values | {word.arg: self._evaluate(word.value) for word in call.keywords if word.arg}

    def _strings(self, values: dict[str, Any], key: str) -> list[str]:
        value = values.get(key, [])
        if not isinstance(value, list | tuple):
            return []
        return [item for item in value if isinstance(item, str)]

    def _definitions(self, values: dict[str, Any]) -> list[str]:
        """Return define_macros, pairs of name and value or None, as flags."""
        flags = []
        pairs = values.get("define_macros", [])
        for pair in pairs if isinstance(pairs, list | tuple) else []:
            match pair:
                case (str(name), None):
                    flags.append(f"-D{name}")
                case (str(name), str(value)):
                    flags.append(f"-D{name}={value}")
        return flags

    def _note_dropped(self, sources: Sequence[str], kept: Sequence[str]) -> None:
        for name in sources:
            if name not in kept and WRAPPER not in posixpath.basename(name):
                self.notes.append(f"source {name} is not C, left out")

    def _evaluate(self, node: ast.expr) -> Any:
        self.steps += 1
        if self.steps > _MAX_STEPS:
            raise _UnreadableError("too much to evaluate")
        value = self._evaluate_form(node)
        if isinstance(value, str | list | tuple) and len(value) > _MAX_LENGTH:
            raise _UnreadableError(f"line {node.lineno} is longer than {_MAX_LENGTH}")
        return value

    def _evaluate_form(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=str() | int() | float() | None as value):
                return value
            case ast.List(elts=elements):
                return self._elements(elements)
            case ast.Tuple(elts=elements):
                return tuple(self._elements(elements))
            case ast.Name(id=name):
                return self.names.get(name, _UNKNOWN)
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                return self._sum(node, self._evaluate(left), self._evaluate(right))
            case ast.Call(func=function, args=arguments, keywords=[]) if _is_path_join(function):
                return _joined([self._evaluate(argument) for argument in arguments])
            case ast.ListComp(elt=element, generators=[ast.comprehension(target=ast.Name(id=name), ifs=[]) as loop]):
                return self._comprehension(element, name, loop.iter)
        return _UNKNOWN

    def _elements(self, elements: Sequence[ast.expr]) -> list[Any]:
        return [value for element in elements if not self._is_unknown(value := self._evaluate(element), element)]

    def _is_unknown(self, value: Any, node: ast.expr) -> bool:
        if value is not _UNKNOWN:
            return False
        self.notes.append(f"line {node.lineno} has something that is not a literal, left out")
        return True

    def _sum(self, node: ast.expr, left: Any, right: Any) -> Any:
        """Return the sum of two strings or lists; of a list and something unknown, the list."""
        for known, other in ((left, right), (right, left)):
            if isinstance(known, list) and other is _UNKNOWN:
                self._is_unknown(other, node)
                return list(known)
        for kind in (str, list, tuple):
            if isinstance(left, kind) and isinstance(right, kind):
                return left + right
        return _UNKNOWN

    def _comprehension(self, element: ast.expr, name: str, iterable: ast.expr) -> Any:
        items = self._evaluate(iterable)
        if not isinstance(items, list | tuple):
            return _UNKNOWN
        missing = object()
        before = self.names.get(name, missing)
        values = []
        for item in items:
            self.names[name] = item
            if not self._is_unknown(value := self._evaluate(element), element):
                values.append(value)
        if before is missing:
            self.names.pop(name, None)
        else:
            self.names[name] = before
        return values


def _is_extension(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    function = node.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    return name.endswith("Extension") and bool(node.args or node.keywords)


def _is_path_join(function: ast.expr) -> bool:
    return isinstance(function, ast.Attribute) and ast.unparse(function) in ("os.path.join", "path.join")


def _joined(parts: Sequence[Any]) -> Any:
    if not parts or not all(isinstance(part, str) for part in parts):
        return _UNKNOWN
    return posixpath.join(*parts)
