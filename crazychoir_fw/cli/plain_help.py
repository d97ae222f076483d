"""Help that says what a value is, in place of its Python type."""

import sys
from types import ModuleType
from typing import Any

from typer.core import TyperGroup

_WORDS = {"<int": "N", "<float": "NUMBER", "<path": "PATH", "<list[path": "PATH", "<bool": ""}
"""What stands in place of a type, by how typer begins it; all else is `TEXT`."""


class PlainGroup(TyperGroup):
    """A group whose commands show `N`, `PATH` or a unit where typer shows `<int range>` or `<path>`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words of the command line, and prepare for help if they ask for it."""
        if not args or "--help" in args:
            _import_help()
        return super().parse_args(ctx, args)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command of the group, with words in place of types."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            _reword(command, ctx)
        return command

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters of the group itself, with words in place of types."""
        return _reworded(super().get_params(ctx), ctx)


def _import_help() -> None:
    """Import what draws help, without rich's reader of Markdown: a quarter of the time, for texts that are not here."""
    name = "rich.markdown"
    if name in sys.modules or "typer.rich_utils" in sys.modules:
        return
    stand_in = ModuleType(name)
    stand_in.Markdown = type("Markdown", (), {})  # type: ignore[attr-defined]
    sys.modules[name] = stand_in
    try:
        import typer.rich_utils  # noqa: F401
    finally:
        del sys.modules[name]


def _reword(command: Any, ctx: Any) -> None:
    """Put words in place of types in the help of a command, and of those below it."""
    _reworded(command.get_params(ctx), ctx)
    for below in getattr(command, "commands", {}).values():
        _reword(below, ctx)


def _reworded(params: list[Any], ctx: Any) -> list[Any]:
    for param in params:
        # typer before 0.29 shows no Python types
        if not hasattr(param, "display_type"):
            continue
        if param.param_type_name == "argument":
            param.display_type_rich = lambda ctx: None  # its name says what it is
        elif param.metavar is None:
            shown = (param.display_type(ctx) or "").lower()
            param.metavar = next((word for begin, word in _WORDS.items() if shown.startswith(begin)), "TEXT")
    return params
