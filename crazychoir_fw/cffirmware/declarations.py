"""What a checkout's headers declare, asked of the compiler.

The builtin provider has the newest form of everything that the module knows, with upstream's names. Each struct, each
member, function and constant of it becomes a line of C; the lines that do not compile are what this checkout lacks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.cffirmware.constants import NAMES as CONSTANTS
from crazychoir_fw.cffirmware.function_table import FUNCTIONS
from crazychoir_fw.cffirmware.functions import CANONICAL, GLOBALS
from crazychoir_fw.cffirmware.structs import EXTRA_NAMES, HIDDEN, NAMES, TAGGED

Ask = Callable[[str, list[str]], set[int]]
"""Takes a text that includes headers and lines of C; returns the numbers of the lines that do not compile."""

# signatures that differ between releases: a function that only the newer form compiles; @ is its name
FEATURES = {
    "LINEAR": "int @(struct planner *p, struct vec v) { return plan_go_to(p, 0, 0, v, 0, 0, 0); }",
    "RELATIVE_YAW": "int @(struct planner *p, struct piecewise_traj *j, struct vec v) "
    "{ return plan_start_trajectory(p, j, 0, 0, 0, v, 0); }",
    "PREDICT_PARAMS": "void @(kalmanCoreData_t *c, kalmanCoreParams_t *p, Axis3f *a) "
    "{ kalmanCorePredict(c, p, a, a, 0, 0); }",
    "MATRIX_UPDATES": "void @(kalmanCoreData_t *c, arm_matrix_instance_f32 *m) "
    "{ kalmanCoreScalarUpdate(c, m, 0, 0); kalmanCoreUpdateWithPKE(c, m, m, m, 0); }",
    "CAP_RESULT": "int @(motors_thrust_uncapped_t *u, motors_thrust_pwm_t *p) { return powerDistributionCap(u, p); }",
}

# has no name in some releases, so it is written out where it stands
_UNNAMED = "setpoint_mode_t"

# members of builtin that upstream's structs lack, or have in another form; and the other way round
_OURS = HIDDEN | {("piecewise_traj_compressed", "size"), ("piecewise_traj_compressed", "current_piece")}
_THEIRS = {"controllerLee_t": ("qr", "struct vec")}

_HEADER = "cffi/cffirmware_bitcraze.h"


class _Piece(NamedTuple):
    """Some lines of the declarations that are there or not."""

    text: str
    question: str | None = None
    """A function that compiles if they are; None: no question."""


def features(ask: Ask) -> dict[str, bool]:
    """Return the name of each feature and whether the checkout has it."""
    lacking = ask('#include "cffi/cffirmware_headers.h"\n', _named(FEATURES.values()))
    return {name: number not in lacking for number, name in enumerate(FEATURES)}


def declarations_of(bindings: Path, ask: Ask) -> str:
    """Return the declarations that hold for a checkout, in the form that cffi reads.

    Args:
        bindings: Folder of the C side.
        ask: Asks the compiler about the checkout.
    """
    listed = _listed()
    structs = [list(_struct(c_type, name, listed)) for c_type, name in _in_order(listed)]
    others = [*_functions(bindings, listed), *_constants()]
    missing = _missing([*chain.from_iterable(structs), *others], ask)
    # the first piece of a struct asks for all of it
    kept = [piece for struct in structs if struct[0] not in missing for piece in struct] + others
    return "\n".join(piece.text for piece in kept if piece not in missing) + "\n"


def _named(questions: Iterable[str]) -> list[str]:
    return [question.replace("@", f"cf_ask_{number}") for number, question in enumerate(questions)]


def _missing(pieces: list[_Piece], ask: Ask) -> set[_Piece]:
    """Return the pieces that the checkout lacks."""
    asked = [piece for piece in pieces if piece.question]
    lacking = ask(f'#include "{_HEADER}"\n', _named(piece.question or "" for piece in asked))
    return {asked[number] for number in lacking}


def _listed() -> dict[Any, str]:
    """Return the types that are declared by name, and their names."""
    names = [name for name in (*NAMES, *EXTRA_NAMES) if name != _UNNAMED]
    return {ffi.typeof(f"struct {name}" if name in TAGGED else name): name for name in names}


def _in_order(listed: dict[Any, str]) -> Iterator[tuple[Any, str]]:
    """Return types and names, those that others are made of first."""
    found: dict[Any, str] = {}

    def visit(c_type: Any) -> None:
        while c_type.kind == "array":
            c_type = c_type.item
        if c_type.kind in ("struct", "union") and c_type not in found:
            for _, field in c_type.fields:
                visit(field.type)
            if c_type in listed:
                found[c_type] = listed[c_type]

    for c_type in listed:
        visit(c_type)
    return iter(found.items())


def _struct(c_type: Any, name: str, listed: dict[Any, str]) -> Iterator[_Piece]:
    full = f"struct {name}" if name in TAGGED else name
    yield _Piece(
        f"{full} {{" if name in TAGGED else f"typedef {c_type.kind} {{", f"int @(void) {{ return sizeof({full}); }}"
    )
    fields = [(member, field.type) for member, field in c_type.fields if (name, member) not in _OURS]
    if name in _THEIRS:
        member, kind = _THEIRS[name]
        fields.append((member, ffi.typeof(kind)))
    yield from _members(fields, full, "", listed)
    yield _Piece("  ...;\n};" if name in TAGGED else f"  ...;\n}} {name};")


def _members(fields: list[tuple[str, Any]], full: str, around: str, listed: dict[Any, str]) -> Iterator[_Piece]:
    for member, kind in fields:
        if kind.kind in ("struct", "union") and kind not in listed:
            yield _Piece(f"  {kind.kind} {{")
            inner = [(name, field.type) for name, field in kind.fields]
            yield from _members(inner, full, f"{around}{member}.", listed)
            yield _Piece(f"  }} {member};")
            continue
        # lengths are the compiler's to say, and Python follows pointers to structs only
        is_opaque = kind.kind == "function" or (kind.kind == "pointer" and kind.item not in listed)
        text = f"void *{member}" if is_opaque else re.sub(r"\[\d+\]", "[...]", _declared(kind, member, listed))
        yield _Piece(f"  {text};", f"int @(void) {{ return offsetof({full}, {around}{member}); }}")


def _declared(c_type: Any, name: str, listed: dict[Any, str]) -> str:
    """Return the declaration of a member or a parameter."""
    if c_type.kind == "enum":
        return f"int {name}"
    item = c_type
    while item.kind in ("array", "pointer"):
        item = item.item
    text = ffi.getctype(c_type, name)
    # a struct may have a tag beside the name that is listed
    return text.replace(item.cname, listed[item]) if item in listed and listed[item] not in TAGGED else text


def _functions(bindings: Path, listed: dict[Any, str]) -> Iterator[_Piece]:
    adapted = set(re.findall(rf"{CANONICAL}(\w+)\(", (bindings / _HEADER).read_text(encoding="utf-8")))
    for name in (*(function.name for function in FUNCTIONS), "piecewise_compressed_load"):
        yield _function(name, CANONICAL + name if name in adapted else name, listed)
    yield _Piece(f"const char *{CANONICAL}take_assertion(void);")


def _constants() -> Iterator[_Piece]:
    for name in (*CONSTANTS, "CF_UPSTREAM_HAS_LINEAR", "CF_UPSTREAM_HAS_RELATIVE_YAW"):
        yield _Piece(f"#define {name} ...", f"long @(void) {{ return {name}; }}")


def _function(name: str, theirs: str, listed: dict[Any, str]) -> _Piece:
    c_type = ffi.typeof(getattr(lib, CANONICAL + name, None) or getattr(lib, name))
    parameters = [parameter for parameter in c_type.args if not parameter.cname.startswith(GLOBALS)]
    names = [f"a{number}" for number in range(len(parameters))]
    declared = ", ".join(map(lambda *one: _declared(*one, listed), parameters, names)) or "void"
    result = _declared(c_type.result, "", listed)
    call = f"{theirs}({', '.join(names)});"
    body = call if c_type.result.kind == "void" else f"return {call}"
    return _Piece(f"{result} {theirs}({declared});", f"{result} @({declared}) {{ {body} }}")
