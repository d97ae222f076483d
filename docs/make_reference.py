"""Write docs/cli.md and docs/mission_keys.md: every command and every key of a mission, as the sources have them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from crazychoir_fw.cli import app
from crazychoir_fw.mission.json_schema import mission_schema

DOCS = Path(__file__).parent
NOTE = "<!-- written by docs/make_reference.py; a test compares -->\n"


def cell(text: Any) -> str:
    """Return a text as a cell of a table."""
    parts = " ".join(str(text).split()).replace("|", "&#124;").replace("``", "`").split("`")
    # code shows its characters as they are
    parts[0::2] = [part.replace("<", "&lt;") for part in parts[0::2]]
    return "`".join(parts)


def commands(command: Any, words: list[str]) -> Iterator[tuple[list[str], Any]]:
    """Yield all commands below one, with the words that call them."""
    below = getattr(command, "commands", None)
    if below is None:
        yield words, command
    for name in sorted(below or {}):
        yield from commands(below[name], [*words, name])


def cli_page() -> str:
    """Return the page of all commands."""
    lines = ["# Commands", "", NOTE, "`crazychoir COMMAND --help` says the same in a terminal."]
    for words, command in commands(typer.main.get_command(app), ["crazychoir"]):
        arguments = [p for p in command.params if p.param_type_name == "argument"]
        options = [p for p in command.params if p.param_type_name == "option" and p.name != "help"]
        usage = " ".join([*words, *(p.metavar or p.name.upper() for p in arguments)])
        lines += ["", f"## {' '.join(words[1:])}", "", f"`{usage}`", "", (command.help or "").strip()]
        if arguments or options:
            lines += ["", "| option | meaning | default |", "|---|---|---|"]
        for p in arguments:
            lines.append(f"| `{p.metavar or p.name.upper()}` | {cell(getattr(p, 'help', '') or '')} | |")
        for p in options:
            names = " / ".join(f"`{name}`" for name in [*p.opts, *p.secondary_opts])
            default = "" if p.default in (None, False, ()) or callable(p.default) else f"`{cell(p.default)}`"
            lines.append(f"| {names} | {cell(p.help or '')} | {default} |")
    return "\n".join(lines) + "\n"


def kind_of(entry: dict[str, Any]) -> str:
    """Return the type of a value in words."""
    if "$ref" in entry:
        name = entry["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "enum" in entry:
        return "one of " + ", ".join(f"`{word}`" for word in entry["enum"])
    if "const" in entry:
        return f"`{entry['const']}`"
    if "anyOf" in entry:
        kinds = [kind_of(part) for part in entry["anyOf"] if part.get("type") != "null"]
        return " or ".join(dict.fromkeys(filter(None, kinds)))
    if entry.get("type") == "array":
        inner = kind_of(entry["items"]) if isinstance(entry.get("items"), dict) else ""
        return "list" + (f" of {inner}" if inner else "")
    words = {"object": "mapping", "integer": "whole number", "boolean": "true or false", "string": "text"}
    kind = entry.get("type", "")
    kind = next((name for name in kind if name != "null"), "") if isinstance(kind, list) else kind
    return words.get(kind, kind)


def section(name: str, made: dict[str, Any]) -> list[str]:
    """Return the lines about one section of a mission."""
    lines = ["", f"## {name}"]
    if "anyOf" in made:
        made = made["anyOf"][1]
        lines += ["", "One of these keys."]
    lines += ["", made.get("description", "").strip().replace("``", "`"), ""]
    lines += ["| key | meaning and range | type | default |", "|---|---|---|---|"]
    needed = made.get("required", [])
    for key, entry in made["properties"].items():
        default = entry.get("default")
        shown = "needed" if key in needed else "" if default in (None, {}, []) else f"`{cell(default)}`"
        shown = "" if isinstance(default, dict) else '`""`' if default == "" else shown
        lines.append(f"| `{key}` | {cell(entry.get('description', ''))} | {kind_of(entry)} | {shown} |")
    return lines


def mission_page() -> str:
    """Return the page of all keys of a mission."""
    made = mission_schema()["$defs"]
    lines = ["# Every key of a mission", "", NOTE]
    lines += [
        "The same as a JSON Schema, for completion, hover and checks while you type in VS Code and other editors:",
        "`crazychoir schema > mission.schema.json`, and as first line of a mission",
        "`# yaml-language-server: $schema=mission.schema.json`.",
        "[Missions](missions.md) and [experiments](experiments.md) say how the keys work together.",
    ]
    for name in ["Mission", "LayeredMission", *sorted(made.keys() - {"Mission", "LayeredMission", "Variant"})]:
        lines += section(name, made[name]) if "properties" in made[name] or "anyOf" in made[name] else []
    faults = made["FaultEntry"]["anyOf"][1]["properties"]
    for name, fault in faults.items():
        lines += section(f"fault {name}", fault)
    return "\n".join(lines) + "\n"


PAGES = {"cli.md": cli_page, "mission_keys.md": mission_page}

if __name__ == "__main__":
    for file, make in PAGES.items():
        (DOCS / file).write_text(make())
