"""What a checkout's headers declare, asked of the compiler.

`bindings/cffi/cffirmware.h` lists everything that any release has. Each piece becomes one line of a C file; the lines
that do not compile are what this checkout lacks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

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

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_STRUCT = re.compile(r"((?:typedef )?(?:struct|union)(?: \w+)?) \{\n(.*?)\n\}( \w+)?;", re.DOTALL)
_MEMBER = re.compile(r" .*?(\w+)(?:\[\d+\])*;")
_END_OF_NESTED = re.compile(r" +\} ?(\w*);")
_PROTOTYPE = re.compile(r"((?:const )?(?:struct )?\w+[ *]+)(\w+)\(([^;{}]*)\);", re.DOTALL)
_CONSTANT = re.compile(r"#define (\w+) \.\.\.")
_PARAMETER_NAME = re.compile(r"(\w+)(?:\[\d*\])*$")


@dataclass(frozen=True)
class _Piece:
    """Some lines of the declarations that are there or not."""

    text: str
    question: str | None
    """A function that compiles if they are; None: no question."""


def features(ask: Ask) -> dict[str, bool]:
    """Return the name of each feature and whether the checkout has it."""
    lacking = ask('#include "cffi/cffirmware_headers.h"\n', _named(FEATURES.values()))
    return {name: number not in lacking for number, name in enumerate(FEATURES)}


def declarations_of(text: str, ask: Ask) -> str:
    """Return the declarations that hold for a checkout, in the form that cffi reads.

    Args:
        text: That of cffirmware.h.
        ask: Asks the compiler about the checkout.
    """
    text = _COMMENT.sub("", text)
    structs = [_struct(*match.groups(default="")) for match in _STRUCT.finditer(text)]
    rest = _STRUCT.sub("", text)
    others = [_function(match) for match in _PROTOTYPE.finditer(rest)]
    others += [_Piece(match[0], f"long @(void) {{ return (long){match[1]}; }}") for match in _CONSTANT.finditer(rest)]
    pieces = [piece for struct in structs for piece in struct] + others

    asked = [piece for piece in pieces if piece.question is not None]
    lacking = ask('#include "cffi/cffirmware_bitcraze.h"\n', _named(piece.question or "" for piece in asked))
    missing = {id(asked[number]) for number in lacking}
    # the first piece of a struct asks for all of it
    kept = [piece for struct in structs if id(struct[0]) not in missing for piece in struct] + others
    return "\n".join(piece.text for piece in kept if id(piece) not in missing) + "\n"


def _named(questions: Iterable[str]) -> list[str]:
    return [question.replace("@", f"cf_ask_{number}") for number, question in enumerate(questions)]


def _struct(head: str, body: str, alias: str) -> list[_Piece]:
    name, lines = alias.strip() or head, body.split("\n")
    pieces = [_Piece(f"{head} {{", f"int @(void) {{ return (int)sizeof({name}); }}")]
    for line, member in zip(lines, _members(lines), strict=True):
        question = f"int @(void) {{ return (int)offsetof({name}, {member}); }}" if member else None
        pieces.append(_Piece(re.sub(r"\[\d+\]", "[...]", line), question))
    return [*pieces, _Piece(f"  ...;\n}}{alias};", None)]


def _members(lines: list[str]) -> list[str | None]:
    """Return the member that each line of a struct declares, with those around it; None: it declares none."""
    around: list[str] = []
    found: list[str | None] = []
    # the name of a nested struct follows its members
    for line in reversed(lines):
        member = None
        if end := _END_OF_NESTED.fullmatch(line):
            around.append(f"{end[1]}." if end[1] else "")
        elif line.endswith("{"):
            around.pop()
        elif declared := _MEMBER.fullmatch(line):
            member = "".join([*around, declared[1]])
        found.append(member)
    return found[::-1]


def _function(match: re.Match[str]) -> _Piece:
    result, name, parameters = match[1].strip(), match[2], " ".join(match[3].split())
    names = [] if parameters == "void" else [_PARAMETER_NAME.search(one)[1] for one in parameters.split(",")]  # type: ignore[index]
    call = f"{name}({', '.join(names)});"
    return _Piece(
        " ".join(match[0].split()), f"{result} @({parameters}) {{ {call if result == 'void' else f'return {call}'} }}"
    )
