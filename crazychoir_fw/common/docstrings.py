"""The texts below the attributes of a class, as its source has them."""

import ast
import functools
import inspect
import sys
from collections.abc import Iterator


def attribute_docstrings(kind: type) -> dict[str, str]:
    """Return name to text of the annotated attributes of a class and its bases, without line breaks."""
    texts: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        texts |= _texts_of_module(base.__module__).get(base.__qualname__, {})
    return texts


@functools.cache
def _texts_of_module(name: str) -> dict[str, dict[str, str]]:
    """Return the same for each class of a module without its bases, by qualified name; nothing if it has no source."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[name]))
    except (OSError, TypeError, KeyError):
        return {}
    return {path: _texts_of(definition) for path, definition in _classes(tree, "")}


def _classes(scope: ast.AST, prefix: str) -> Iterator[tuple[str, ast.ClassDef]]:
    for child in ast.iter_child_nodes(scope):
        if isinstance(child, ast.ClassDef):
            yield prefix + child.name, child
            yield from _classes(child, f"{prefix}{child.name}.")
        elif isinstance(child, ast.FunctionDef):
            yield from _classes(child, f"{prefix}{child.name}.<locals>.")


def _texts_of(definition: ast.ClassDef) -> dict[str, str]:
    texts = {}
    for statement, following in zip(definition.body, definition.body[1:], strict=False):
        if (
            isinstance(statement, ast.AnnAssign)
            and isinstance(statement.target, ast.Name)
            and isinstance(following, ast.Expr)
            and isinstance(following.value, ast.Constant)
            and isinstance(following.value.value, str)
        ):
            texts[statement.target.id] = " ".join(following.value.value.split())
    return texts
