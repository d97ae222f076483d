"""Sources to objects: in parallel, and only those whose text, headers, flags or compiler changed.

What was compiled of one checkout serves each other one with the same text: a clone, a worktree, a folder that moved.
"""

from __future__ import annotations

import os
import re
import secrets
import shlex
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from crazychoir_fw.common.errors import CompileError
from crazychoir_fw.firmware.cache import Cache, Fingerprints, digest, digest_of, used
from crazychoir_fw.firmware.toolchain import Compiler, run

_ROOT = "\0"  # stands for the folder of the checkout; no path and no compiler has it


@dataclass(frozen=True)
class Unit:
    """One source and how it is compiled."""

    source: Path
    flags: tuple[str, ...]
    syntax_only: bool = False
    """Only ask whether it compiles."""
    placed: bool = False
    """Whether the debug information must name this very file, and not one with the same text."""


@dataclass(frozen=True)
class Compiled:
    """What became of a unit."""

    unit: Unit
    ok: bool
    output: str
    """What the compiler printed."""
    inputs: dict[str, str | None] = field(repr=False)
    """Digests of all files that were read, by absolute path."""
    path: Path | None = None
    """The object; None if it failed or only syntax was checked."""
    from_cache: bool = False


class Objects:
    """Compiles units into a cache."""

    def __init__(
        self,
        compiler: Compiler,
        cache: Cache,
        fingerprints: Fingerprints,
        headers: Sequence[str],
        root: Path | None = None,
        recall: bool = True,
    ) -> None:
        """Make a compiler of units.

        Args:
            compiler: The C compiler.
            cache: Where objects are kept.
            fingerprints: Digests of files, shared by one build.
            headers: Names of all headers in include folders: a new one may hide another one.
            root: Folder of the checkout, whose place does not count.
            recall: Whether what was compiled before is used.
        """
        self._compiler = compiler
        self._cache = cache
        self._fingerprints = fingerprints
        self._root = None if root is None else str(root)
        self._scenery = digest_of([self._anywhere(name) for name in headers])
        # where files are is no part of what is compiled: assertions name them from the root on
        self._naming = () if root is None else (f"-fmacro-prefix-map={root}/=",)
        self._may_recall = recall
        self.commands: list[str] = []
        """Command lines that were run, for the build log."""

    def compile_all(self, units: Sequence[Unit], done: Callable[[Compiled], None] | None = None) -> list[Compiled]:
        """Compile units, as many at once as there are processors. Failures are in the results.

        Args:
            units: What to compile.
            done: Told of each result, in the order of completion, by the thread that compiled it.
        """

        def work(unit: Unit) -> Compiled:
            compiled = self.compile(unit)
            if done is not None:
                done(compiled)
            return compiled

        with ThreadPoolExecutor(_processors()) as pool:
            return list(pool.map(work, units))

    def compile(self, unit: Unit) -> Compiled:
        """Compile one unit, or find what it was compiled to before."""
        flags = [flag if flag.startswith("-D") else self._anywhere(flag) for flag in unit.flags]
        source = str(unit.source) if unit.placed else self._anywhere(str(unit.source))
        key = digest_of([self._compiler.command, self._compiler.version, flags, source, self._scenery])
        key = f"object-{key}"
        if (kept := self._recall(unit, key)) is not None:
            return kept
        return self._compile(unit, key)

    def _anywhere(self, text: str) -> str:
        """Return a text without the place of the checkout."""
        return text if self._root is None else text.replace(self._root, _ROOT)

    def _here(self, text: str) -> str:
        """Return such a text with the place of this checkout."""
        return text if self._root is None else text.replace(_ROOT, self._root)

    def _recall(self, unit: Unit, key: str) -> Compiled | None:
        value = self._cache.recall(key, self._fingerprints, self._here) if self._may_recall else None
        if value is None:
            return None
        name = value["object"]
        path = self._cache.objects / name if name else None
        if path is not None:
            if not path.is_file():
                return None
            used(path)
        inputs = self._fingerprints.all_of(map(self._here, value["inputs"]))
        return Compiled(unit, value["ok"], self._here(value["output"]), inputs, path, from_cache=True)

    def _compile(self, unit: Unit, key: str) -> Compiled:
        temporary = self._cache.objects / f".{secrets.token_hex(8)}.o"
        listing = temporary.with_suffix(".d")
        what = ["-fsyntax-only"] if unit.syntax_only else ["-c", "-o", str(temporary)]
        command = [*self._compiler.command, *unit.flags, *self._naming, *what, str(unit.source)]
        self.commands.append(shlex.join(command))
        try:
            ran = run([*command, "-MD", "-MF", str(listing), "-MT", "x"])
            ok = ran.returncode == 0
            inputs = self._fingerprints.all_of(self._inputs(unit, listing))
            anywhere = {self._anywhere(name): content for name, content in inputs.items()}
            path = None
            if ok and not unit.syntax_only:
                path = self._cache.objects / f"{digest(key, digest_of(anywhere))}.o"
                temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
            listing.unlink(missing_ok=True)
        # a failure may have other reasons than the sources, a full disk for instance
        if (ok or unit.syntax_only) and not self._fingerprints.changed_meanwhile(inputs):
            name = path.name if path is not None else None
            output = self._anywhere(ran.stderr)
            self._cache.remember(
                key, anywhere, {"ok": ok, "output": output, "object": name, "inputs": sorted(anywhere)}
            )
        return Compiled(unit, ok, ran.stderr, inputs, path)

    def _inputs(self, unit: Unit, listing: Path) -> list[str]:
        """Return the files that the compiler read."""
        if listing.is_file():
            return [str(unit.source), *read_dependencies(listing.read_text(encoding="utf-8"))]
        # a header is missing: ask for those that there are
        asked = run([*self._compiler.command, *unit.flags, "-M", "-MG", "-MT", "x", str(unit.source)])
        return [str(unit.source), *(path for path in read_dependencies(asked.stdout) if Path(path).is_file())]


_ESCAPED = re.compile(r"\\([ #\\:])")


def read_dependencies(text: str) -> list[str]:
    """Return the files of a rule for make, as compilers write it: spaces and some signs are escaped."""
    _, _, listed = text.replace("\\\n", " ").partition(": ")
    words = re.findall(r"(?:\\[ #\\:]|[^\s])+", listed)
    return [str(Path(_ESCAPED.sub(r"\1", word).replace("$$", "$")).absolute()) for word in words]


def demand_all(results: Sequence[Compiled]) -> None:
    """Raise what the compiler printed, of all failing files, if there are any.

    Raises:
        CompileError: Its text begins with one line that counts the files.
    """
    failed = [result for result in results if not result.ok]
    if not failed:
        return
    count = "1 file does" if len(failed) == 1 else f"{len(failed)} files do"
    # a compiler that was killed prints nothing
    texts = [result.output.rstrip() or f"{result.unit.source}: the compiler gave up silently" for result in failed]
    raise CompileError("\n".join([f"{count} not compile:", *texts]))


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
