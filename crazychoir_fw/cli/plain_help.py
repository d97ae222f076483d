"""Help that says what a value is, in place of its Python type."""

from typing import Any

from typer.core import TyperGroup

_WORDS = {"<int": "N", "<float": "NUMBER", "<path": "PATH", "<list[path": "PATH", "<bool": ""}
"""What stands in place of a type, by how typer begins it; all else is `TEXT`."""


class PlainGroup(TyperGroup):
    """A group whose commands show `N`, `PATH` or a unit where typer shows `<int range>` or `<path>`."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command of the group, with words in place of types."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            _reword(command, ctx)
        return command

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the parameters of the group itself, with words in place of types."""
        return _reworded(super().get_params(ctx), ctx)


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
