"""What a checkout's API has: small sources that compile or do not.

Releases differ in signatures and members. Each file HAVE_*.c of the adapter uses one of them; whether it compiles
becomes a macro of the same name, 1 or 0, for the adapter's own sources.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from crazychoir_fw.firmware.objects import Compiled, Unit


def probe_units(probes: Iterable[Path], flags: Sequence[str]) -> list[Unit]:
    """Return the units that ask; `flags` are those of the adapter."""
    # an implicit declaration is a feature that is missing, also where the compiler only warns
    asking = (*flags, "-Werror=implicit-function-declaration", "-Werror=incompatible-pointer-types")
    return [Unit(path, (*asking, "-Werror=int-conversion"), syntax_only=True) for path in probes]


def features(answers: Iterable[Compiled]) -> dict[str, bool]:
    """Return the name of each probe and whether the checkout has what it asks for."""
    return {answer.unit.source.stem: answer.ok for answer in answers}


def feature_flags(found: dict[str, bool]) -> list[str]:
    """Return the definitions for the adapter."""
    return [f"-D{name}={int(there)}" for name, there in sorted(found.items())]


def source_flag(prefix: str, path: Path) -> str:
    """Return the definition that tells the adapter that a source of the checkout is part of the library.

    ``mm_pose.c`` becomes ``-DCF_WITH_MM_POSE`` for the prefix ``CF_WITH``.
    """
    return f"-D{prefix}_{re.sub(r'[^A-Za-z0-9]', '_', path.stem).upper()}"
