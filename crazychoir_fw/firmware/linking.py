"""Objects to a shared library that needs libc and libm only."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from crazychoir_fw.common.errors import LinkError
from crazychoir_fw.firmware.toolchain import Compiler, run

_FLAGS = ("-shared", "-Wl,-Bsymbolic", "-Wl,-z,noexecstack", "-Wl,--build-id=none")
_COMPLETE = "-Wl,--no-undefined"

# bfd and gold; lld; mold
_UNDEFINED = re.compile(r"undefined (?:reference to [`'\"]|(?:hidden )?symbol: )([A-Za-z_]\w*)")


@dataclass(frozen=True)
class Undefined:
    """A symbol without a definition."""

    name: str
    needed_by: tuple[Path, ...]
    """Sources of the objects that use it."""


def link(
    compiler: Compiler,
    objects: Mapping[Path, Path],
    library: Path,
    *,
    words: Sequence[str] = (),
    is_completed_later: bool = False,
) -> list[Undefined]:
    """Link objects to a library. Returns the undefined symbols, which is no library, or an empty list.

    Args:
        compiler: The C compiler, which knows its linker.
        objects: Object to source.
        library: File to write.
        words: More words for the command line.
        is_completed_later: Whether symbols may stay undefined, to be defined by the loading process.

    Raises:
        LinkError: If the linker fails for other reasons; the text is what it printed.
    """
    flags = _FLAGS if is_completed_later else (*_FLAGS, _COMPLETE)
    command = [*compiler.command, *flags, *words, "-o", str(library), *map(str, objects), "-lm"]
    ran = run(command)
    if ran.returncode == 0:
        return []
    names = sorted(set(_UNDEFINED.findall(ran.stderr)))
    if not names or is_completed_later:
        raise LinkError(f"the objects do not link:\n{_with_sources(ran.stderr, objects).rstrip()}")
    return [Undefined(name, _needing(name, objects)) for name in names]


def explain(undefined: Sequence[Undefined]) -> str:
    """Return one line per undefined symbol, with the sources that need it."""
    lines = []
    for symbol in undefined:
        sources = ", ".join(map(str, symbol.needed_by)) or "an unknown file"
        lines.append(f"undefined symbol {symbol.name}, needed by {sources}")
    return "\n".join(lines)


def needs_of(undefined: Sequence[Undefined]) -> dict[Path, list[str]]:
    """Return the undefined symbols that each source uses."""
    needs: dict[Path, list[str]] = {}
    for symbol in undefined:
        for path in symbol.needed_by:
            needs.setdefault(path, []).append(symbol.name)
    return needs


def undefined_symbols(path: Path) -> set[str]:
    """Return the names that an object uses and does not define."""
    from elftools.elf.elffile import ELFFile

    with path.open("rb") as file:
        table = ELFFile(file).get_section_by_name(".symtab")
        if table is None:
            return set()
        return {symbol.name for symbol in table.iter_symbols() if symbol["st_shndx"] == "SHN_UNDEF" and symbol.name}


def _needing(name: str, objects: Mapping[Path, Path]) -> tuple[Path, ...]:
    return tuple(source for path, source in objects.items() if name in undefined_symbols(path))


def _with_sources(text: str, objects: Mapping[Path, Path]) -> str:
    """Return what the linker printed, with names of sources for those of kept objects."""
    for path, source in objects.items():
        text = text.replace(str(path), str(source))
    return text
